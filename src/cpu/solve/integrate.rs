//! Where bodies are at the end of a substep, how they have turned, and their spin then.

use super::lanes::Vector;
use super::rotation::Rotation;
use super::{Wide, unsigned};
use crate::cpu::simulate::Workspace;
use crate::world::constants::HIT_SPIN;
use crate::world::{Body, Pose, compose, from_scaled_axis, unit_rotation};
use fearless_simd::prelude::*;
use glam::{Quat, Vec3, Vec4};

impl<S: Simd> Wide<S> {
    /// Writes the motion of a substep of `dt` into the poses and velocities.
    #[inline(always)]
    pub fn integrate(&self, bodies: &[Body], dt: f32, candidates: &mut [Workspace]) {
        for (index, (moving, body)) in self.bodies.iter().zip(bodies).enumerate() {
            if body.is_static() {
                continue;
            }
            let inverse = body.inverse_inertia;
            let slender = body.is_slender();
            let mut old = Rotation::identity(self.simd);
            for (lane, candidate) in candidates.iter().enumerate() {
                old.set_lane(lane, candidate.poses[index].rotation);
            }
            let (spin, turn) = (moving.frame.back(moving.spin), moving.frame.back(moving.turn));
            let (rotations, spins) = if slender { (old, spin) } else { compact(inverse, old, [spin, turn], dt) };
            for (lane, candidate) in candidates.iter_mut().enumerate() {
                let (rotation, spin) = if slender {
                    let before = candidate.velocities[index].angular;
                    let (old, spin, turn) = (old.lane(lane), spin.lane(lane), turn.lane(lane));
                    Slender { inverse_inertia: inverse, old, before, spin, turn }.end(moving.touches(lane), dt)
                } else {
                    (rotations.lane(lane), spins.lane(lane))
                };
                let pose = &mut candidate.poses[index];
                *pose = Pose::new(
                    Quat::from_vec4(Vec4::from(rotation) + 0.0),
                    unsigned(pose.translation + moving.shift.lane(lane)),
                );
                let velocity = &mut candidate.velocities[index];
                (velocity.linear, velocity.angular) = (unsigned(moving.linear.lane(lane)), unsigned(spin));
            }
        }
    }
}

/// Orientation and angular velocity of a body after a substep of `dt`. Angular momentum, not angular velocity, is
/// carried over to the new orientation; the turn is corrected to the mean of both velocities (Heun), or a tumbling body
/// would gain energy.
#[inline(always)]
fn compact<S: Simd>(
    inverse_inertia: Vec3,
    old: Rotation<S>,
    [spin, turn]: [Vector<S>; 2],
    dt: f32,
) -> (Rotation<S>, Vector<S>) {
    let momentum = old.rotate(old.conjugate().rotate(spin).unscaled(inverse_inertia));
    let ahead = spin_at(turned(old, turn), momentum, inverse_inertia);
    let new = turned(old, turn + (ahead - spin).times(0.5 * dt));
    (new, spin_at(new, momentum, inverse_inertia))
}

#[inline(always)]
fn turned<S: Simd>(old: Rotation<S>, turn: Vector<S>) -> Rotation<S> {
    Rotation::from_scaled_axis(turn).after(old).unit()
}

/// Angular velocity of a body with this angular momentum.
#[inline(always)]
fn spin_at<S: Simd>(rotation: Rotation<S>, momentum: Vector<S>, inverse_inertia: Vec3) -> Vector<S> {
    rotation.rotate(rotation.conjugate().rotate(momentum).scaled(inverse_inertia))
}

/// What a substep did to the orientation of a body that is much longer than wide.
struct Slender {
    /// Inverse principal moments of inertia, 1 / (kg m²).
    inverse_inertia: Vec3,
    /// Orientation at its start.
    old: Quat,
    /// Angular velocity at its start, and the one that the solver left, world, rad/s.
    before: Vec3,
    spin: Vec3,
    /// Sum of the turns of its small steps, world, rad.
    turn: Vec3,
}

impl Slender {
    fn turned(&self, turn: Vec3) -> Quat {
        unit_rotation(compose(from_scaled_axis(turn), self.old))
    }

    /// Orientation and angular velocity after a substep of `dt`.
    ///
    /// The smallest part of the momentum across the body, taken for momentum along it, would be a spin without bound.
    /// So its spin is carried over in its own frame, where Euler's equations bound it, and then it is turned by what is
    /// left between that and its momentum, by the last bits of a free body, and by up to the turn before it if a hit
    /// has changed the spin. What touches something fixed hands its momentum over to that; it stays where its contacts
    /// have it, and so does what is hardly spinning.
    fn end(&self, [touched, held]: [bool; 2], dt: f32) -> (Quat, Vec3) {
        let spin = self.old.conjugate() * self.spin;
        let next = free_spin(spin, self.inverse_inertia, dt);
        let ahead = self.turned(self.turn) * next;
        let mut new = self.turned(self.turn + 0.5 * dt * (ahead - self.spin));
        let fast = self.spin.length_squared().max(self.before.length_squared()) > HIT_SPIN * HIT_SPIN;
        if !touched || (!held && fast) {
            let momentum = self.old * (spin / self.inverse_inertia);
            new = unit_rotation(compose(aligning(new * (next / self.inverse_inertia), momentum), new));
        }
        (new, new * next)
    }
}

/// Spin of a body after `dt` without torque, in its own frame (Euler's equations by Runge and Kutta's fourth-order
/// method), with the energy that it had.
fn free_spin(spin: Vec3, inverse_inertia: Vec3, dt: f32) -> Vec3 {
    let inertia = inverse_inertia.recip();
    let change = |w: Vec3| (inertia * w).cross(w) * inverse_inertia;
    let first = change(spin);
    let second = change(spin + 0.5 * dt * first);
    let third = change(spin + 0.5 * dt * second);
    let fourth = change(spin + dt * third);
    let next = spin + dt / 6.0 * (first + 2.0 * (second + third) + fourth);
    let (energy, found) = (spin.dot(inertia * spin), next.dot(inertia * next));
    if found > 0.0 && found.is_finite() { next * (energy / found).sqrt() } else { spin }
}

/// The smallest turn that brings `from` to the direction of `to`, for directions near each other.
fn aligning(from: Vec3, to: Vec3) -> Quat {
    let size = from.length() * to.length();
    let cosine = from.dot(to);
    if cosine > 0.5 * size {
        let axis = from.cross(to);
        unit_rotation(Quat::from_xyzw(axis.x, axis.y, axis.z, size + cosine))
    } else {
        Quat::IDENTITY
    }
}
