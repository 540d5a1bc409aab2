//! Bodies and constraints as the sweeps need them, of several candidates side by side.

use super::Softness;
use super::follow::Made;
use super::lanes::{Mask, Matrix, Number, Vector, all, at_least, splat};
use crate::world::{
    SimSettings,
    constants::{PUSHED_SPEED, TOUCHING_DEPTH},
};
use fearless_simd::prelude::*;
use glam::Vec3;

/// State of a body inside a substep.
#[derive(Clone, Copy)]
pub struct Moving<S: Simd> {
    /// Where it is at the substep's start.
    pub origin: Vector<S>,
    pub linear: Vector<S>,
    /// Angular velocity, as `frame` has it.
    pub spin: Vector<S>,
    /// Shift since the substep's start, m.
    pub shift: Vector<S>,
    /// Turn since the substep's start, as `frame` has it.
    pub turn: Vector<S>,
    /// The same in the world, rad, when the contacts were last located, and what of it is about `round`.
    pub turned: Vector<S>,
    pub rolled: Vector<S>,
    /// Linear velocity, spin, shift and turn before the impulses of the small step.
    pub free: [Vector<S>; 4],
    /// The same for all candidates.
    pub inverse_mass: f32,
    /// From the world to the body's principal axes at the substep's start, each scaled by the root of its inverse
    /// moment of inertia: there a torque's arm is also what a unit impulse does to the spin, and the body weighs the
    /// same about all axes.
    pub frame: Matrix<S>,
    /// One for every axis about which it may turn in a substep and keep its inertia about as it is, nought for the
    /// others; the same for all candidates.
    pub round: Vec3,
    /// A bit for every candidate: true if the body has contacts, or may come to touch something.
    pub touched: u32,
    /// The same with something fixed.
    pub held: u32,
    /// The candidates in which a contact of the body changed its speed in the last sweep, and in the present one.
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
            spin: zero,
            shift: zero,
            turn: zero,
            turned: zero,
            rolled: zero,
            free: [zero; 4],
            inverse_mass: 0.0,
            frame: Matrix::zero(simd),
            round: Vec3::ZERO,
            touched: 0,
            held: 0,
            restless: [all(simd, false); 2],
        }
    }

    /// True if the body of this candidate has contacts, or may come to touch something; and if that is something fixed.
    #[inline(always)]
    pub fn touches(&self, lane: usize) -> [bool; 2] {
        [self.touched, self.held].map(|lanes| lanes >> lane & 1 == 1)
    }
}

/// One scalar constraint between two bodies: the relative velocity of their touching points along `axis`. Without
/// effect on candidates whose axis is nought.
#[derive(Clone, Copy, Debug)]
pub struct Row<S: Simd> {
    pub axis: Vector<S>,
    /// Torque of a unit impulse about either body, in its frame.
    torque_a: Vector<S>,
    torque_b: Vector<S>,
    /// Effective mass, kg.
    pub mass: Number<S>,
}

impl<S: Simd> Row<S> {
    #[inline(always)]
    fn new(axis: Vector<S>, torque_a: Vector<S>, torque_b: Vector<S>, a: &Moving<S>, b: &Moving<S>) -> Self {
        let turning = torque_a.dot(torque_a) + torque_b.dot(torque_b);
        let mass = inverse::<S>(axis.dot(axis) * (a.inverse_mass + b.inverse_mass) + turning);
        Self { axis, torque_a, torque_b, mass }
    }

    /// With lever arms on both bodies.
    #[inline(always)]
    pub fn along(axis: Vector<S>, arms: [Vector<S>; 2], a: &Moving<S>, b: &Moving<S>) -> Self {
        Self::new(axis, a.frame * arms[0].cross(axis), b.frame * arms[1].cross(axis), a, b)
    }

    /// This where `mask` says so, `other` elsewhere.
    #[inline(always)]
    pub fn or(&self, mask: Mask<S>, other: &Self) -> Self {
        Self {
            axis: self.axis.or(mask, other.axis),
            torque_a: self.torque_a.or(mask, other.torque_a),
            torque_b: self.torque_b.or(mask, other.torque_b),
            mass: mask.select(self.mass, other.mass),
        }
    }

