//! What contacts carry when a simulation begins.
//!
//! Springs that carry nothing yet let a stack sag until they have learned what lies on them, and what comes back up
//! gains energy. So the forces that hold everything where it is are found first: each body is held by what it lies on
//! as if that were fixed, and what this takes weighs on that in turn. Loads go down, so a few sweeps find them however
//! high the stack and however heavy what is on top (the order in which E. Guendelman et al., "Nonconvex rigid bodies with
//! stacking", 2003, propagate shocks, turned round). Where each of two bodies lies on the other, as a book between the
//! boards of a shelf, both give way; and what more bodies hand round and round is not handed over.
//!
//! Here velocities stand for accelerations, m/s², and impulses for forces, N and N m.

use super::Wide;
use super::lanes::{Mask, Number, Vector, all, at_least, at_most, splat, within};
use super::rows::{Friction, Normal, Pair, inverse};
use super::sweep::restless;
use super::unsigned;
use crate::cpu::simulate::Workspace;
use crate::world::{
    SimSettings,
    constants::{BEARING_COSINE, LOAD_LOSS, LOAD_TOLERANCE, MAX_LOAD_SWEEPS, TOUCHING_DEPTH},
};
use fearless_simd::prelude::*;
use glam::Vec3;

/// How much the bodies of a patch give way: nought where a body bears the other, one elsewhere.
pub struct Give<S: Simd>([Number<S>; 2]);

impl<S: Simd> Wide<S> {
    /// Gives the contacts of these candidates, which have none yet, their loads.
    #[inline(always)]
    pub fn first_loads(&mut self, settings: &SimSettings, candidates: &mut [Workspace]) {
        let everyone = all(self.simd, true);
        let rest = Vector::splat(self.simd, Vec3::ZERO);
        let fall = Vector::splat(self.simd, Vec3::Y * settings.gravity);
        for body in self.bodies.iter_mut().filter(|body| body.inverse_mass > 0.0) {
            (body.linear, body.spin) = (fall, rest);
        }
        self.gives.clear();
        for patch in 0..self.union.patches.len() {
            self.gives.push(self.give(patch));
        }
        let tolerance = LOAD_TOLERANCE * settings.gravity.abs();
        // First without friction, which would hold what still turns while the sweeps go on.
        for rubs in [false, true] {
            self.disturb(everyone);
            for sweep in 0..MAX_LOAD_SWEEPS {
                self.sweep_loads(settings.friction, tolerance, rubs, sweep % 2 == 1);
                if self.calm() {
                    break;
                }
            }
        }
        self.hand_over_loads(settings.small_step(), candidates);
    }

    /// The upper one of a patch's two bodies alone, both where they are side by side or lie on each other.
    #[inline(always)]
    fn give(&self, patch: usize) -> Give<S> {
        let patches = &self.union.patches;
        let (none, one) = (splat(self.simd, 0.0), splat(self.simd, 1.0));
        let [mut upwards, mut downwards] = [all(self.simd, false); 2];
        for other in patches.iter().filter(|other| (other.a, other.b) == (patches[patch].a, patches[patch].b)) {
            let [_, up, _] = other.normal.components();
            upwards |= other.present() & up.simd_gt(BEARING_COSINE);
            downwards |= other.present() & up.simd_lt(-BEARING_COSINE);
        }
        let [_, up, _] = patches[patch].normal.components();
        let [a_bears, b_bears] = [!downwards & up.simd_gt(BEARING_COSINE), !upwards & up.simd_lt(-BEARING_COSINE)];
        Give([a_bears.select(none, one), b_bears.select(none, one)])
    }

    /// One sweep over all patches, one way or the other. What is found to move by more than `tolerance` makes its
    /// bodies restless.
    #[inline(always)]
    fn sweep_loads(&mut self, coefficient: f32, tolerance: f32, rubs: bool, backwards: bool) {
        let Self { simd, bodies, union, frictions, normals, gives } = self;
        let count = union.patches.len();
        for i in 0..count {
            let i = if backwards { count - 1 - i } else { i };
            let (patch, give, friction) = (&union.patches[i], &gives[i], &mut frictions[i]);
            let solved = patch.present() & restless(bodies, patch);
            if solved.all_false() {
                continue;
            }
            let mut pair = Pair::of(bodies, patch.a, patch.b);
            let mut disturbed = all(*simd, false);
            if rubs {
                disturbed |= friction.hold(&mut pair, give, solved, tolerance);
            }
            let points = &mut normals[patch.points()];
            for k in 0..points.len() {
                let n = &mut points[if backwards { points.len() - 1 - k } else { k }];
                disturbed |= n.hold(&mut pair, give, solved, tolerance);
            }
            friction.bound(points, coefficient);
            pair.store(bodies, patch.a, patch.b);
            for body in [patch.a, patch.b] {
                let body = &mut bodies[body as usize];
                if body.inverse_mass > 0.0 {
                    body.restless[1] |= disturbed;
                }
            }
        }
    }

