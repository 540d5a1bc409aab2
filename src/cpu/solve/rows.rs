//! Bodies and constraints as the sweeps need them, of several candidates side by side.

use super::Softness;
use super::lanes::{Mask, Matrix, Number, Vector, at_least, splat};
use crate::world::SimSettings;
use fearless_simd::prelude::*;
use glam::Vec3;

/// State of a body inside a substep.
#[derive(Clone, Copy, Debug)]
pub struct Moving<S: Simd> {
    /// Where it is at the substep's start.
    pub origin: Vector<S>,
    pub linear: Vector<S>,
    pub angular: Vector<S>,
    /// Shift and turn since the substep's start, m and rad.
    pub shift: Vector<S>,
    pub turn: Vector<S>,
    /// The same for all candidates.
    pub inverse_mass: f32,
    pub inverse_inertia: Matrix<S>,
    /// A bit for every candidate: true if the body has contacts, or may come to touch something.
    pub touched: u32,
    /// The candidates in which a contact of the body changed its speed in the last rigid sweep, and in the present one.
    pub restless: [Mask<S>; 2],
}

impl<S: Simd> Moving<S> {
    /// At rest, and as heavy as the ground.
    #[inline(always)]
    pub fn ground(simd: S) -> Self {
        let zero = Vector::splat(simd, Vec3::ZERO);
        Self {
            origin: zero,
            linear: zero,
            angular: zero,
            shift: zero,
            turn: zero,
            inverse_mass: 0.0,
            inverse_inertia: Matrix::zero(simd),
            touched: 0,
            restless: [Mask::splat(simd, false); 2],
        }
    }

    /// True if the body of this candidate has contacts, or may come to touch something.
    #[inline(always)]
    pub fn touches(&self, lane: usize) -> bool {
        self.touched >> lane & 1 == 1
    }
}

/// One scalar constraint between two bodies: the relative velocity of their touching points along `axis`.
#[derive(Clone, Copy, Debug)]
pub struct Row<S: Simd> {
    pub axis: Vector<S>,
    pub angular_a: Vector<S>,
    pub angular_b: Vector<S>,
    /// World inverse inertia times the angular parts.
    turn_a: Vector<S>,
    turn_b: Vector<S>,
    /// Inverse mass of the second body, 1/kg.
    inverse_mass_b: Number<S>,
    /// Effective mass, kg.
    pub mass: Number<S>,
}

impl<S: Simd> Row<S> {
    #[inline(always)]
    pub fn new(axis: Vector<S>, angular_a: Vector<S>, angular_b: Vector<S>, a: &Moving<S>, b: &Moving<S>) -> Self {
        let (turn_a, turn_b) = (a.inverse_inertia * angular_a, b.inverse_inertia * angular_b);
        let k = axis.dot(axis) * (a.inverse_mass + b.inverse_mass) + angular_a.dot(turn_a) + angular_b.dot(turn_b);
        let zero = splat(k.token(), 0.0);
        let mass = k.simd_gt(zero).select(splat(k.token(), 1.0) / k, zero);
        let inverse_mass_b = splat(k.token(), b.inverse_mass);
        Self { axis, angular_a, angular_b, turn_a, turn_b, inverse_mass_b, mass }
    }

    /// Without effect on the candidates that are not in `mask`: their velocities keep their bits when an impulse of +0 is
    /// subtracted as +0 and added as −0, even those that are −0. Their axes must be +0 and have no effective mass.
    #[inline(always)]
    pub fn only(self, mask: Mask<S>) -> Self {
        let simd = self.mass.token();
        let zero = |number| Vector::splat(simd, Vec3::splat(number));
        Self {
            turn_a: self.turn_a.or(mask, zero(0.0)),
            turn_b: self.turn_b.or(mask, zero(-0.0)),
            inverse_mass_b: mask.select(self.inverse_mass_b, splat(simd, -0.0)),
            ..self
        }
    }