    /// How far the touching points have moved apart along the axis since the substep's start, m.
    #[inline(always)]
    pub fn moved(&self, a: &Moving<S>, b: &Moving<S>) -> Number<S> {
        self.axis.dot(b.shift - a.shift) + self.torque_b.dot(b.turn) - self.torque_a.dot(a.turn)
    }
}

/// The relative spin of two bodies about an axis.
#[derive(Clone, Copy, Debug)]
pub struct Twist<S: Simd> {
    /// Unit torque about the axis, in either body's frame.
    torque_a: Vector<S>,
    torque_b: Vector<S>,
    /// Effective moment of inertia, kg m².
    pub mass: Number<S>,
}

impl<S: Simd> Twist<S> {
    #[inline(always)]
    pub fn about(axis: Vector<S>, a: &Moving<S>, b: &Moving<S>) -> Self {
        let (torque_a, torque_b) = (a.frame * axis, b.frame * axis);
        Self { torque_a, torque_b, mass: inverse::<S>(torque_a.dot(torque_a) + torque_b.dot(torque_b)) }
    }

    /// What a unit torque adds to the spin of either body, 1/(kg m²).
    #[inline(always)]
    pub fn gives(&self) -> [Number<S>; 2] {
        [self.torque_a.dot(self.torque_a), self.torque_b.dot(self.torque_b)]
    }
}

/// One over what is above nought.
#[inline(always)]
pub fn inverse<S: Simd>(number: Number<S>) -> Number<S> {
    let zero = splat(number.token(), 0.0);
    number.simd_gt(zero).select(splat(number.token(), 1.0) / number, zero)
}

/// A contact point ready to solve.
#[derive(Clone, Copy, Debug)]
pub struct Normal<S: Simd> {
    pub row: Row<S>,
    /// Separation less the rest offset, m, if the bodies were where they began the substep.
    pub start: Number<S>,
    /// Distance from the patch's centre, m: lever of its friction against twisting.
    pub lever: Number<S>,
    /// Accumulated impulse of one small step, N s.
    pub impulse: Number<S>,
    /// `Contact::load`.
    pub load: Number<S>,
    /// `Contact::rest`.
    pub rest: Number<S>,
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
    /// Change of the spring's impulse that is none, N s.
    pub tolerance: Number<S>,
}

impl<S: Simd> Aim<S> {
    #[inline(always)]
    pub fn new(
        separation: Number<S>,
        rest: Number<S>,
        mass: Number<S>,
        settings: &SimSettings,
        soft: &Softness,
    ) -> Self {
        let zero = splat(separation.token(), 0.0);
        let overlaps = separation.simd_le(zero);
        let deep = separation.simd_lt(splat(separation.token(), -TOUCHING_DEPTH));
        let rigid_bias = at_least::<S>(separation, zero) / settings.small_step();
        let push_out =
            at_least::<S>(soft.push_out::<S>(separation, rest), splat(separation.token(), -settings.max_push_out));
        Self {
            rigid_bias,
            spring_bias: overlaps.select(push_out, rigid_bias),
            spring_mass: overlaps.select(mass * soft.mass_scale, mass),
            leak: overlaps.select(splat(separation.token(), soft.impulse_scale), zero),
            tolerance: deep.select(splat(separation.token(), f32::MAX), mass * PUSHED_SPEED),
        }
    }

    /// This where `mask` says so, `other` elsewhere.
    #[inline(always)]
    pub fn or(self, mask: Mask<S>, other: &Self) -> Self {
        Self {
            rigid_bias: mask.select(self.rigid_bias, other.rigid_bias),
            spring_bias: mask.select(self.spring_bias, other.spring_bias),
            spring_mass: mask.select(self.spring_mass, other.spring_mass),
            leak: mask.select(self.leak, other.leak),
            tolerance: mask.select(self.tolerance, other.tolerance),
        }
    }
}

