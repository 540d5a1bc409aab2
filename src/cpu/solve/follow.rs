//! Contacts go with bodies that have moved since their rows were made: separations to first order in the turn, and
//! lever arms too. A ball of 5 cm that rolls at 1 m/s turns by 10° in a substep, and with the arms of its start what
//! bears it would brake it. The direction of contact stays. With separations to second order what tumbles would sink
//! in, because the corners that come down next are no contacts yet.
//!
//! What is slender keeps its arms when it turns across its length: the solver has its inertia as it was at the
//! substep's start, and arms that do not match it gain energy.

use super::lanes::{Mask, Vector};
use super::rows::{Aim, Moving, Row};
use super::{Softness, Wide};
use crate::world::{
    SimSettings,
    constants::{ARM_TOLERANCE, TURN_TOLERANCE},
};
use fearless_simd::prelude::*;
use glam::Vec3;

impl<S: Simd> Wide<S> {
    /// Contacts of these candidates where their bodies are now. Those of others keep their bits.
    #[inline(always)]
    pub fn locate(&mut self, settings: &SimSettings, soft: &Softness, candidates: Mask<S>) {
        let everyone = candidates.all_true();
        for moving in &mut self.bodies {
            moving.turned = moving.frame.back(moving.turn);
            moving.rolled = moving.frame.back(moving.turn.scaled(moving.round));
        }
        for (patch, f) in self.union.patches.iter().zip(&mut self.frictions) {
            let (a, b) = (&self.bodies[patch.a as usize], &self.bodies[patch.b as usize]);
            let motion = Motion::of(a, b);
            let far = candidates & patch.present() & f.made_for.is_far(&motion);
            let follows = far.any_true();
            if follows {
                f.made_for = Made::of(&motion).or(far, &f.made_for);
                let center = motion.arms([patch.center - a.origin, patch.center - b.origin]);
                for row in &mut f.tangents {
                    *row = Row::along(row.axis, center, a, b).or(far, row);
                }
            }
            let points = &self.union.points[patch.found_points()];
            for (n, point) in self.normals[patch.points()].iter_mut().zip(points) {
                let mut separation = n.start + n.row.moved(a, b);
                if follows {
                    let arms = [point.point - a.origin, point.point - b.origin];
                    n.row = Row::along(n.row.axis, motion.arms(arms), a, b).or(far, &n.row);
                    let now = point.separation - settings.rest_offset + n.row.axis.dot(motion.moved(arms));
                    n.start = far.select(now - n.row.moved(a, b), n.start);
                    separation = far.select(now, separation);
                }
                let aim = Aim::new(separation, n.rest, n.row.mass, settings, soft);
                n.aim = if everyone { aim } else { aim.or(candidates, &n.aim) };
            }
        }
    }
}

/// How two bodies have moved since the substep's start.
#[derive(Clone, Copy, Debug)]
struct Motion<S: Simd> {
    /// How far the second has moved past the first, m.
    passed: Vector<S>,
    /// How either has turned, rad, and how much of that is about `Moving::round`.
    turned: [Vector<S>; 2],
    rolled: [Vector<S>; 2],
    /// Whether both are free.
    is_free: bool,
}

impl<S: Simd> Motion<S> {
    #[inline(always)]
    fn of(a: &Moving<S>, b: &Moving<S>) -> Self {
        Self {
            passed: b.shift - a.shift,
            turned: [a.turned, b.turned],
            rolled: [a.rolled, b.rolled],
            is_free: a.inverse_mass > 0.0 && b.inverse_mass > 0.0,
        }
    }

    /// Lever arms that were `arms` at first. Two free bodies push at a common point, half-way between where either has
    /// it: else their impulses would turn the pair. On something fixed a contact's points go with the body that moves.
    #[inline(always)]
    fn arms(&self, [arm_a, arm_b]: [Vector<S>; 2]) -> [Vector<S>; 2] {
        let [rolled_a, rolled_b] = self.rolled;
        let by = rolled_a.cross(arm_a).plus_cross(rolled_b, arm_b);
        if self.is_free {
            [arm_a + (by + self.passed).times(0.5), arm_b + (by - self.passed).times(0.5)]
        } else {
            [arm_a + by, arm_b + by]
        }
    }

    /// How far a point of the second body has moved past that of the first, with these lever arms at first, going
    /// straight on.
    #[inline(always)]
    fn moved(&self, [arm_a, arm_b]: [Vector<S>; 2]) -> Vector<S> {
        let [turned_a, turned_b] = self.turned;
        self.passed.plus_cross(turned_b, arm_b).plus_cross(arm_a, turned_a)
    }
}

/// The motion for which lever arms were made.
#[derive(Clone, Copy, Debug)]
pub struct Made<S: Simd> {
    passed: Vector<S>,
    rolled: [Vector<S>; 2],
}

impl<S: Simd> Made<S> {
    /// None.
    #[inline(always)]
    pub fn at_start(simd: S) -> Self {
        let zero = Vector::splat(simd, Vec3::ZERO);
        Self { passed: zero, rolled: [zero; 2] }
    }

    #[inline(always)]
    fn of(motion: &Motion<S>) -> Self {
        Self { passed: motion.passed, rolled: motion.rolled }
    }

    /// Where `now` differs so much that lever arms do.
    #[inline(always)]
    fn is_far(&self, now: &Motion<S>) -> Mask<S> {
        let rolled = exceeds(now.rolled[0] - self.rolled[0], TURN_TOLERANCE)
            | exceeds(now.rolled[1] - self.rolled[1], TURN_TOLERANCE);
        if now.is_free { rolled | exceeds(now.passed - self.passed, ARM_TOLERANCE) } else { rolled }
    }

    /// This where `mask` says so, `other` elsewhere.
    #[inline(always)]
    fn or(&self, mask: Mask<S>, other: &Self) -> Self {
        let rolled = [self.rolled[0].or(mask, other.rolled[0]), self.rolled[1].or(mask, other.rolled[1])];
        Self { passed: self.passed.or(mask, other.passed), rolled }
    }
}

/// Where a vector is no shorter than `length`, or none.
#[inline(always)]
fn exceeds<S: Simd>(vector: Vector<S>, length: f32) -> Mask<S> {
    !vector.dot(vector).simd_lt(length * length)
}
