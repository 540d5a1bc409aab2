//! Does everything still stand on what the scene says it stands on?
//!
//! An object is borne by its parent if their parts are within `REACH` of each other, or if it touches a sibling that is
//! borne: the second book of a pile stands on the desk through the first.

use super::rig::Rig;
use crate::scene::{Parent, Root, Scene};
use crate::world::Pose;
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::Pose as Isometry;
use parry3d::query::distance;
use parry3d::shape::{ConvexPolyhedron, Shape};

/// Largest gap between an object and what bears it, m.
const REACH: f32 = 0.005;

/// One object's parts where they are.
struct Placed {
    pose: Isometry,
    parts: Vec<(ConvexPolyhedron, Aabb)>,
    lowest: f32,
}

impl Placed {
    fn new(rig: &Rig, pose: &Pose) -> Self {
        let isometry = Isometry::from_parts(pose.translation, pose.rotation);
        let parts = rig.parts.iter().filter_map(|part| ConvexPolyhedron::from_convex_hull(part));
        Self {
            pose: isometry,
            parts: parts
                .map(|part| {
                    let bounds = part.compute_aabb(&isometry).loosened(0.5 * REACH);
                    (part, bounds)
                })
                .collect(),
            lowest: rig.lowest(pose),
        }
    }

    fn reaches(&self, other: &Self) -> bool {
        self.parts.iter().any(|(a, box_a)| {
            other.parts.iter().any(|(b, box_b)| {
                box_a.intersects(box_b)
                    && distance(&self.pose, a, &other.pose, b).is_ok_and(|gap| gap.distance <= REACH)
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
        Parent::Object(parent) => placed[i].reaches(&placed[parent]),
        Parent::Root(Root::Wall | Root::Ceiling) => true,
        Parent::Root(Root::Ground | Root::GroundWall) => placed[i].lowest <= REACH,
    };
    let mut borne: Vec<bool> = (0..count).map(|i| scene.is_static(i) || borne_directly(i)).collect();
    let mut fresh: Vec<usize> = (0..count).filter(|&i| borne[i]).collect();
    while let Some(bearer) = fresh.pop() {
        for i in 0..count {
            let siblings = scene.objects[i].parent == scene.objects[bearer].parent;
            if !borne[i] && siblings && placed[i].reaches(&placed[bearer]) {
                borne[i] = true;
                fresh.push(i);
            }
        }
    }
    borne.into_iter().map(|borne| !borne).collect()
}