/// Friction of a patch: two directions at the centre of pressure and the twist about the normal. All tangential forces
/// of a flat patch add up to these three, and three rows cannot fight one another as two rows a point do.
#[derive(Clone, Copy, Debug)]
pub struct Friction<S: Simd> {
    pub tangents: [Row<S>; 2],
    pub twist: Twist<S>,
    /// What the patch's lever arms were made for.
    pub made_for: Made<S>,
    /// Accumulated impulses of one small step, N s and N m s.
    pub impulse: [Number<S>; 3],
    /// What the points' impulses after the last rigid sweep allow: N s along the surface, N m s about the normal.
    pub limit: Number<S>,
    pub twist_limit: Number<S>,
}

/// Velocities of two bodies while their constraints are solved.
#[derive(Clone, Copy)]
pub struct Pair<S: Simd> {
    inverse_mass_a: f32,
    inverse_mass_b: f32,
    linear_a: Vector<S>,
    spin_a: Vector<S>,
    linear_b: Vector<S>,
    spin_b: Vector<S>,
}

impl<S: Simd> Pair<S> {
    #[inline(always)]
    pub fn of(bodies: &[Moving<S>], a: u32, b: u32) -> Self {
        let (a, b) = (&bodies[a as usize], &bodies[b as usize]);
        Self {
            inverse_mass_a: a.inverse_mass,
            inverse_mass_b: b.inverse_mass,
            linear_a: a.linear,
            spin_a: a.spin,
            linear_b: b.linear,
            spin_b: b.spin,
        }
    }

    /// Relative velocity along the row, m/s.
    #[inline(always)]
    pub fn relative(&self, row: &Row<S>) -> Number<S> {
        row.axis.dot(self.linear_b - self.linear_a) + row.torque_b.dot(self.spin_b) - row.torque_a.dot(self.spin_a)
    }

    /// The share of either body in that.
    #[inline(always)]
    pub fn speeds(&self, row: &Row<S>) -> [Number<S>; 2] {
        let of_a = row.axis.dot(self.linear_a) + row.torque_a.dot(self.spin_a);
        [-of_a, row.axis.dot(self.linear_b) + row.torque_b.dot(self.spin_b)]
    }

    /// What a unit impulse along the row adds to either, 1/kg.
    #[inline(always)]
    pub fn gives(&self, row: &Row<S>) -> [Number<S>; 2] {
        let size = row.axis.dot(row.axis);
        let of_a = size * self.inverse_mass_a + row.torque_a.dot(row.torque_a);
        [of_a, size * self.inverse_mass_b + row.torque_b.dot(row.torque_b)]
    }

    #[inline(always)]
    pub fn push(&mut self, row: &Row<S>, impulse: Number<S>) {
        self.linear_a -= row.axis * (impulse * self.inverse_mass_a);
        self.spin_a -= row.torque_a * impulse;
        self.linear_b += row.axis * (impulse * self.inverse_mass_b);
        self.spin_b += row.torque_b * impulse;
    }

    /// Relative spin, rad/s.
    #[inline(always)]
    pub fn twisting(&self, twist: &Twist<S>) -> Number<S> {
        twist.torque_b.dot(self.spin_b) - twist.torque_a.dot(self.spin_a)
    }

    /// The share of either body in that.
    #[inline(always)]
    pub fn spins(&self, twist: &Twist<S>) -> [Number<S>; 2] {
        [-twist.torque_a.dot(self.spin_a), twist.torque_b.dot(self.spin_b)]
    }

    #[inline(always)]
    pub fn twist(&mut self, twist: &Twist<S>, impulse: Number<S>) {
        self.spin_a -= twist.torque_a * impulse;
        self.spin_b += twist.torque_b * impulse;
    }

    #[inline(always)]
    pub fn store(self, bodies: &mut [Moving<S>], a: u32, b: u32) {
        let body = &mut bodies[a as usize];
        (body.linear, body.spin) = (self.linear_a, self.spin_a);
        let body = &mut bodies[b as usize];
        (body.linear, body.spin) = (self.linear_b, self.spin_b);
    }
}
