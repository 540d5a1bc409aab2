//! What the projection moves or goes round: objects that keep together, as their convex parts.

use super::tolerances::{MAX_ROOM, ROOM, TOUCHING};
use crate::optimize::{
    rig::Rig,
    sweep::{first_gap, overlap_interval},
};
use crate::scene::{Pose, Relation, Scene};
use glam::{DVec3, Vec3};
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::Pose as Isometry;
use parry3d::query::contact;
use parry3d::shape::ConvexPolyhedron;
use std::iter::once;

/// One convex part where it was before the projection.
struct Piece {
    object: usize,
    solid: ConvexPolyhedron,
    bounds: Aabb,
}

/// Objects that move as one.
pub(super) struct Unit {
    /// The object that bears the others.
    pub root: usize,
    /// All of them.
    pub objects: Vec<usize>,
    /// False for what is only gone round.
    pub moves: bool,
    /// Height of the lowest point, m.
    pub lowest: f32,
    pieces: Vec<Piece>,
    bounds: Aabb,
}

impl Unit {
    /// Objects where `layout` has them, the root first.
    pub fn new(objects: Vec<usize>, moves: bool, rigs: &[Rig], layout: &[Pose]) -> Self {
        Self::grown(objects, moves, rigs, layout, 0.0)
    }

    /// The same with its half of the room between it and others, sideways: the larger, the more.
    pub fn with_room(objects: Vec<usize>, moves: bool, rigs: &[Rig], layout: &[Pose]) -> Self {
        let unit = Self::new(objects, moves, rigs, layout);
        let size = Vec3 { y: 0.0, ..unit.bounds.extents() }.length();
        Self::grown(unit.objects, moves, rigs, layout, (ROOM * size).min(MAX_ROOM))
    }

    /// With parts that reach farther sideways by `room`, m.
    fn grown(objects: Vec<usize>, moves: bool, rigs: &[Rig], layout: &[Pose], room: f32) -> Self {
        let mut pieces = Vec::new();
        let aside: &[Vec3] = if room > 0.0 { &[Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z] } else { &[Vec3::ZERO] };
        for &object in &objects {
            let body = rigs[object].body(&layout[object]);
            for part in &rigs[object].parts {
                let grown = |&v: &Vec3| aside.iter().map(move |way| body.point(v) + room * *way);
                let points: Vec<Vec3> = part.iter().flat_map(grown).collect();
                if let Some(solid) = ConvexPolyhedron::from_convex_hull(&points) {
                    let bounds = solid.local_aabb();
                    pieces.push(Piece { object, solid, bounds });
                }
            }
        }
        let bounds = pieces.iter().fold(Aabb::new_invalid(), |all, piece| all.merged(&piece.bounds));
        Self { root: objects[0], objects, moves, lowest: bounds.mins.y, pieces, bounds }
    }

    /// Height of the middle of its box, m.
    pub fn middle(&self) -> f32 {
        0.5 * (self.bounds.mins.y + self.bounds.maxs.y)
    }

    /// True if a part overlaps one of `other` by more than touching after it was moved by `apart` against it.
    pub fn overlaps(&self, other: &Self, apart: DVec3, scene: &Scene) -> bool {
        let shift = apart.as_vec3();
        let near = |a: &Aabb, b: &Aabb| a.translated(shift).intersects(b);
        near(&self.bounds, &other.bounds)
            && self.pieces.iter().filter(|a| near(&a.bounds, &other.bounds)).any(|a| {
                other
                    .pieces
                    .iter()
                    .filter(|b| near(&a.bounds, &b.bounds))
                    .any(|b| !nested(scene, a.object, b.object) && deeper_than_touching(&a.solid, shift, &b.solid))
            })
    }

    /// How far it has to go along the unit vector `along` from `apart` until it is clear of `other`, m.
    pub fn exit(&self, other: &Self, apart: DVec3, along: Vec3, scene: &Scene) -> f32 {
        let shift = apart.as_vec3();
        let (there, here) = (Isometry::from_translation(shift), Isometry::IDENTITY);
        let mut overlaps: Vec<[f64; 2]> = Vec::new();
        for a in &self.pieces {
            let moved = a.bounds.translated(shift);
            for b in other.pieces.iter().filter(|b| !nested(scene, a.object, b.object)) {
                if meets(&moved, &b.bounds, along) {
                    let overlap = overlap_interval((&there, &a.solid), (&here, &b.solid), along, 0.0);
                    overlaps.extend(overlap.map(|ends| ends.map(f64::from)));
                }
            }
        }
        first_gap(overlaps) as f32
    }
}

/// True if a part moved by `shift` overlaps another by more than touching.
fn deeper_than_touching(a: &ConvexPolyhedron, shift: Vec3, b: &ConvexPolyhedron) -> bool {
    let (there, here) = (Isometry::from_translation(shift), Isometry::IDENTITY);
    let depth = contact(&there, a, &here, b, 0.0).ok().flatten().map_or(0.0, |contact| -contact.dist);
    if depth > 0.5 * TOUCHING {
        return depth > TOUCHING;
    }
    // The library calls some deep overlaps of parts that are alike a mere touch. The shortest way out along an axis is
    // at most √3 times the depth: what truly has half of what counts as touching is never taken for more here.
    let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let is_deep = |along| {
        let overlap = overlap_interval((&there, a), (&here, b), along, 0.0);
        overlap.is_some_and(|[low, high]| low < 0.0 && high > TOUCHING)
    };
    axes.into_iter().all(is_deep)
}

/// True if a box that moves along a direction meets another.
fn meets(moving: &Aabb, other: &Aabb, along: Vec3) -> bool {
    let (between, reach) = (other.center() - moving.center(), moving.half_extents() + other.half_extents());
    let mut on_the_way = [0.0, f32::INFINITY];
    for axis in 0..3 {
        let (middle, half, speed) = (between[axis], reach[axis], along[axis]);
        if speed == 0.0 {
            if middle.abs() > half {
                return false;
            }
            continue;
        }
        let [enters, leaves] = [middle / speed - half / speed.abs(), middle / speed + half / speed.abs()];
        on_the_way = [on_the_way[0].max(enters), on_the_way[1].min(leaves)];
    }
    on_the_way[0] <= on_the_way[1]
}

/// True if one object lies inside the other, or on or in something that does: they belong in one another.
pub(super) fn nested(scene: &Scene, a: usize, b: usize) -> bool {
    let within = |object: usize, container: usize| {
        let is_inside = |object: usize| scene.objects[object].relation == Relation::Inside;
        let mut below = once(object).chain(scene.bearers(object)).take_while(|&object| object != container);
        scene.bearers(object).any(|bearer| bearer == container) && below.any(is_inside)
    };
    within(a, b) || within(b, a)
}
