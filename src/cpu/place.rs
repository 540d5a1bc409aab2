//! Kernel `place`: poses of all bodies of one candidate.
//!
//! Each unit turns about its pivot and shifts; every body of the unit goes along rigidly, so in the global stage the
//! children move with the group's root (the paper's expansion of a group into its objects). The released code turns
//! about the world's origin instead, which swings far objects through long arcs.

use crate::world::{Pose, World, compose, from_scaled_axis, unit_rotation};
use glam::Vec3;

/// Writes the pose of every body for the adjustment `delta` (6 · units); static bodies keep their start.
pub fn place(world: &World, delta: &[f32], poses: &mut [Pose]) {
    for ((body, start), pose) in world.bodies.iter().zip(&world.start).zip(poses) {
        if body.is_static() {
            *pose = *start;
            continue;
        }
        let pivot = world.units[body.unit as usize].pivot;
        let d = &delta[6 * body.unit as usize..][..6];
        let shift = Vec3::new(d[0], d[1], d[2]);
        let turn = from_scaled_axis(Vec3::new(d[3], d[4], d[5]));
        *pose =
            Pose::new(unit_rotation(compose(turn, start.rotation)), turn * (start.translation - pivot) + pivot + shift);
    }
}
