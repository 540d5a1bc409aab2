//! The structs that kernels read and write, under the names that they have in the shaders. That their layouts agree is
//! checked at compile time.

use super::kernels::constants;
use crate::world::{EnergyWeights, PenetrationMode, STATIC, Status, Stream, World};
use bytemuck::{Pod, Zeroable};

pub use crate::world::{Body, Energy, Pose, Unit, Velocity, Winner};

/// Sizes of the batch.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Batch {
    /// Candidates, K.
    pub candidates: u32,
    /// Bodies of a candidate.
    pub bodies: u32,
    /// Body pairs of a candidate.
    pub pairs: u32,
    /// Search dimensions, six a unit.
    pub dimensions: u32,
}

impl Batch {
    /// So many copies of a world.
    pub fn new(world: &World, candidates: u32) -> Self {
        Self {
            candidates,
            bodies: world.bodies.len() as u32,
            pairs: world.pairs.len() as u32,
            dimensions: world.dimensions() as u32,
        }
    }
}

/// Names the random numbers of one iteration.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Draw {
    /// Low half of the seed.
    pub key_low: u32,
    /// High half of the seed.
    pub key_high: u32,
    /// Number of the group in the run.
    pub stage: u32,
    /// Iteration since the search began.
    pub iteration: u32,
    /// 1: candidate 0 is the mean itself.
    pub sample_mean: u32,
}

impl Draw {
    /// One iteration of a stream.
    pub fn new(stream: Stream, iteration: u32, sample_mean: bool) -> Self {
        Self {
            key_low: stream.seed as u32,
            key_high: (stream.seed >> 32) as u32,
            stage: stream.stage,
            iteration,
            sample_mean: sample_mean.into(),
        }
    }
}

/// Weights of the energy.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Weights {
    /// λ_stab
    pub stability: f32,
    /// λ_vel
    pub velocity: f32,
    /// λ_pen
    pub penetration: f32,
    /// λ_layout
    pub layout: f32,
    /// λ_pos
    pub position: f32,
    /// 0 counts pairs, 1 measures depth.
    pub penetration_mode: u32,
    /// Depth that costs as much as a pair, m.
    pub depth_unit: f32,
}

impl From<&EnergyWeights> for Weights {
    fn from(weights: &EnergyWeights) -> Self {
        Self {
            stability: weights.stability,
            velocity: weights.velocity,
            penetration: weights.penetration,
            layout: weights.layout,
            position: weights.position,
            penetration_mode: match weights.penetration_mode {
                PenetrationMode::Count => 0,
                PenetrationMode::Depth => 1,
            },
            depth_unit: weights.penetration_depth_unit,
        }
    }
}

/// How the distribution follows the elites.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Update {
    /// ⌈ρK⌉
    pub wanted: u32,
    /// Added to every deviation, m and rad.
    pub epsilon: f32,
}

// Constants that the shaders name themselves, because their Rust types are none of WGSL's.
const _: () = {
    assert!(constants::STATIC == STATIC);
    assert!(constants::STATUS_HULL_PAIRS == Status::HULL_PAIRS.0);
    assert!(constants::STATUS_CONTACTS == Status::CONTACTS.0);
    assert!(constants::STATUS_NOT_FINITE == Status::NOT_FINITE.0);
    assert!(constants::STATUS_ITERATIONS == Status::ITERATIONS.0);
    assert!(constants::INFINITY_BITS == f32::INFINITY.to_bits());
};
