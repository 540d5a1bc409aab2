//! The structs that kernels read and write, under the names that they have in the shaders. That their layouts agree is
//! checked at compile time.

mod collision;
mod solver;

use super::kernels::constants;
use crate::world::{
    Capacities, CemSettings, EnergyWeights, PenetrationMode, STATIC, SimSettings, Status, Stream, World,
};
use bytemuck::{Pod, Zeroable};

pub use crate::world::{Body, Edge, Energy, Face, Hull, Outline, Pose, Unit, Velocity, Winner};
pub use collision::*;
pub use solver::*;

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
    /// 1: candidates 2i and 2i + 1 mirror each other about the mean.
    pub antithetic: u32,
}

impl Draw {
    /// One iteration of a stream.
    pub fn new(stream: Stream, iteration: u32, cem: &CemSettings) -> Self {
        Self {
            key_low: stream.seed as u32,
            key_high: (stream.seed >> 32) as u32,
            stage: stream.stage,
            iteration,
            sample_mean: cem.sample_mean.into(),
            antithetic: cem.antithetic.into(),
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

/// Candidates that are simulated at a time, by rank.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Portion {
    /// Rank of the first.
    pub first: u32,
    /// How many.
    pub count: u32,
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

/// Parameters of the simulation.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Sim {
    /// Length of a substep, s.
    pub substep: f32,
    /// Length of a small step, s.
    pub small_step: f32,
    /// Small steps of a substep.
    pub small_steps: u32,
    /// `SimSettings::velocity_iterations`.
    pub velocity_iterations: u32,
    /// m
    pub contact_offset: f32,
    /// m
    pub rest_offset: f32,
    /// m/s²
    pub gravity: f32,
    /// m/s
    pub max_push_out: f32,
    /// 1/s
    pub linear_damping: f32,
    /// 1/s
    pub angular_damping: f32,
    /// Coulomb coefficient.
    pub friction: f32,
    /// Slots of a candidate for hull pairs.
    pub hull_pairs: u32,
    /// Slots of a candidate for patches, and as many for contact points.
    pub contacts: u32,
    /// How often all loops of an invocation together may go round.
    pub loops: u32,
}

impl Sim {
    /// The settings as the kernels read them.
    pub fn new(settings: &SimSettings, capacities: Capacities) -> Self {
        Self {
            substep: settings.substep(),
            small_step: settings.small_step(),
            small_steps: settings.position_iterations.max(1),
            velocity_iterations: settings.velocity_iterations,
            contact_offset: settings.contact_offset,
            rest_offset: settings.rest_offset,
            gravity: settings.gravity,
            max_push_out: settings.max_push_out,
            linear_damping: settings.linear_damping,
            angular_damping: settings.angular_damping,
            friction: settings.friction,
            hull_pairs: capacities.hull_pairs,
            contacts: capacities.contacts,
            loops: u32::MAX,
        }
    }
}

/// How many candidates have each bit of `world::Status` set.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Flags {
    /// In the order of `Status::FAULTS`.
    pub counts: [u32; Status::FAULTS.len()],
}

/// What an iteration reports.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Stats {
    /// The best ever.
    pub best: Energy,
    /// Total of this iteration's best.
    pub iteration_best: f32,
    /// Mean total of this iteration's elites.
    pub elite_mean: f32,
}

// Constants that the shaders name themselves, because their Rust types are none of WGSL's.
const _: () = {
    assert!(constants::STATIC == STATIC);
    assert!(constants::STATUS_HULL_PAIRS == Status::HULL_PAIRS.0);
    assert!(constants::STATUS_CONTACTS == Status::CONTACTS.0);
    assert!(constants::STATUS_NOT_FINITE == Status::NOT_FINITE.0);
    assert!(constants::STATUS_PASSED_OVER == Status::PASSED_OVER.0);
    assert!(constants::INFINITY_BITS == f32::INFINITY.to_bits());
};
