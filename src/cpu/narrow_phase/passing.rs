//! Hulls that pass each other: contacts are made a substep ahead, and one between things that only fall past each other
//! would stop them in the air.
//!
//! The idea of a conservative advance: where a face of one hull keeps all of the other on its outer side at the start of
//! the substep and at its end, they do not meet, whatever their nearest corners are about to do. Only a contact that would
//! act is asked, so that a thing at rest never loses what bears it.

use super::{HullPair, Manifold};
use crate::world::{Pose, Velocity, compose, from_scaled_axis};
use glam::{Mat3, Vec3};

/// True if a contact of the pair would act within `dt` (s), and yet the hulls only pass each other. `velocities` are those
/// of the bodies if nothing touches them, gravity included.
pub fn passes(pair: &HullPair, velocities: &[Velocity; 2], dt: f32, manifold: &Manifold) -> bool {
    let acts = manifold.points().iter().any(|point| {
        let moved = |side: usize, at: Vec3| {
            let Velocity { linear, angular, .. } = velocities[side];
            dt * (linear + angular.cross(at - pair.poses[side].translation))
        };
        let closer = manifold.normal.dot(moved(0, point.on_a) - moved(1, point.on_b));
        point.separation > 0.0 && closer > point.separation
    });
    acts && {
        let ends = [0, 1].map(|side: usize| end(pair.poses[side], &velocities[side], dt));
        let later = HullPair { poses: [&ends[0], &ends[1]], ..*pair };
        (0..2).any(|side| stays_beside(pair, &later, side))
    }
}

/// Where a body will be after `dt` seconds.
fn end(pose: &Pose, velocity: &Velocity, dt: f32) -> Pose {
    let turn = from_scaled_axis(dt * velocity.angular);
    Pose::new(compose(turn, pose.rotation), pose.translation + dt * velocity.linear)
}

/// True if a face of the hull of `side` has all of the other hull on its outer side, now and later.
fn stays_beside(pair: &HullPair, later: &HullPair, side: usize) -> bool {
    let frames = [pair.other_to(side), later.other_to(side)];
    let vertices = pair.tables.vertices_of(pair.hull(1 - side));
    pair.tables.faces_of(pair.hull(side)).iter().any(|face| {
        let outside =
            |(turn, shift): &(Mat3, Vec3), vertex: Vec3| face.normal().dot(*turn * vertex + *shift) > face.plane.w;
        vertices.iter().all(|vertex| frames.iter().all(|frame| outside(frame, vertex.truncate())))
    })
}
