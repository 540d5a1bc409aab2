//! Does everything still stand on what the scene says it stands on?
//!
//! An object is borne by its parent if it touches it from above, or if it so touches a sibling that is borne: the
//! second book of a pile stands on the desk through the first. What leans against the side of a table, or hangs over
//! its edge down to the ground, is not on the table. Only what hangs on its parent or is fastened to it may touch it
//! from anywhere.

use super::rig::Rig;
use super::tolerances::{BEARS_WITHIN, UPWARD};
use crate::scene::{Parent, Relation, Root, Scene};
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
                let touch = contact(&self.pose, *a, &other.pose, *b, BEARS_WITHIN).ok().flatten();
                let from_above = |touch: Contact| {
                    touch.normal1.y >= UPWARD && !(on_ground && touch.point1.y > other.lowest + BEARS_WITHIN)
                };
                touch.is_some_and(|touch| from_anywhere || from_above(touch))
            })
        })
    }

    /// True if the other is within `BEARS_WITHIN` of this.
    pub fn touches(&self, other: &Self) -> bool {
        let near = |(a, box_a): &(&ConvexPolyhedron, Aabb), (b, box_b): &(&ConvexPolyhedron, Aabb)| {
            box_a.intersects(box_b)
                && contact(&self.pose, *a, &other.pose, *b, BEARS_WITHIN).is_ok_and(|touch| touch.is_some())
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
