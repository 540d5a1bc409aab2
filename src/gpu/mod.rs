//! The GPU backend: the kernels of `shaders/`, and what runs them on any adapter that wgpu reaches. `raster` draws
//! pictures by the shaders of `shaders/raster/`.
//!
//! A kernel `NAME` is `shaders/NAME.wgsl`; its twin is `src/cpu/NAME.rs`, or what its first lines name. The build
//! generates a struct of all kernels and one struct of buffers for each; `docs/gpu.md` says how the next one is
//! written. Nothing of wgpu is visible outside this folder.

mod adapter;
mod backend;
mod buffer;
mod collide;
mod contacts;
mod device;
mod funnel;
mod kernel;
pub mod kernels;
mod layout;
mod pipelines;
mod plan;
mod population;
mod raster;
mod raster_pipelines;
mod rollouts;
mod search;
mod self_test;
mod simulation;
mod solver;
mod tables;
mod timer;

pub use adapter::{AdapterChoice, AdapterKind, AdapterReport, adapters};
pub use backend::GpuBackend;
pub use buffer::{Buffer, Download, Read, Uniform, Write};
pub use collide::{Collide, Motion};
pub use contacts::{Contacts, Inputs};
pub use device::{Gpu, GpuError, INSTALL_HINT, Options};
pub use funnel::Funnel;
pub use kernel::{Access, Kernel, Recorder, Shader, Slot, Step};
pub use kernels::{Kernels, SHADERS};
pub use layout::{
    Arms, Axes, Ball, Batch, Bounds, Contact, Draw, Facing, Flags, Free, Friction, Gap, HullPair, Levers, Manifold,
    ManifoldPoint, Mark, Merged, Moving, Normal, Outline, Patch, Portion, Preference, Separation, Sim, Stats, Update,
    Weights,
};
pub use pipelines::identity;
pub use plan::{Room, plan};
pub use population::Population;
pub use raster::GpuPainter;
pub use search::GpuSearch;
pub use self_test::self_test;
pub use simulation::{Pace, Simulation, State};
pub use solver::{Solver, Touching, Way, rounds};
pub use tables::Tables;
pub use timer::Timer;
