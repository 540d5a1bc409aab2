//! The sweeps of a small step over all contacts, and the motion between them.

use super::lanes::{Mask, Number, all, at_least, at_most, splat, within};
use super::rows::{Aim, Friction, Moving, Normal, Pair};
use super::union::WidePatch;
use super::{Softness, Wide};
use crate::world::{
    Body, SimSettings,
    constants::{
        HIT_SPEED, MAX_FRICTION_SWEEPS, MAX_PUSHING_SWEEPS, MAX_RELAXING_SWEEPS, MIN_PUSHING_SWEEPS, OVER_RELAXATION,
        RELAXED_SPEED,
    },
};
use fearless_simd::prelude::*;

/// How a sweep goes over the contacts.
struct Sweep {
    backwards: bool,
    /// What hits takes so many times the impulse that would stop what is above `HIT_SPEED`.
    relaxation: f32,
}

impl Sweep {
    const PLAIN: Self = Self { backwards: false, relaxation: 1.0 };
}

impl<S: Simd> Wide<S> {
    /// All small steps of a substep.
    #[inline(always)]
    pub fn small_steps(&mut self, bodies: &[Body], settings: &SimSettings, soft: &Softness) {
        let simd = self.simd;
        let h = settings.small_step();
        // Lanes without a candidate, too: they have no contacts.
        let everyone = all(simd, true);
        for _ in 0..settings.position_iterations.max(1) {
            simd.vectorize(
                #[inline(always)]
                || {
                    self.accelerate(bodies, settings, h);
                    self.warm_start();
                },
            );
            self.solve(everyone, settings, soft);
            let heated = self.gains_energy();
            if heated.any_true() {
                self.start_cold(heated);
                self.locate(settings, soft, heated);
                self.solve(heated, settings, soft);
            }
        }
        for _ in 1..settings.velocity_iterations {
            self.disturb(everyone);
            self.sweep_friction();
            self.sweep_normals::<false>(settings, Sweep::PLAIN);
        }
    }

    /// The sweeps of a small step of these candidates, and the motion between them.
    #[inline(always)]
    fn solve(&mut self, candidates: Mask<S>, settings: &SimSettings, soft: &Softness) {
        for sweep in 0..MAX_PUSHING_SWEEPS {
            if sweep < MIN_PUSHING_SWEEPS {
                self.disturb(candidates);
            }
            if sweep < MAX_FRICTION_SWEEPS {
                self.sweep_friction();
            }
            self.sweep_normals::<true>(settings, Sweep { backwards: sweep % 2 == 1, ..Sweep::PLAIN });
            if sweep + 1 >= MIN_PUSHING_SWEEPS && self.calm() {
                break;
            }
        }
        self.simd.vectorize(
            #[inline(always)]
            || {
                self.advance(settings.small_step(), candidates);
                self.locate(settings, soft, candidates);
            },
        );
        self.disturb(candidates);
        for sweep in 0..MAX_RELAXING_SWEEPS {
            self.sweep_friction();
            let relaxation = if sweep == 0 { 1.0 } else { OVER_RELAXATION };
            self.sweep_normals::<false>(settings, Sweep { relaxation, ..Sweep::PLAIN });
            if self.calm() {
                break;
            }
        }
    }

    /// All that moves in these candidates is restless.
    #[inline(always)]
    pub fn disturb(&mut self, candidates: Mask<S>) {
        let nobody = all(self.simd, false);
        for body in &mut self.bodies {
            let who = if body.inverse_mass == 0.0 { nobody } else { candidates };
            body.restless = [who, nobody];
        }
    }

    /// Ends a sweep: true if nothing is restless any more.
    #[inline(always)]
    pub fn calm(&mut self) -> bool {
        let nobody = all(self.simd, false);
        let mut left = nobody;
        for body in &mut self.bodies {
            let [_, now] = body.restless;
            left |= now;
            body.restless = [now, nobody];
        }
        left.all_false()
    }