    /// With lever arms on both bodies.
    #[inline(always)]
    pub fn along(axis: Vector<S>, arms: [Vector<S>; 2], a: &Moving<S>, b: &Moving<S>) -> Self {
        Self::new(axis, arms[0].cross(axis), arms[1].cross(axis), a, b)
    }

    /// Relative spin about `axis`.
    #[inline(always)]
    pub fn about(axis: Vector<S>, a: &Moving<S>, b: &Moving<S>) -> Self {
        Self::new(Vector::splat(axis.token(), Vec3::ZERO), axis, axis, a, b)
    }

    /// The same row with its lever arm on the first body longer by `by`, and shorter on the second.
    #[inline(always)]
    pub fn shifted(&self, by: Vector<S>, a: &Moving<S>, b: &Moving<S>) -> Self {
        let turn = by.cross(self.axis);
        Self::new(self.axis, self.angular_a + turn, self.angular_b - turn, a, b)
    }

    /// This where `mask` says so, `other` elsewhere.
    #[inline(always)]
    pub fn or(&self, mask: Mask<S>, other: &Self) -> Self {
        Self {
            axis: self.axis.or(mask, other.axis),
            angular_a: self.angular_a.or(mask, other.angular_a),
            angular_b: self.angular_b.or(mask, other.angular_b),
            turn_a: self.turn_a.or(mask, other.turn_a),
            turn_b: self.turn_b.or(mask, other.turn_b),
            inverse_mass_b: other.inverse_mass_b,
            mass: mask.select(self.mass, other.mass),
        }
    }

    /// How far the touching points have moved apart along the axis since the substep's start, m.
    #[inline(always)]
    pub fn moved(&self, a: &Moving<S>, b: &Moving<S>) -> Number<S> {
        self.axis.dot(b.shift - a.shift) + self.angular_b.dot(b.turn) - self.angular_a.dot(a.turn)
    }
}

/// A contact point ready to solve.
#[derive(Clone, Copy, Debug)]
pub struct Normal<S: Simd> {
    pub row: Row<S>,
    /// Separation at the substep's start less the rest offset, m.
    pub start: Number<S>,
    /// Distance from the patch's centre, m: lever of its friction against twisting.
    pub lever: Number<S>,
    /// Accumulated impulse of one small step, N s.
    pub impulse: Number<S>,
    /// `Contact::load`.
    pub load: Number<S>,
    pub aim: Aim<S>,
}

/// What a contact's impulse works towards in the sweeps, at its separation.
#[derive(Clone, Copy, Debug)]
pub struct Aim<S: Simd> {
    /// Speed at which the surfaces are to come closer if the contact is rigid, m/s.
    pub rigid_bias: Number<S>,
    /// The same if it is a spring.
    pub spring_bias: Number<S>,
    /// Effective mass less the spring's give, kg.
    pub spring_mass: Number<S>,
    /// Share of the impulse beyond its load that the spring gives back.
    pub leak: Number<S>,
}

impl<S: Simd> Aim<S> {
    #[inline(always)]
    pub fn new(separation: Number<S>, mass: Number<S>, settings: &SimSettings, soft: &Softness) -> Self {
        let zero = splat(separation.token(), 0.0);
        let overlaps = separation.simd_le(zero);
        let rigid_bias = at_least(separation, zero) / settings.small_step();
        let push_out = at_least(soft.push_out(separation), splat(separation.token(), -settings.max_push_out));
        Self {
            rigid_bias,
            spring_bias: overlaps.select(push_out, rigid_bias),
            spring_mass: overlaps.select(mass * soft.mass_scale, mass),
            leak: overlaps.select(splat(separation.token(), soft.impulse_scale), zero),
        }
    }
}

