//! Support heights: every object is set onto what bears it before the search, from the ground up.
//!
//! Reconstructions float or sink by centimetres. The search looks only millimetres up and down, and an object sunk
//! deeper than half of a table top would be pushed out below it. So each object is shifted vertically, with everything
//! that stands on it, to the nearest height at which it rests on its parent: for two convex parts the shifts at which
//! they overlap are one interval, and the upper ends of the joined intervals are the heights of support under the
//! object's footprint (REST3D's stage 2b, which takes the parent's highest point instead).

use super::{groups::subtree, rig::Rig};
use crate::scene::{self, Parent, Root, Scene};
use crate::world::constants::LINEAR_SLOP;
use glam::Vec3;
use parry3d::math::Pose as Isometry;
use parry3d::query::{ShapeCastOptions, cast_shapes};
use parry3d::shape::ConvexPolyhedron;

/// An object is not shifted farther than this, m: what is farther off is not a wrong height but a wrong parent.
const MAX_SHIFT: f32 = 0.2;

/// The footprint that looks for support is so much narrower than the object: a book that leans into a wall of the shelf
/// still stands on the board.
const FOOTPRINT: f32 = 0.8;

/// Parts of one object in world coordinates.
struct Solid {
    parts: Vec<ConvexPolyhedron>,
}

impl Solid {
    fn new(rig: &Rig, pose: &scene::Pose, footprint: f32) -> Self {
        let body = rig.body(pose);
        let center = body.translation;
        let narrow = |v: Vec3| {
            let w = body.point(v) - center;
            Vec3::new(w.x * footprint, w.y, w.z * footprint) + center
        };
        let hull =
            |part: &Vec<Vec3>| ConvexPolyhedron::from_convex_hull(&part.iter().map(|&v| narrow(v)).collect::<Vec<_>>());
        Self { parts: rig.parts.iter().filter_map(hull).collect() }
    }
}

/// Sets the objects of `layout` onto their supports; returns each object's own shift, m. What never moves stays.
pub(super) fn seat(scene: &Scene, rigs: &[Rig], layout: &mut [scene::Pose]) -> Vec<f32> {
    let mut shifts = vec![0.0; layout.len()];
    let mut parents_first = scene.post_order();
    parents_first.reverse();
    for object in parents_first {
        if scene.is_static(object) {
            continue;
        }
        let shift = match scene.objects[object].parent {
            Parent::Root(Root::Ground | Root::GroundWall) => -rigs[object].lowest(&rigs[object].body(&layout[object])),
            Parent::Root(_) => 0.0,
            Parent::Object(parent) => {
                let child = Solid::new(&rigs[object], &layout[object], FOOTPRINT);
                let bearer = Solid::new(&rigs[parent], &layout[parent], 1.0);
                support_shift(&child, &bearer).unwrap_or(0.0)
            }
        };
        if shift == 0.0 || shift.abs() > MAX_SHIFT {
            continue;
        }
        shifts[object] = shift;
        for moved in subtree(scene, object, |child| !scene.is_static(child)) {
            layout[moved].translation.y += f64::from(shift);
        }
    }
    shifts
}

/// The smallest vertical shift that lets `child` rest on `bearer`, m; none if nothing is below it.
fn support_shift(child: &Solid, bearer: &Solid) -> Option<f32> {
    let mut overlaps: Vec<[f32; 2]> = Vec::new();
    for a in &child.parts {
        for b in &bearer.parts {
            overlaps.extend(overlap_interval(a, b));
        }
    }
    overlaps.sort_by(|p, q| p[0].total_cmp(&q[0]));
    let mut joined: Vec<[f32; 2]> = Vec::new();
    for [low, high] in overlaps {
        match joined.last_mut() {
            Some(last) if low <= last[1] + LINEAR_SLOP => last[1] = last[1].max(high),
            _ => joined.push([low, high]),
        }
    }
    joined.into_iter().map(|[_, high]| high).min_by(|a, b| a.abs().total_cmp(&b.abs()))
}

/// The vertical shifts of `a` at which it overlaps `b`: one interval, found by dropping `a` from above and raising it
/// from below.
fn overlap_interval(a: &ConvexPolyhedron, b: &ConvexPolyhedron) -> Option<[f32; 2]> {
    let bounds = |solid: &ConvexPolyhedron| {
        solid.points().iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(v.y), h.max(v.y)))
    };
    let ((low_a, high_a), (low_b, high_b)) = (bounds(a), bounds(b));
    // Clear of each other by a centimetre above and below.
    let (above, below) = (high_b - low_a + 0.01, low_b - high_a - 0.01);
    let travel = above - below;
    let cast = |from: f32, direction: f32| {
        let start = Isometry::from_translation(Vec3::Y * from);
        let options = ShapeCastOptions { max_time_of_impact: travel, ..Default::default() };
        let hit = cast_shapes(&start, Vec3::Y * direction, a, &Isometry::IDENTITY, Vec3::ZERO, b, options);
        hit.ok().flatten().map(|hit| hit.time_of_impact)
    };
    Some([below + cast(below, 1.0)?, above - cast(above, -1.0)?])
}