    #[inline(always)]
    fn accelerate(&mut self, bodies: &[Body], settings: &SimSettings, h: f32) {
        let linear = 1.0 / (1.0 + h * settings.linear_damping);
        let angular = 1.0 / (1.0 + h * settings.angular_damping);
        for (moving, body) in self.bodies.iter_mut().zip(bodies) {
            if !body.is_static() {
                moving.linear = moving.linear.plus_y(h * settings.gravity).times(linear);
                moving.spin = moving.spin.times(angular);
                moving.free = [moving.linear, moving.spin, moving.shift, moving.turn];
            }
        }
    }

    #[inline(always)]
    fn warm_start(&mut self) {
        let Self { bodies, union, frictions, normals, .. } = self;
        for (patch, f) in union.patches.iter().zip(&*frictions) {
            let mut pair = Pair::of(bodies, patch.a, patch.b);
            let [u, v, twist] = f.impulse;
            pair.push(&f.tangents[0], u);
            pair.push(&f.tangents[1], v);
            pair.twist(&f.twist, twist);
            pair.store(bodies, patch.a, patch.b);
        }
        for patch in &union.patches {
            let mut pair = Pair::of(bodies, patch.a, patch.b);
            for n in &normals[patch.points()] {
                pair.push(&n.row, n.impulse);
            }
            pair.store(bodies, patch.a, patch.b);
        }
    }

    /// Coulomb: the tangential impulse stays in the disk of radius μ times the patch's normal impulse, the twist below
    /// what the points' friction can resist about the centre.
    #[inline(always)]
    fn sweep_friction(&mut self) {
        self.simd.vectorize(
            #[inline(always)]
            || {
                for (patch, f) in self.union.patches.iter().zip(&mut self.frictions) {
                    let solved = patch.present() & restless(&self.bodies, patch);
                    if solved.all_false() {
                        continue;
                    }
                    let mut pair = Pair::of(&self.bodies, patch.a, patch.b);
                    f.solve(&mut pair, solved);
                    pair.store(&mut self.bodies, patch.a, patch.b);
                }
            },
        );
    }

    /// One sweep over all patches, one way or the other: with springs overlap is pushed out, without only approach is
    /// stopped. What is still apart may come no closer than touching. A sweep that changes the relative speed of a
    /// contact makes its bodies restless.
    #[inline(always)]
    fn sweep_normals<const SPRINGS: bool>(&mut self, settings: &SimSettings, Sweep { backwards, relaxation }: Sweep) {
        self.simd.vectorize(
            #[inline(always)]
            || {
                let Self { simd, bodies, union, frictions, normals, .. } = self;
                let count = union.patches.len();
                for i in 0..count {
                    let i = if backwards { count - 1 - i } else { i };
                    let patch = &union.patches[i];
                    let solved = patch.present() & restless(bodies, patch);
                    if solved.all_false() {
                        continue;
                    }
                    let mut pair = Pair::of(bodies, patch.a, patch.b);
                    let mut disturbed = all(*simd, false);
                    let points = &mut normals[patch.points()];
                    for k in 0..points.len() {
                        let n = &mut points[if backwards { points.len() - 1 - k } else { k }];
                        disturbed |= if SPRINGS {
                            n.solve_spring(&mut pair, solved)
                        } else {
                            n.solve_rigid(&mut pair, solved, relaxation)
                        };
                    }
                    if !SPRINGS {
                        frictions[i].bound(points, settings.friction);
                    }
                    pair.store(bodies, patch.a, patch.b);
                    if disturbed.any_true() {
                        for body in [patch.a, patch.b] {
                            let body = &mut bodies[body as usize];
                            if body.inverse_mass != 0.0 {
                                body.restless[1] |= disturbed;
                            }
                        }
                    }
                }
            },
        )
    }

    /// Moves the bodies of these candidates by their velocities.
    #[inline(always)]
    fn advance(&mut self, h: f32, candidates: Mask<S>) {
        for moving in &mut self.bodies {
            moving.shift = (moving.shift + moving.linear.times(h)).or(candidates, moving.shift);
            moving.turn = (moving.turn + moving.spin.times(h)).or(candidates, moving.turn);
        }
    }
}

