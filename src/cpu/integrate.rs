//! How a body has turned at the end of a substep, and its spin then.

use crate::world::constants::SLENDER_INERTIA_RATIO;
use crate::world::{compose, from_scaled_axis, unit_rotation};
use glam::{Quat, Vec3};

/// What a substep did to the orientation of a body.
#[derive(Clone, Copy, Debug)]
pub struct Turning {
    /// Inverse principal moments of inertia, 1 / (kg m²).
    pub inverse_inertia: Vec3,
    /// Orientation at its start.
    pub old: Quat,
    /// Angular velocity that the solver left, world, rad/s.
    pub spin: Vec3,
    /// Sum of the turns of its small steps, world, rad.
    pub turn: Vec3,
    /// True if the body had contacts, or might have come to touch something.
    pub touched: bool,
}

impl Turning {
    /// Orientation and angular velocity after a substep of `dt`.
    pub fn end(&self, dt: f32) -> (Quat, Vec3) {
        if self.inverse_inertia.max_element() > SLENDER_INERTIA_RATIO * self.inverse_inertia.min_element() {
            self.slender(dt)
        } else {
            self.compact(dt)
        }
    }

    fn turned(&self, turn: Vec3) -> Quat {
        unit_rotation(compose(from_scaled_axis(turn), self.old))
    }

    /// Angular momentum, not angular velocity, is carried over to the new orientation; the turn is corrected to the mean
    /// of both velocities (Heun), or a tumbling body would gain energy.
    fn compact(&self, dt: f32) -> (Quat, Vec3) {
        let momentum = self.old * ((self.old.conjugate() * self.spin) / self.inverse_inertia);
        let spin_at = |rotation: Quat| rotation * ((rotation.conjugate() * momentum) * self.inverse_inertia);
        let new = self.turned(self.turn + 0.5 * dt * (spin_at(self.turned(self.turn)) - self.spin));
        (new, spin_at(new))
    }

    /// Of a slender body the smallest part of the momentum across it, taken for momentum along it, would be a spin without
    /// bound. So its spin is carried over in its own frame, where Euler's equations bound it. What nothing touches is
    /// turned by the last bit so that its momentum stays; with contacts there is none to keep, because the solver holds
    /// inertia as it was at the start.
    fn slender(&self, dt: f32) -> (Quat, Vec3) {
        let spin = self.old.conjugate() * self.spin;
        let next = free_spin(spin, self.inverse_inertia, dt);
        let ahead = self.turned(self.turn) * next;
        let mut new = self.turned(self.turn + 0.5 * dt * (ahead - self.spin));
        if !self.touched {
            let momentum = self.old * (spin / self.inverse_inertia);
            new = unit_rotation(compose(aligning(new * (next / self.inverse_inertia), momentum), new));
        }
        (new, new * next)
    }
}

/// Spin of a body after `dt` without torque, in its own frame (Euler's equations by Runge and Kutta's fourth-order method),
/// with the energy that it had.
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
