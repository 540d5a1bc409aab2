//! What the solver reads at a substep's start and writes at its end.

use super::follow::Made;
use super::lanes::{Vector, splat};
use super::rows::{Aim, Friction, Moving, Normal, Row, Twist};
use super::{Softness, Wide, unsigned};
use crate::cpu::simulate::Workspace;
use crate::world::{
    Body, SimSettings,
    constants::{LEAST_RESTING_DEPTH, MAX_EDGE_POINTS, PATCH_LOAD_RATE, POINT_LOAD_RATE, RESTING_DEPTH, RESTING_RATE},
};
use fearless_simd::prelude::*;
use glam::{Mat3, Vec3};

impl<S: Simd> Wide<S> {
    #[inline(always)]
    pub fn load(&mut self, bodies: &[Body], settings: &SimSettings, soft: &Softness, candidates: &[Workspace]) {
        self.load_bodies(bodies, candidates);
        self.union.gather(candidates.iter().map(Workspace::contacts), bodies);
        self.load_rows(settings, soft);
    }

    #[inline(always)]
    fn load_bodies(&mut self, bodies: &[Body], candidates: &[Workspace]) {
        self.bodies.clear();
        self.bodies.resize(bodies.len() + 1, Moving::ground(self.simd));
        for (index, (moving, body)) in self.bodies.iter_mut().zip(bodies).enumerate() {
            moving.inverse_mass = body.inverse_mass;
            moving.round = body.round_axes();
            for (lane, candidate) in candidates.iter().enumerate() {
                let (pose, velocity) = (&candidate.poses[index], &candidate.velocities[index]);
                let root = Vec3::from(body.inverse_inertia.to_array().map(f32::sqrt));
                let frame = Mat3::from_diagonal(root) * Mat3::from_quat(pose.rotation).transpose();
                moving.origin.set_lane(lane, pose.translation);
                moving.linear.set_lane(lane, velocity.linear);
                moving.spin.set_lane(lane, velocity.angular);
                moving.frame.set_lane(lane, frame);
            }
            if !body.is_static() {
                moving.spin = (moving.frame * moving.spin).unscaled(body.inverse_inertia);
            }
        }
    }

    #[inline(always)]
    fn load_rows(&mut self, settings: &SimSettings, soft: &Softness) {
        let simd = self.simd;
        self.normals.clear();
        self.frictions.clear();
        for patch in &mut self.union.patches {
            let touched = patch.present().to_bitmask() as u32;
            for [body, other] in [[patch.a, patch.b], [patch.b, patch.a]] {
                let is_fixed = self.bodies[other as usize].inverse_mass == 0.0;
                let body = &mut self.bodies[body as usize];
                body.touched |= touched;
                body.held |= if is_fixed { touched } else { 0 };
            }
            let (a, b) = (&self.bodies[patch.a as usize], &self.bodies[patch.b as usize]);
            let arms = |point: Vector<S>| [point - a.origin, point - b.origin];
            let center = arms(patch.center);
            let tangents = patch.tangents();
            let points = &self.union.points[patch.found_points()];
            // The rows are in the order of the patches, which the points were not.
            patch.first = self.normals.len() as u32;
            for point in points {
                let row = Row::along(point.normal, arms(point.point), a, b);
                let to_center = point.point - patch.center;
                let start = point.separation - settings.rest_offset;
                let met = start.max(splat(simd, -RESTING_DEPTH)).min(splat(simd, -LEAST_RESTING_DEPTH));
                let rest = point.rest.simd_lt(splat(simd, 0.0)).select(point.rest, met);
                self.normals.push(Normal {
                    start,
                    lever: to_center.dot(to_center).sqrt(),
                    impulse: point.impulse,
                    load: point.load,
                    rest,
                    aim: Aim::new(start, rest, row.mass, settings, soft),
                    row,
                });
            }
            let mut friction = Friction {
                tangents: [Row::along(tangents[0], center, a, b), Row::along(tangents[1], center, a, b)],
                twist: Twist::about(patch.normal, a, b),
                made_for: Made::at_start(simd),
                impulse: [patch.friction.dot(tangents[0]), patch.friction.dot(tangents[1]), patch.twist],
                limit: splat(simd, 0.0),
                twist_limit: splat(simd, 0.0),
            };
            friction.bound(&self.normals[patch.points()], settings.friction);
            self.frictions.push(friction);
        }
    }

    /// Writes the impulses into the contacts, and the loads that they carry after a substep of `dt`.
    #[inline(always)]
    pub fn hand_over(&self, settings: &SimSettings, candidates: &mut [Workspace]) {
        let dt = settings.substep();
        let patch_share = (PATCH_LOAD_RATE * dt).min(1.0);
        let point_share = (POINT_LOAD_RATE * dt).min(1.0);
        for (friction, wide) in self.frictions.iter().zip(&self.union.patches) {
            let [u, v, twist] = friction.impulse;
            let tangential = friction.tangents[0].axis * u + friction.tangents[1].axis * v;
            let normals = &self.normals[wide.points()];
            for (lane, own, turns) in wide.owners() {
                let contacts = &mut candidates[lane].contacts;
                let patch = &mut contacts.patches[own];
                patch.friction = unsigned(tangential.lane(lane));
                patch.twist = twist[lane] + 0.0;
                let points = &mut contacts.points[patch.first as usize..][..turns.len()];
                let mut sum = 0.0;
                for (contact, &turn) in points.iter_mut().zip(turns) {
                    contact.impulse = normals[turn].impulse[lane];
                    sum += contact.excess();
                }
                let mean = sum / turns.len() as f32;
                for (contact, &turn) in points.iter_mut().zip(turns) {
                    let own = contact.excess() - mean;
                    contact.rest =
                        yielded(normals[turn].rest[lane], contact.separation - settings.rest_offset, turns.len(), dt);
                    contact.load = contact.load + patch_share * mean + point_share * own;
                }
            }
        }
    }
}

/// Where a contact is at rest after a substep of `dt` that it began at `separation`: deeper if it was pressed hard, and
/// ever deeper if it is one of the `points` of a face.
fn yielded(rest: f32, separation: f32, points: usize, dt: f32) -> f32 {
    let pressed = rest.min(separation + RESTING_DEPTH);
    let sunk = if points > MAX_EDGE_POINTS { pressed - RESTING_RATE * dt } else { pressed };
    sunk.max(-RESTING_DEPTH)
}
