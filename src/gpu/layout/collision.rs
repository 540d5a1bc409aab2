//! What the kernels of collision detection keep.

use crate::cpu::narrow_phase::{TwinHull, TwinTables};
use crate::world::HullTables;
use crate::world::constants::{AXIS_BIAS, AXIS_BIAS_RELATIVE, GROUND_PENALTY};
use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};

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
/// faces to edges; and ways to the side to ways down.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Preference {
    /// m
    pub bias: f32,
    /// Share of the depth.
    pub relative: f32,
    /// Most times that a way along the ground is longer than one into it.
    pub ground: f32,
}

impl Preference {
    /// For contacts.
    pub const CONTACT: Self = Self { bias: AXIS_BIAS, relative: AXIS_BIAS_RELATIVE, ground: GROUND_PENALTY };
    /// For depths.
    pub const NONE: Self = Self { bias: 0.0, relative: 0.0, ground: 1.0 };
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
