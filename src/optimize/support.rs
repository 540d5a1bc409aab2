//! Does everything still stand on what the scene says it stands on?
//!
//! An object is borne by its parent if it touches it from above, or if it so touches a sibling that is borne: the
//! second book of a pile stands on the desk through the first. What leans against the side of a table, or hangs over
//! its edge down to the ground, is not on the table. Only what hangs on its parent or is fastened to it may touch it
//! from anywhere.

use super::rig::Rig;
use super::tolerances::{BEARS_UPWARD, BEARS_WITHIN};
use crate::scene::{self, Parent, Relation, Root, Scene};
use crate::world::Pose;
use glam::Vec3;
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::Pose as Isometry;
use parry3d::query::{Contact, contact};
use parry3d::shape::{ConvexPolyhedron, Shape};

/// One object's parts where they are.
pub(super) struct Placed<'a> {
    pose: Isometry,
    parts: Vec<(&'a ConvexPolyhedron, Aabb)>,
    lowest: f32,
}

impl<'a> Placed<'a> {
    /// For a pose of the body.
    pub fn new(rig: &'a Rig, pose: &Pose) -> Self {
        let isometry = Isometry::from_parts(pose.translation, pose.rotation);
        let bounded = |part: &'a ConvexPolyhedron| (part, part.compute_aabb(&isometry).loosened(0.5 * BEARS_WITHIN));
        Self { pose: isometry, parts: rig.solids().iter().map(bounded).collect(), lowest: rig.lowest(pose) }
    }

    /// True if the other touches this from above and does not stand with a foot on the ground below; or for what hangs
    /// or is attached, if it touches this anywhere.
    pub fn bears(&self, other: &Self, relation: Relation) -> bool {
        let from_anywhere = matches!(relation, Relation::Hanging | Relation::Attached);
        let on_ground = other.lowest <= BEARS_WITHIN;
        self.parts.iter().any(|(a, box_a)| {
            other.parts.iter().filter(|(_, box_b)| box_a.intersects(box_b)).any(|(b, _)| {
                let touch = touch((&self.pose, a), (&other.pose, b));
                let from_above = |touch: Contact| {
                    touch.normal1.y >= BEARS_UPWARD && !(on_ground && touch.point1.y > other.lowest + BEARS_WITHIN)
                };
                touch.is_some_and(|touch| from_anywhere || from_above(touch))
            })
        })
    }

    /// True if the other is within `BEARS_WITHIN` of this.
    pub fn touches(&self, other: &Self) -> bool {
        let near = |(a, box_a): &(&ConvexPolyhedron, Aabb), (b, box_b): &(&ConvexPolyhedron, Aabb)| {
            box_a.intersects(box_b) && touch((&self.pose, a), (&other.pose, b)).is_some()
        };
        self.parts.iter().any(|own| other.parts.iter().any(|part| near(own, part)))
    }

    /// True if this, moved by `shift`, reaches deeper than `depth` (m) into the other.
    pub fn overlaps(&self, shift: Vec3, other: &Self, depth: f32) -> bool {
        let pose = Isometry::from_parts(self.pose.translation + shift, self.pose.rotation);
        self.parts.iter().any(|(a, box_a)| {
            let moved = box_a.translated(shift);
            other.parts.iter().filter(|(_, box_b)| moved.intersects(box_b)).any(|(b, _)| {
                contact(&pose, *a, &other.pose, *b, 0.0).ok().flatten().is_some_and(|touch| touch.dist < -depth)
            })
        })
    }
}

/// Where two parts are within `BEARS_WITHIN` of each other.
fn touch((pose_a, a): (&Isometry, &ConvexPolyhedron), (pose_b, b): (&Isometry, &ConvexPolyhedron)) -> Option<Contact> {
    let found = contact(pose_a, a, pose_b, b, BEARS_WITHIN).ok().flatten()?;
    // Now and then parry ends its search at points that are not the nearest: their direction means nothing.
    let near = found.dist <= 0.0 || found.point1.distance(found.point2) <= BEARS_WITHIN;
    near.then_some(found)
}