/// The candidates in which a patch has to be solved.
#[inline(always)]
pub fn restless<S: Simd>(bodies: &[Moving<S>], patch: &WidePatch<S>) -> Mask<S> {
    let [[before_a, now_a], [before_b, now_b]] = [patch.a, patch.b].map(|body| bodies[body as usize].restless);
    before_a | now_a | before_b | now_b
}

impl<S: Simd> Friction<S> {
    #[inline(always)]
    fn solve(&mut self, pair: &mut Pair<S>, solved: Mask<S>) {
        let [old_u, old_v, old_twist] = self.impulse;
        let wanted = old_twist - self.twist.mass * pair.twisting(&self.twist);
        let twist = solved.select(within::<S>(wanted, self.twist_limit), old_twist);
        pair.twist(&self.twist, twist - old_twist);
        let [u, v] = &self.tangents;
        // One mass for both, or what slides would be drawn aside, towards the tangent of the larger one.
        let mass = at_most::<S>(u.mass, v.mass);
        let mut new_u = old_u - mass * pair.relative(u);
        let mut new_v = old_v - mass * pair.relative(v);
        let length = (new_u * new_u + new_v * new_v).sqrt();
        let slips = solved & length.simd_gt(self.limit);
        // A branch, because the processor goes on without the root and the quotient while it guesses that nothing
        // slips.
        if slips.any_true() {
            let scale = slips.select(self.limit / length, splat(length.token(), 1.0));
            (new_u, new_v) = (new_u * scale, new_v * scale);
        }
        (new_u, new_v) = (solved.select(new_u, old_u), solved.select(new_v, old_v));
        pair.push(u, new_u - old_u);
        pair.push(v, new_v - old_v);
        self.impulse = [new_u, new_v, twist];
    }

    /// Takes over what the points' impulses allow.
    #[inline(always)]
    pub fn bound(&mut self, points: &[Normal<S>], coefficient: f32) {
        let zero = splat(self.limit.token(), 0.0);
        let (mut sum, mut twist) = (zero, zero);
        for n in points {
            sum += n.impulse;
            twist += n.impulse * n.lever;
        }
        (self.limit, self.twist_limit) = (sum * coefficient, twist * coefficient);
    }
}

impl<S: Simd> Normal<S> {
    /// Gives where it changed an impulse by more than `Aim::tolerance`.
    #[inline(always)]
    fn solve_spring(&mut self, pair: &mut Pair<S>, solved: Mask<S>) -> Mask<S> {
        let Aim { spring_bias, spring_mass, leak, tolerance, .. } = self.aim;
        let correction = spring_mass * (pair.relative(&self.row) + spring_bias);
        let total = self.impulse - correction - leak * (self.impulse - self.load);
        self.take(pair, total, solved).abs().simd_gt(tolerance)
    }

    /// Gives where the contact's relative speed changed by more than `RELAXED_SPEED`.
    #[inline(always)]
    fn solve_rigid(&mut self, pair: &mut Pair<S>, solved: Mask<S>, relaxation: f32) -> Mask<S> {
        let mass = self.row.mass;
        let mut correction = mass * (pair.relative(&self.row) + self.aim.rigid_bias);
        if relaxation > 1.0 {
            let hit = correction - within::<S>(correction, mass * HIT_SPEED);
            correction += hit * (relaxation - 1.0);
        }
        self.take(pair, self.impulse - correction, solved).abs().simd_gt(mass * RELAXED_SPEED)
    }

    /// Takes over an impulse where it is `solved`, nought if it would pull; it is nought where a candidate has no such
    /// point, because there is no mass. Gives the change.
    #[inline(always)]
    fn take(&mut self, pair: &mut Pair<S>, total: Number<S>, solved: Mask<S>) -> Number<S> {
        let zero = splat(total.token(), 0.0);
        let total = at_least::<S>(total, zero);
        let change = solved.select(total - self.impulse, zero);
        pair.push(&self.row, change);
        self.impulse = solved.select(total, self.impulse);
        change
    }
}
