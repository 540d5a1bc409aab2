//! Narrow phase: from two posed hulls to the contact points between them.
//!
//! A query has two halves. The first finds the axis along which the hulls overlap least (or are farthest apart), and
//! comes in two interchangeable versions behind [`Separator`]: `reference`, the GJK and EPA of the parry library, and
//! `twin`, the separating-axis search that the shader runs. The second, `manifold`, clips face polygons against each
//! other and is shared. All normals point from A to B; a separation is negative where the hulls overlap.

mod manifold;
mod passing;
mod plane;
mod reduce;
mod reference;
mod twin;
mod twin_tables;

pub use manifold::manifold;
pub use passing::passes;
pub use plane::plane_hull;
pub use reduce::{Selection, reduce, tangents};
pub use reference::Reference;
pub use twin::Twin;
pub(crate) use twin_tables::{TwinHull, TwinTables};

use crate::world::constants::{GROUND_PENALTY, MAX_MANIFOLD_POINTS};
use crate::world::{Hull, HullTables, NarrowPhase, Pose, compose};
use bytemuck::{Pod, Zeroable};
use glam::{Mat3, Vec3};

/// Two hulls in the world.
#[derive(Clone, Copy, Debug)]
pub struct HullPair<'a> {
    /// The tables of both.
    pub tables: &'a HullTables,
    /// Hull A and hull B, indices into `tables.hulls`.
    pub hulls: [u32; 2],
    /// Poses of the bodies of A and B.
    pub poses: [&'a Pose; 2],
    /// How far the body of A and that of B can be pushed down before the ground counts, m; see `HullPair::worth`.
    pub room: [f32; 2],
}

impl HullPair<'_> {
    /// `room` of bodies that may be pushed anywhere.
    pub const ANY_ROOM: [f32; 2] = [f32::MAX; 2];

    /// What a distance along an axis (from A to B, A's frame) is worth beside others, m: where parting the hulls would
    /// lead too far into the ground, the longer way along it counts, which has no end if the axis is upright.
    fn worth(&self, axis: Vec3, distance: f32) -> f32 {
        if self.room == Self::ANY_ROOM {
            return distance;
        }
        let rise = (self.poses[0].rotation * axis).y;
        if -distance * rise.abs() <= self.room[usize::from(rise < 0.0)] {
            return distance;
        }
        distance / (1.0 - rise * rise).max(0.0).sqrt().max(1.0 / GROUND_PENALTY)
    }

    /// Hull A (0) or B (1).
    fn hull(&self, side: usize) -> &Hull {
        &self.tables.hulls[self.hulls[side] as usize]
    }

    /// The side whose faces are preferred as axis and reference face: the larger hull, so that a book lies on the table
    /// and not the table on the book.
    fn larger(&self) -> usize {
        usize::from(self.hull(1).radius > self.hull(0).radius)
    }

    /// Rotation and shift that take points of the other body's frame into the frame of the body of `side`.
    fn other_to(&self, side: usize) -> (Mat3, Vec3) {
        let (to, from) = (self.poses[side], self.poses[1 - side]);
        let back = to.rotation.conjugate();
        (Mat3::from_quat(compose(back, from.rotation)), back * (from.translation - to.translation))
    }
}

/// What a separating axis is made of. Numbers are local to the hulls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Feature {
    /// The normal of a face of A.
    FaceA(u32),
    /// The normal of a face of B, turned round.
    FaceB(u32),
    /// The common normal of an edge of A and an edge of B.
    Edges(u32, u32),
    /// An axis without features, with the points nearest (or deepest) along it, world frame, m.
    Points {
        /// On the surface of A.
        on_a: Vec3,
        /// On the surface of B.
        on_b: Vec3,
    },
}

/// The axis along which two hulls are farthest apart, or overlap least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// Gap along the axis, m; negative: depth. For hulls apart it never exceeds their distance.
    pub distance: f32,
    /// Unit axis, world frame, from A to B.
    pub normal: Vec3,
    /// Where the axis comes from.
    pub feature: Feature,
}

/// One contact point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ManifoldPoint {
    /// On the surface of A, world frame, m.
    pub on_a: Vec3,
    /// On the surface of B, world frame, m.
    pub on_b: Vec3,
    /// Gap between them along the manifold's normal, m; negative: depth.
    pub separation: f32,
}

/// The contact points of one pair.
#[derive(Clone, Copy, Debug)]
pub struct Manifold {
    /// Unit, world frame, from A to B.
    pub normal: Vec3,
    /// How many of `slots` are in use.
    pub count: u32,
    /// The points, then unused slots.
    pub slots: [ManifoldPoint; MAX_MANIFOLD_POINTS],
}

impl Default for Manifold {
    fn default() -> Self {
        const EMPTY: ManifoldPoint = ManifoldPoint { on_a: Vec3::ZERO, on_b: Vec3::ZERO, separation: 0.0 };
        Self { normal: Vec3::ZERO, count: 0, slots: [EMPTY; MAX_MANIFOLD_POINTS] }
    }
}

impl Manifold {
    /// The contact points.
    pub fn points(&self) -> &[ManifoldPoint] {
        &self.slots[..self.count as usize]
    }
}

/// The last axis of a hull pair, tried first in the next step. Zero: none. It only saves time, except that a shallow
/// contact (`COHERENT_DEPTH`) keeps its axis.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct PairCache(u32);

impl PairCache {
    /// Remembers the feature; one without numbers is forgotten.
    fn store(feature: Feature) -> Self {
        Self(match feature {
            Feature::FaceA(i) => 1 << 24 | i,
            Feature::FaceB(j) => 2 << 24 | j,
            Feature::Edges(i, j) => 3 << 24 | i << 12 | j,
            Feature::Points { .. } => 0,
        })
    }

    fn feature(self) -> Option<Feature> {
        let (first, second) = (self.0 >> 12 & 0xfff, self.0 & 0xfff);
        match self.0 >> 24 {
            1 => Some(Feature::FaceA(second)),
            2 => Some(Feature::FaceB(second)),
            3 => Some(Feature::Edges(first, second)),
            _ => None,
        }
    }
}

/// The hull–hull query in its two versions.
#[derive(Clone, Debug)]
pub enum Separator {
    /// GJK and EPA of the parry library.
    Reference(Reference),
    /// Separating axes.
    Twin(Twin),
}

impl Separator {
    /// Prepares the version `kind` for the hulls of a world.
    pub fn new(kind: NarrowPhase, tables: &HullTables) -> Self {
        match kind {
            NarrowPhase::Reference => Self::Reference(Reference),
            NarrowPhase::Twin => Self::Twin(Twin::new(tables)),
        }
    }

    /// The axis of least overlap, or `None` if the hulls are farther apart than `margin` (m, ≥ 0) or a pose is not
    /// finite. For hulls apart the distance is a lower bound (`twin`) or exact (`reference`). The tables must be those
    /// that `new` saw. `cache` belongs to this pair and starts as zero.
    pub fn separation(&self, pair: &HullPair, margin: f32, cache: &mut PairCache) -> Option<Separation> {
        match self {
            Self::Reference(reference) => reference.separation(pair, margin),
            Self::Twin(twin) => twin.separation(pair, margin, cache),
        }
    }

    /// How deep the hulls overlap, m: the shortest shift that parts them. 0 if that is at most `ignored` (m, ≥ 0).
    pub fn depth(&self, pair: &HullPair, ignored: f32) -> f32 {
        match self {
            Self::Reference(reference) => reference.depth(pair, ignored),
            Self::Twin(twin) => twin.depth(pair, ignored),
        }
    }
}
