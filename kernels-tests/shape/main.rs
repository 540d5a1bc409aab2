//! Convex parts, mass and cache, on the shared meshes.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

mod files;
mod fixture;
mod mass;
mod parts;
mod tables;