    /// Writes the forces into the contacts of bodies that have come to rest, as impulses of a small step of `h`.
    #[inline(always)]
    fn hand_over_loads(&self, h: f32, candidates: &mut [Workspace]) {
        for (friction, wide) in self.frictions.iter().zip(&self.union.patches) {
            let [u, v, twist] = friction.impulse;
            let tangential = friction.tangents[0].axis * u + friction.tangents[1].axis * v;
            let normals = &self.normals[wide.points()];
            let unsettled = restless(&self.bodies, wide).to_bitmask();
            for (lane, own, turns) in wide.owners().filter(|(lane, ..)| unsettled >> lane & 1 == 0) {
                let contacts = &mut candidates[lane].contacts;
                let patch = &mut contacts.patches[own];
                patch.friction = unsigned(tangential.lane(lane) * h);
                patch.twist = twist[lane] * h + 0.0;
                let points = &mut contacts.points[patch.first as usize..][..turns.len()];
                for (contact, &turn) in points.iter_mut().zip(turns) {
                    contact.impulse = normals[turn].impulse[lane] * h;
                    contact.load = contact.excess();
                    contact.impulse = contact.load;
                }
            }
        }
    }
}

impl<S: Simd> Give<S> {
    /// What the bodies' shares add up to.
    #[inline(always)]
    fn sum(&self, [a, b]: [Number<S>; 2]) -> Number<S> {
        let Self([of_a, of_b]) = *self;
        a * of_a + b * of_b
    }
}

impl<S: Simd> Normal<S> {
    /// Takes the force that keeps the contact from closing, unless it is open, or too deep to carry a load. Gives where that
    /// changed by more than `tolerance`.
    #[inline(always)]
    fn hold(&mut self, pair: &mut Pair<S>, give: &Give<S>, solved: Mask<S>, tolerance: f32) -> Mask<S> {
        let zero = splat(self.impulse.token(), 0.0);
        let touches = solved & self.start.simd_le(TOUCHING_DEPTH) & self.start.simd_gt(-1.0 / LOAD_LOSS);
        let mass = inverse::<S>(give.sum(pair.gives(&self.row)));
        let total = at_least::<S>(self.impulse - mass * give.sum(pair.speeds(&self.row)), zero);
        let change = touches.select(total - self.impulse, zero);
        pair.push(&self.row, change);
        self.impulse = touches.select(total, self.impulse);
        change.abs().simd_gt(mass * tolerance)
    }
}

impl<S: Simd> Friction<S> {
    /// Takes the forces that keep the patch from sliding and spinning, as far as friction goes. Gives where sliding
    /// changed by more than `tolerance`.
    #[inline(always)]
    fn hold(&mut self, pair: &mut Pair<S>, give: &Give<S>, solved: Mask<S>, tolerance: f32) -> Mask<S> {
        let [old_u, old_v, old_twist] = self.impulse;
        let inertia = inverse::<S>(give.sum(self.twist.gives()));
        let wanted = old_twist - inertia * give.sum(pair.spins(&self.twist));
        let twist = solved.select(within::<S>(wanted, self.twist_limit), old_twist);
        pair.twist(&self.twist, twist - old_twist);
        let [u, v] = &self.tangents;
        let mass = at_most::<S>(inverse::<S>(give.sum(pair.gives(u))), inverse::<S>(give.sum(pair.gives(v))));
        let mut new_u = old_u - mass * give.sum(pair.speeds(u));
        let mut new_v = old_v - mass * give.sum(pair.speeds(v));
        let length = (new_u * new_u + new_v * new_v).sqrt();
        let scale = length.simd_gt(self.limit).select(self.limit / length, splat(length.token(), 1.0));
        (new_u, new_v) = (solved.select(new_u * scale, old_u), solved.select(new_v * scale, old_v));
        let changes = [new_u - old_u, new_v - old_v];
        pair.push(u, changes[0]);
        pair.push(v, changes[1]);
        self.impulse = [new_u, new_v, twist];
        changes[0].abs().simd_gt(mass * tolerance) | changes[1].abs().simd_gt(mass * tolerance)
    }
}
