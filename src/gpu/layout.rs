//! The structs that kernels read and write, under the names that they have in the shaders. That their layouts agree is
//! checked at compile time.

use super::kernels::constants;
use crate::cpu::narrow_phase::{TwinHull, TwinTables};
use crate::world::constants::{AXIS_BIAS, AXIS_BIAS_RELATIVE};
use crate::world::{
    Capacities, EnergyWeights, HullTables, PenetrationMode, STATIC, SimSettings, Status, Stream, World,
};
use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};

pub use crate::world::{Body, Edge, Energy, Face, Hull, Pose, Unit, Velocity, Winner};

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
    /// Relaxing sweeps at the end of a substep, and one.
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

/// Axis-aligned box of a hull or a body.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Bounds {
    /// World, m.
    pub center: Vec3,
    /// Half the distance to an equal body at which contacts are made, m.
    pub margin: f32,
    /// Half extents, m.
    pub half_extents: Vec3,
    /// 1 if the body keeps its contacts with others that keep theirs; of bodies' boxes only.
    pub is_still: u32,
}

impl Bounds {
    /// A box with the margin of its body.
    pub fn new(center: Vec3, half_extents: Vec3, margin: f32) -> Self {
        Self { center, margin, half_extents, is_still: 0 }
    }
}

/// Where a body was when its contacts were last found; all zero if they never were.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Mark {
    /// Unit quaternion.
    pub rotation: Quat,
    /// m
    pub translation: Vec3,
    /// Its margin then, m.
    pub margin: f32,
}

/// Ball inside a hull, for the search of separating axes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Ball {
    /// Body frame, m.
    pub center: Vec3,
    /// m
    pub radius: f32,
    /// How far a face's plane may lie outside its own edges, m.
    pub slack: f32,
    pad: [u32; 3],
}

impl Ball {
    /// One ball a hull.
    pub fn all(hulls: &HullTables) -> Vec<Self> {
        let tables = TwinTables::new(hulls);
        let ball =
            |hull: &TwinHull| Self { center: hull.center, radius: hull.inner_radius, slack: hull.slack, pad: [0; 3] };
        tables.hulls.iter().map(ball).collect()
    }
}

/// Which of two nearly equal axes is chosen: by how much faces of the larger hull are preferred to the other's, and
/// faces to edges.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Preference {
    /// m
    pub bias: f32,
    /// Share of the depth.
    pub relative: f32,
}

impl Preference {
    /// For contacts.
    pub const CONTACT: Self = Self { bias: AXIS_BIAS, relative: AXIS_BIAS_RELATIVE };
    /// For depths.
    pub const NONE: Self = Self { bias: 0.0, relative: 0.0 };
}

/// Two hulls whose boxes overlap.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct HullPair {
    /// Index into `World::pairs`.
    pub pair: u32,
    /// Hull of the pair's first body.
    pub a: u32,
    /// Hull of the pair's second body.
    pub b: u32,
    /// Feature of the last substep's axis, coded as `cpu::narrow_phase::PairCache`.
    pub cache: u32,
}

/// The axis of a hull pair.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Separation {
    /// Unit, from A to B, world.
    pub normal: Vec3,
    /// Gap along the axis, m; negative: depth.
    pub distance: f32,
    /// Coded as `HullPair::cache`; 0: farther apart than the margin.
    pub feature: u32,
    pad: [u32; 3],
}

impl Separation {
    /// The axis of hulls that are near.
    pub fn new(normal: Vec3, distance: f32, feature: u32) -> Self {
        Self { normal, distance, feature, pad: [0; 3] }
    }
}

/// Head of a hull pair's contact points.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Manifold {
    /// Unit, from A to B, world.
    pub normal: Vec3,
    /// Points in use.
    pub count: u32,
}

/// A contact point of a hull pair.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ManifoldPoint {
    /// On the surface of A, world, m.
    pub on_a: Vec3,
    /// m
    pub separation: f32,
    /// On the surface of B, world, m.
    pub on_b: Vec3,
    pad: u32,
}

/// How the two hulls of a pair face each other.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Facing {
    /// Bodies of A and B.
    pub bodies: [u32; 2],
    /// Hulls A and B.
    pub hulls: [u32; 2],
    /// The reference face and the other hull's face that is turned against it, numbers within the hulls.
    pub faces: [u32; 2],
    /// 0 or 1: A or B has the reference face; 2: no face is aligned; 3: too far apart.
    pub side: u32,
    /// Distance within which contacts are made, m.
    pub margin: f32,
}

