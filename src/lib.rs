//! Turns a reconstructed 3D scene into one that stands still in a physics engine.
//!
//! The flow is one-way: `scene` (the document) → `shape` (convex parts and mass) → `canonicalize` (what is up, where
//! the ground is) → `world` (what a backend simulates), `render` (what a picture shows) → `cpu`, `gpu` (the simulators
//! and painters) → `optimize` (the search) → `metrics` (quality), `bench` (speed) → `ablate` (what each idea is worth)
//! → `report`. Nothing below `commands` prints.

pub mod ablate;
pub mod bench;
pub mod canonicalize;
pub mod cpu;
pub mod files;
pub mod gpu;
pub mod import;
pub mod metrics;
pub mod optimize;
pub mod render;
pub mod report;
pub mod scene;
pub mod shape;
pub mod world;
