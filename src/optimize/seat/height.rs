//! At which height an object rests on another, and where it fits between its sides.

use super::Seat;
use super::tolerances::{DISTANCES, FOOTPRINT, MAX_SHIFT, NARROW, STEEP, SUNK, SUNK_ON};
use crate::optimize::{directions::directions, rig::Rig, sweep::overlap_interval};
use crate::scene::{self, Parent, Relation, Root};
use crate::world::constants::LINEAR_SLOP;
use glam::{DVec3, Vec3};
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::Pose as Isometry;
use parry3d::shape::{ConvexPolyhedron, Shape};

/// Parts of one object in world coordinates, and the boxes around them.
pub(super) struct Solid {
    parts: Vec<(Aabb, ConvexPolyhedron)>,
}

impl Solid {
    pub(super) fn new(rig: &Rig, pose: &scene::Pose, footprint: f32) -> Self {
        let body = rig.body(pose);
        let center = body.translation;
        let narrow = |v: Vec3| {
            let w = body.point(v) - center;
            Vec3::new(w.x * footprint, w.y, w.z * footprint) + center
        };
        let hull =
            |part: &Vec<Vec3>| ConvexPolyhedron::from_convex_hull(&part.iter().map(|&v| narrow(v)).collect::<Vec<_>>());
        Self::of(rig.parts.iter().filter_map(hull))
    }

    fn of(parts: impl Iterator<Item = ConvexPolyhedron>) -> Self {
        let bounded = |part: ConvexPolyhedron| (part.compute_local_aabb(), part);
        Self { parts: parts.map(bounded).collect() }
    }
}

impl Seat<'_> {
    /// Shifts the object to the height at which it rests.
    pub fn settle_height(&self, object: usize, layout: &mut [scene::Pose]) {
        let pose = self.at_height(object, layout[object], self.bearer(object, layout).as_ref());
        self.carry(object, pose, layout);
    }

    /// The object's parent as it is; none if that is no object.
    pub(super) fn bearer(&self, object: usize, layout: &[scene::Pose]) -> Option<Solid> {
        match self.scene.objects[object].parent {
            Parent::Root(_) => None,
            Parent::Object(parent) => Some(Solid::new(&self.rigs[parent], &layout[parent], 1.0)),
        }
    }

    /// The pose shifted to the height at which the object rests on its `bearer`, or the ground.
    pub(super) fn at_height(&self, object: usize, pose: scene::Pose, bearer: Option<&Solid>) -> scene::Pose {
        let footprint = bearer.map(|_| self.footprint(object, &pose));
        self.aside_at_height(object, &pose, footprint.as_ref(), DVec3::ZERO, bearer)
    }

    /// The same for the pose put `aside`, horizontally, m, and the object's `footprint` at the pose.
    pub(super) fn aside_at_height(
        &self,
        object: usize,
        pose: &scene::Pose,
        footprint: Option<&Solid>,
        aside: DVec3,
        bearer: Option<&Solid>,
    ) -> scene::Pose {
        let shift = match (footprint, bearer) {
            (Some(footprint), Some(bearer)) => {
                let overlaps = overlaps(footprint, aside.as_vec3(), bearer);
                let shift = nearest_top(&overlaps).unwrap_or(0.0);
                let is_on = matches!(self.scene.objects[object].relation, Relation::On | Relation::Inside);
                let swallowed = is_on && overlaps.iter().any(|&[low, high]| low < 0.0 && high > 0.0);
                if shift.abs() <= MAX_SHIFT || swallowed { shift } else { 0.0 }
            }
            _ => self.shift(object, pose, None),
        };
        scene::Pose { translation: pose.translation + aside.with_y(f64::from(shift)), ..*pose }
    }

    /// Vertical distance from an object's pose to where it rests on its `bearer`, or the ground, m.
    pub(super) fn shift(&self, object: usize, pose: &scene::Pose, bearer: Option<&Solid>) -> f32 {
        match (self.scene.objects[object].parent, bearer) {
            (_, Some(bearer)) => self.support(object, pose, bearer).unwrap_or(0.0),
            (Parent::Root(Root::Ground | Root::GroundWall), _) => {
                -self.rigs[object].lowest(&self.rigs[object].body(pose))
            }
            _ => 0.0,
        }
    }

    /// Vertical distance from where the object is to where it rests on another, m; none if that is not below.
    pub(super) fn step(&self, object: usize, other: usize, layout: &[scene::Pose]) -> Option<f32> {
        self.support(object, &layout[object], &Solid::new(&self.rigs[other], &layout[other], 1.0))
    }

    /// The same for an object at a pose and what bears it; none if nothing is below.
    fn support(&self, object: usize, pose: &scene::Pose, bearer: &Solid) -> Option<f32> {
        support_shift(&self.footprint(object, pose), Vec3::ZERO, bearer)
    }

    /// The object at a pose, as narrow as what looks for support.
    pub(super) fn footprint(&self, object: usize, pose: &scene::Pose) -> Solid {
        Solid::new(&self.rigs[object], pose, FOOTPRINT)
    }

    /// Shifts an object that is inside another or on it, but reaches into its side and would have to be raised onto its
    /// rim, to the nearest place where it rests closer to its own height; what is on the other, with its middle over what
    /// bears it, or it would hang over the edge of a step by its leaves.
    pub(super) fn step_inside(&self, object: usize, layout: &mut [scene::Pose]) {
        let relation = self.scene.objects[object].relation;
        let sunk = match relation {
            Relation::Inside => SUNK,
            Relation::On => SUNK_ON,
            _ => return,
        };
        let Some(bearer) = self.bearer(object, layout) else { return };
        let (here, footprint) = (layout[object], self.footprint(object, &layout[object]));
        let middle = (relation == Relation::On).then(|| Solid::new(&self.rigs[object], &here, NARROW));
        let shift = |aside: DVec3| support_shift(&footprint, aside.as_vec3(), &bearer);
        let is_under = |aside: DVec3, shift: f32| {
            let below = |middle| support_shift(middle, aside.as_vec3(), &bearer);
            middle.as_ref().is_none_or(|middle| below(middle).is_some_and(|below| (shift - below).abs() <= SUNK_ON))
        };
        let raise = shift(DVec3::ZERO).unwrap_or(0.0);
        let (mut least, mut nearest) = (STEEP * f64::from(raise), here);
        for distance in DISTANCES.into_iter().filter(|_| raise > sunk) {
            if distance >= least {
                break;
            }
            for along in directions() {
                let aside = along * distance;
                let Some(shift) = shift(aside) else { continue };
                let way = distance + STEEP * f64::from(shift.abs());
                if way < least && is_under(aside, shift) {
                    (least, nearest) = (way, scene::Pose { translation: here.translation + aside, ..here });
                }
            }
        }
        self.carry(object, nearest, layout);
    }
}

