//! What both backends simulate: static tables made once per group, start poses in, trajectories and energies out.
//!
//! The world is the same in every candidate; only poses differ. Everything that depends on shape or topology (hull
//! tables, body pairs, units, capacities) is built here once and shared read-only by all candidates.

mod backend;
mod body;
pub mod constants;
mod hulls;
mod memory;
mod outline;
mod polygons;
mod pose;
mod rollouts;
mod settings;
mod status;

pub use backend::{
    Backend, BackendError, Best, Distribution, Energy, Flow, IterationStats, OnCandidate, OnStep, Search,
    SearchSettings, Stream, Winner,
};
pub use body::{Body, BodyDef, Capacities, STATIC, Unit, World};
pub use hulls::{Edge, Face, Hull, HullTables};
pub use memory::{MemoryPlan, free_memory};
pub use outline::Outline;
pub use pose::{Pose, Velocity, angle_between, compose, from_scaled_axis, sin_cos_quarters, unit_rotation};
pub use rollouts::{KernelTime, Rollouts};
pub use settings::{CemSettings, EnergyWeights, NarrowPhase, PenetrationMode, Round, SimSettings};
pub use status::{Fault, Status};