/// For every object: true if nothing that the scene names bears it any more. `poses` holds the pose of every object's
/// body. Objects that never move have not lost anything.
pub(super) fn lost(scene: &Scene, rigs: &[Rig], poses: &[Pose]) -> Vec<bool> {
    let placed: Vec<Placed> = rigs.iter().zip(poses).map(|(rig, pose)| Placed::new(rig, pose)).collect();
    let count = scene.objects.len();
    let borne_directly = |i: usize| match scene.objects[i].parent {
        Parent::Object(parent) => placed[parent].bears(&placed[i], scene.objects[i].relation),
        Parent::Root(Root::Wall | Root::Ceiling) => true,
        Parent::Root(Root::Ground | Root::GroundWall) => placed[i].lowest <= BEARS_WITHIN,
    };
    let mut borne: Vec<bool> = (0..count).map(|i| scene.is_static(i) || borne_directly(i)).collect();
    let mut fresh: Vec<usize> = (0..count).filter(|&i| borne[i]).collect();
    while let Some(bearer) = fresh.pop() {
        for i in 0..count {
            let siblings = scene.objects[i].parent == scene.objects[bearer].parent;
            if !borne[i] && siblings && placed[bearer].bears(&placed[i], scene.objects[i].relation) {
                borne[i] = true;
                fresh.push(i);
            }
        }
    }
    borne.into_iter().map(|borne| !borne).collect()
}

/// Objects that hang on another one or are fastened to it, take no part in the simulation, and do not touch that one.
pub(super) fn detached(scene: &Scene, rigs: &[Rig], layout: &[scene::Pose]) -> Vec<[usize; 2]> {
    let placed = |i: usize| Placed::new(&rigs[i], &rigs[i].body(&layout[i]));
    let on_object = |i: usize| match (scene.objects[i].parent, scene.objects[i].relation) {
        (Parent::Object(parent), Relation::Hanging | Relation::Attached) => Some([i, parent]),
        _ => None,
    };
    let fixed = (0..layout.len()).filter(|&i| scene.is_static(i)).filter_map(on_object);
    fixed.filter(|&[object, parent]| !placed(parent).touches(&placed(object))).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use glam::Quat;

    /// Sectors of two gears, one above the floor of a tote and one below it, 8.1 mm apart: the search for their nearest
    /// points ends at 13 mm with a direction that says 5.4 mm, the upper one under the lower one.
    #[test]
    fn a_search_that_was_broken_off_is_no_touch() {
        let sector = |corners: &[[f32; 3]]| {
            ConvexPolyhedron::from_convex_hull(&corners.iter().copied().map(Vec3::from).collect::<Vec<_>>()).unwrap()
        };
        let upper = sector(&[
            [-0.0297202, 0.010046606, 0.019716172],
            [-0.02897434, -0.010576017, 0.021180002],
            [-0.02897434, 0.010046606, 0.021180002],
            [-0.021046646, 0.010046606, 0.029107695],
            [-0.011039115, 0.010046606, 0.034210704],
            [-0.010132783, -0.010576017, 0.000_151_403_44],
            [-0.010132783, 0.010046606, 0.000_151_403_44],
            [-0.002_191_309_6, -0.010576017, 0.03561206],
            [-0.002_191_309_6, 0.010046606, 0.03561206],
            [-0.002_178_252_4, -0.010576017, 0.009922839],
            [-0.002_178_252_4, 0.010046606, 0.009922839],
        ]);
        let lower = sector(&[
            [-0.030995963, -0.009944902, -0.017904133],
            [-0.030799268, 0.010356985, -0.017891746],
            [-0.014564099, -0.010095243, -0.032425776],
            [-0.014367402, 0.0102066435, -0.032413386],
            [-0.009219512, -0.010163741, -0.005_025_615_4],
            [-0.009022816, 0.010138146, -0.00501323],
            [0.002819245, 0.010026154, -0.009505596],
            [0.002_599_694_3, -0.010275556, -0.00944625],
        ]);
        let rotated = |x, y, z, w| Quat::from_xyzw(x, y, z, w).normalize();
        let upper_pose = Isometry::from_parts(
            Vec3::new(0.6330316, 0.9424943, 0.004_018_791_5),
            rotated(0.004067062, 0.073102824, 0.037812117, 0.9965991),
        );
        let lower_pose = Isometry::from_parts(
            Vec3::new(0.6515004, 0.9147943, 0.00788488),
            rotated(0.000_897_491_23, 0.19441943, 0.006_779_82, 0.9808946),
        );
        assert!(touch((&upper_pose, &upper), (&lower_pose, &lower)).is_none());
        let down = Isometry::from_parts(upper_pose.translation - Vec3::Y * 0.0065, upper_pose.rotation);
        assert!(touch((&down, &upper), (&lower_pose, &lower)).is_some_and(|touch| touch.dist < BEARS_WITHIN));
    }
}