/// The smallest vertical shift that lets `child`, put `aside`, rest on `bearer`, m; none if nothing is below it.
pub(super) fn support_shift(child: &Solid, aside: Vec3, bearer: &Solid) -> Option<f32> {
    nearest_top(&overlaps(child, aside, bearer))
}

fn nearest_top(overlaps: &[[f32; 2]]) -> Option<f32> {
    overlaps.iter().map(|&[_, high]| high).min_by(|a, b| a.abs().total_cmp(&b.abs()))
}

/// The vertical shifts with which `child`, put `aside`, overlaps `bearer`, from and to, m, from the lowest.
fn overlaps(child: &Solid, aside: Vec3, bearer: &Solid) -> Vec<[f32; 2]> {
    let [there, here] = [aside, Vec3::ZERO].map(Isometry::from_translation);
    let mut overlaps: Vec<[f32; 2]> = Vec::new();
    for (box_a, a) in &child.parts {
        let mut column = box_a.translated(aside).loosened(LINEAR_SLOP);
        (column.mins.y, column.maxs.y) = (f32::NEG_INFINITY, f32::INFINITY);
        for (_, b) in bearer.parts.iter().filter(|(box_b, _)| column.intersects(box_b)) {
            overlaps.extend(overlap_interval((&there, a), (&here, b), Vec3::Y, 0.0));
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
    joined
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn cube(center: Vec3) -> ConvexPolyhedron {
        let corners = (0..8).map(|i| center + Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5);
        ConvexPolyhedron::from_convex_hull(&corners.collect::<Vec<_>>()).unwrap()
    }

    fn solid(centers: &[Vec3]) -> Solid {
        Solid::of(centers.iter().copied().map(cube))
    }

    #[test]
    fn the_nearest_support_is_chosen() {
        let shelf = solid(&[Vec3::ZERO, Vec3::Y * 3.0]);
        let shift = |y: f32| support_shift(&solid(&[Vec3::Y * y]), Vec3::ZERO, &shelf).unwrap();
        assert!((shift(0.9) - 0.1).abs() < 1e-3, "sunk by 10 cm, shifted by {}", shift(0.9));
        assert!((shift(1.2) + 0.2).abs() < 1e-3, "floating by 20 cm, shifted by {}", shift(1.2));
        assert!((shift(3.8) - 0.2).abs() < 1e-3, "on the upper board, shifted by {}", shift(3.8));
    }

    #[test]
    fn what_is_put_aside_is_borne_by_what_is_there() {
        let steps = solid(&[Vec3::ZERO, Vec3::new(1.2, 0.3, 0.0)]);
        let shift = |aside: f32| support_shift(&solid(&[Vec3::Y * 1.1]), Vec3::X * aside, &steps);
        assert!((shift(-0.9).unwrap() + 0.1).abs() < 1e-3, "on the lower step, shifted by {:?}", shift(-0.9));
        assert!((shift(0.3).unwrap() - 0.2).abs() < 1e-3, "on both, shifted by {:?}", shift(0.3));
        assert!(shift(-1.1).is_none() && shift(2.3).is_none(), "beside them");
    }
}