/// Where a face's lines are in the table of lines.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Outline {
    /// First of the outline's lines; the planes of the faces that bear with it follow.
    pub first: u32,
    /// Number of lines.
    pub lines: u32,
    /// Number of planes.
    pub bearing: u32,
}

/// What is left of the contact points of a body pair, or of a body and the ground.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Merged {
    /// Points of each patch, eight bits a patch.
    pub sizes: u32,
    /// Where the numbers of its points begin; `u32::MAX` if it keeps its contacts.
    pub first: u32,
}

/// Contact points of two bodies in about one direction.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Patch {
    /// Unit, from `a` to `b`, world.
    pub normal: Vec3,
    /// Index into `World::pairs`; past its end, the body's contact with the ground.
    pub pair: u32,
    /// Tangential impulse on `b` of the last small step, world, N s.
    pub friction: Vec3,
    /// Angular impulse about the normal on `b` of the last small step, N m s.
    pub twist: f32,
    /// First body, or `cpu::contacts::GROUND`.
    pub a: u32,
    /// Second body.
    pub b: u32,
    /// First of its points.
    pub first: u32,
    /// Number of its points.
    pub count: u32,
}

/// A contact point of a patch.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Contact {
    /// Unit, from the first body to the second, world.
    pub normal: Vec3,
    /// m; negative: overlap.
    pub separation: f32,
    /// Middle between the two surfaces, world, m.
    pub point: Vec3,
    /// Normal impulse of the last small step, N s.
    pub impulse: f32,
    /// The point in the frame of the first body (the world for the ground), m.
    pub anchor_a: Vec3,
    /// Load carried on average lately, N s a small step.
    pub load: f32,
    /// The point in the frame of the second body, m.
    pub anchor_b: Vec3,
    /// The separation when the point was found, m.
    pub found: f32,
}

/// How many candidates have each bit of `world::Status` set.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Flags {
    /// In the order of `Status::NAMES`.
    pub counts: [u32; Status::NAMES.len()],
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

/// State of a body while a substep is solved.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Moving {
    /// m/s
    pub linear: Vec3,
    /// 1 / kg, 0 if static.
    pub inverse_mass: f32,
    /// rad/s
    pub angular: Vec3,
    /// 1 if it has contacts, or may come to touch something.
    pub touched: u32,
    /// Since the substep's start, m.
    pub shift: Vec3,
    /// The number of the last sweep of the small step in which its contacts are solved.
    pub restless: u32,
    /// Since the substep's start, rad.
    pub turn: Vec3,
    pad1: u32,
    /// First column of the world inverse inertia, 1 / (kg m²).
    pub inertia_x: Vec3,
    pad2: u32,
    /// Second column.
    pub inertia_y: Vec3,
    pad3: u32,
    /// Third column.
    pub inertia_z: Vec3,
    pad4: u32,
}

/// A contact point while a substep is solved.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Normal {
    /// Unit, from the first body to the second, world.
    pub axis: Vec3,
    /// Effective mass, kg.
    pub mass: f32,
    /// Lever arm on the first body × axis, m.
    pub angular_a: Vec3,
    /// At the substep's start, less the rest offset, m.
    pub separation: f32,
    /// Lever arm on the second body × axis, m.
    pub angular_b: Vec3,
    /// Distance from the patch's centre, m.
    pub lever: f32,
    /// Accumulated, N s.
    pub impulse: f32,
    /// After the last rigid sweep, N s.
    pub rigid: f32,
    /// `Contact::load`
    pub load: f32,
    pad: u32,
}

/// Friction of a patch while a substep is solved.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Friction {
    /// Lever arm of the patch's centre on the first body, m.
    pub arm_a: Vec3,
    /// Effective mass along the first direction, kg.
    pub mass_u: f32,
    /// Lever arm of the patch's centre on the second body, m.
    pub arm_b: Vec3,
    /// Effective mass along the second direction, kg.
    pub mass_v: f32,
    /// How far the second body had moved past the first when the arms were made, m.
    pub passed: Vec3,
    /// Effective mass about the normal, kg m².
    pub mass_twist: f32,
    /// Accumulated along both directions, N s, and about the normal, N m s.
    pub impulse: Vec3,
    pad: u32,
}

/// How far the solver has come with a candidate's substep.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Cursor {
    /// Small steps that are done.
    pub step: u32,
    /// Sweeps of the present one that are done.
    pub sweep: u32,
    /// After how many sweeps it ends.
    pub end: u32,
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