/// Friction of a patch: two directions at the centre of pressure and the twist about the normal. All tangential forces
/// of a flat patch add up to these three, and three rows cannot fight one another as two rows a point do.
#[derive(Clone, Copy, Debug)]
pub struct Friction<S: Simd> {
    pub tangents: [Row<S>; 2],
    /// Lever arms of the centre of pressure on both bodies, m.
    pub arms: [Vector<S>; 2],
    pub twist: Row<S>,
    /// How far the second body had moved past the first when the lever arms were made, m.
    pub passed: Vector<S>,
    /// Accumulated impulses of one small step, N s and N m s.
    pub impulse: [Number<S>; 3],
    /// What the points' impulses after the last rigid sweep allow: N s along the surface, N m s about the normal.
    pub limit: Number<S>,
    pub twist_limit: Number<S>,
}

/// Velocities of two bodies while their constraints are solved.
#[derive(Clone, Copy)]
pub struct Pair<S: Simd> {
    inverse_mass_a: Number<S>,
    linear_a: Vector<S>,
    angular_a: Vector<S>,
    linear_b: Vector<S>,
    angular_b: Vector<S>,
}

impl<S: Simd> Pair<S> {
    #[inline(always)]
    pub fn of(simd: S, bodies: &[Moving<S>], a: u32, b: u32) -> Self {
        let (a, b) = (&bodies[a as usize], &bodies[b as usize]);
        Self {
            inverse_mass_a: splat(simd, a.inverse_mass),
            linear_a: a.linear,
            angular_a: a.angular,
            linear_b: b.linear,
            angular_b: b.angular,
        }
    }

    /// Relative velocity along the row, m/s or rad/s.
    #[inline(always)]
    pub fn relative(&self, row: &Row<S>) -> Number<S> {
        row.axis.dot(self.linear_b - self.linear_a) + row.angular_b.dot(self.angular_b)
            - row.angular_a.dot(self.angular_a)
    }

    #[inline(always)]
    pub fn push(&mut self, row: &Row<S>, impulse: Number<S>) {
        self.linear_a -= row.axis * (impulse * self.inverse_mass_a);
        self.angular_a -= row.turn_a * impulse;
        self.linear_b += row.axis * (impulse * row.inverse_mass_b);
        self.angular_b += row.turn_b * impulse;
    }

    /// This where `mask` says so, `other` elsewhere.
    #[inline(always)]
    pub fn or(self, mask: Mask<S>, other: Self) -> Self {
        Self {
            linear_a: self.linear_a.or(mask, other.linear_a),
            angular_a: self.angular_a.or(mask, other.angular_a),
            linear_b: self.linear_b.or(mask, other.linear_b),
            angular_b: self.angular_b.or(mask, other.angular_b),
            ..self
        }
    }

    #[inline(always)]
    pub fn store(self, bodies: &mut [Moving<S>], a: u32, b: u32) {
        let body = &mut bodies[a as usize];
        (body.linear, body.angular) = (self.linear_a, self.angular_a);
        let body = &mut bodies[b as usize];
        (body.linear, body.angular) = (self.linear_b, self.angular_b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    /// Minus nought is what the velocities of things at rest often are, and a sum with +0 would make it +0.
    #[test]
    fn a_row_without_effect_keeps_the_sign_of_nought() {
        dispatch!(Level::new(), simd => keeps_signs(simd));
    }

    fn keeps_signs<S: Simd>(simd: S) {
        let nought = Vector::splat(simd, Vec3::splat(-0.0));
        let mut body = Moving::ground(simd);
        (body.linear, body.angular, body.inverse_mass) = (nought, nought, 1.0);
        let bodies = [body, body];
        let mut pair = Pair::of(simd, &bodies, 0, 1);
        let zero = Vector::splat(simd, Vec3::ZERO);
        let nobody = Mask::from_bitmask(simd, 0);
        pair.push(&Row::new(zero, zero, zero, &bodies[0], &bodies[1]).only(nobody), splat(simd, 0.0));
        for velocity in [pair.linear_a, pair.angular_a, pair.linear_b, pair.angular_b] {
            assert!(velocity.lane(0).to_array().iter().all(|v| v.to_bits() == (-0.0f32).to_bits()));
        }
    }
}
