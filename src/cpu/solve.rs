//! Contact solver of one candidate: temporal Gauss–Seidel with soft contacts (the idea of "soft step" in Box2D v3; the
//! small steps are those of PhysX's TGS).
//!
//! A substep is cut into `position_iterations` small steps `h`. Each applies gravity, warm-starts, solves friction and
//! every contact as an overdamped spring, there and back, moves the bodies, and solves once more with rigid contacts,
//! after a hit several times, so that push-out leaves no kinetic energy behind. A plain spring sags under load and a rigid contact
//! rings when a heavy body lies on a light one; this spring is at rest at the load that its patch has carried lately,
//! which does neither. Its share of that load follows far more slowly: a patch must stay stiff against leaning, or towers
//! buckle.
//! Normals are those of the substep's start; separations follow the bodies' motion to first order, and lever arms follow
//! where both bodies are free.

use super::contacts::{Contact, ContactSet, GROUND};
use super::integrate::Turning;
use super::narrow_phase::tangents;
use crate::world::{
    Body, Pose, SimSettings, Velocity,
    constants::{
        ARM_TOLERANCE, CONTACT_DAMPING_RATIO, CONTACT_FREQUENCY, CONTACT_FREQUENCY_SHARE, DEEP_PUSH_OUT_RATE,
        MAX_RELAXING_SWEEPS, PATCH_LOAD_RATE, POINT_LOAD_RATE, PUSHING_SWEEPS, RELAXED_SPEED, RESTING_DEPTH,
        TOUCHING_DEPTH,
    },
};
use glam::{Mat3, Vec3};

/// One scalar constraint between two bodies: the relative velocity of their touching points along `axis`.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    axis: Vec3,
    angular_a: Vec3,
    angular_b: Vec3,
    /// World inverse inertia times the angular parts.
    turn_a: Vec3,
    turn_b: Vec3,
    /// Effective mass, kg.
    mass: f32,
}

impl Row {
    fn new(axis: Vec3, angular_a: Vec3, angular_b: Vec3, a: &Moving, b: &Moving) -> Self {
        let (turn_a, turn_b) = (a.inverse_inertia * angular_a, b.inverse_inertia * angular_b);
        let k =
            axis.length_squared() * (a.inverse_mass + b.inverse_mass) + angular_a.dot(turn_a) + angular_b.dot(turn_b);
        Self { axis, angular_a, angular_b, turn_a, turn_b, mass: if k > 0.0 { 1.0 / k } else { 0.0 } }
    }

    /// The same row with its lever arm on the first body longer by `by`, and shorter on the second.
    fn shifted(&self, by: Vec3, a: &Moving, b: &Moving) -> Self {
        let turn = by.cross(self.axis);
        Self::new(self.axis, self.angular_a + turn, self.angular_b - turn, a, b)
    }
}

/// A contact point ready to solve.
#[derive(Clone, Copy, Debug, Default)]
struct Normal {
    a: u32,
    b: u32,
    row: Row,
    /// Separation at the substep's start less the rest offset, m.
    start: f32,
    /// The same now.
    separation: f32,
    /// Distance from the patch's centre, m: lever of its friction against twisting.
    lever: f32,
    /// Accumulated impulse of one small step, N s.
    impulse: f32,
    /// The impulse after the last rigid sweep: what bounds friction.
    rigid: f32,
    /// `Contact::load`.
    load: f32,
}

/// Friction of a patch: two directions at the centre of pressure and the twist about the normal. All tangential forces
/// of a flat patch add up to these three, and three rows cannot fight one another as two rows a point do.
#[derive(Clone, Copy, Debug, Default)]
struct Friction {
    a: u32,
    b: u32,
    /// Its points.
    first: u32,
    count: u32,
    tangents: [Row; 2],
    /// Lever arms of the centre of pressure on both bodies, m.
    arms: [Vec3; 2],
    twist: Row,
    /// How far the second body had moved past the first when the lever arms were made, m.
    passed: Vec3,
    /// Accumulated impulses of one small step, N s and N m s.
    impulse: [f32; 3],
}

/// State of a body inside a substep.
#[derive(Clone, Copy, Debug, Default)]
struct Moving {
    velocity: Velocity,
    /// Shift and turn since the substep's start, m and rad.
    shift: Vec3,
    turn: Vec3,
    inverse_mass: f32,
    inverse_inertia: Mat3,
    /// True if it has contacts, or may come to touch something.
    touched: bool,
}

/// Scratch of the solver of one candidate; the last entry of `bodies` is the ground.
#[derive(Debug, Default)]
pub struct Solver {
    bodies: Vec<Moving>,
    normals: Vec<Normal>,
    frictions: Vec<Friction>,
}

/// Spring coefficients of a soft contact over a small step.
#[derive(Clone, Copy, Debug)]
struct Softness {
    /// Share of the overlap pushed out per second, 1/s.
    bias_rate: f32,
    mass_scale: f32,
    impulse_scale: f32,
}

impl Softness {
    /// Implicit damped spring over a step `h` (E. Catto, "Soft Constraints", GDC 2011).
    fn new(h: f32) -> Self {
        let omega = std::f32::consts::TAU * CONTACT_FREQUENCY.min(CONTACT_FREQUENCY_SHARE / h);
        let a1 = 2.0 * CONTACT_DAMPING_RATIO + h * omega;
        let a2 = h * omega * a1;
        let a3 = 1.0 / (1.0 + a2);
        Self { bias_rate: omega / a1, mass_scale: a2 * a3, impulse_scale: a3 }
    }

    /// Speed at which two surfaces are to come closer, m/s: deep overlap is left faster.
    fn push_out(&self, separation: f32) -> f32 {
        self.bias_rate * (separation + RESTING_DEPTH) + DEEP_PUSH_OUT_RATE * (separation + TOUCHING_DEPTH).min(0.0)
    }
}

impl Solver {
    /// Advances all bodies by one substep. Contacts keep their impulses for the next call's warm start.
    pub fn substep(
        &mut self,
        bodies: &[Body],
        settings: &SimSettings,
        poses: &mut [Pose],
        velocities: &mut [Velocity],
        contacts: &mut ContactSet,
    ) {
        let h = settings.small_step();
        let soft = Softness::new(h);
        self.load(bodies, settings, poses, velocities, contacts);
        for _ in 0..settings.position_iterations.max(1) {
            self.accelerate(bodies, settings, h);
            self.warm_start();
            for sweep in 0..PUSHING_SWEEPS {
                self.sweep_friction(settings.friction);
                self.sweep_normals(settings, h, Some(soft), sweep % 2 == 1);
            }
            self.advance(h);
            self.follow();
            self.measure();
            for _ in 0..MAX_RELAXING_SWEEPS {
                self.sweep_friction(settings.friction);
                if self.sweep_normals(settings, h, None, false) < RELAXED_SPEED {
                    break;
                }
            }
        }
        for _ in 1..settings.velocity_iterations {
            self.sweep_friction(settings.friction);
            self.sweep_normals(settings, h, None, false);
        }
        let dt = settings.substep();
        self.integrate(bodies, poses, dt);
        for ((moving, velocity), body) in self.bodies.iter().zip(velocities.iter_mut()).zip(bodies) {
            if !body.is_static() {
                *velocity = moving.velocity;
            }
        }
        self.hand_over(dt, contacts);
    }

    /// Writes the impulses into the contacts, and the loads that they carry after a substep of `dt`.
    fn hand_over(&self, dt: f32, contacts: &mut ContactSet) {
        let patch_share = (PATCH_LOAD_RATE * dt).min(1.0);
        let point_share = (POINT_LOAD_RATE * dt).min(1.0);
        for (friction, patch) in self.frictions.iter().zip(&mut contacts.patches) {
            let [u, v, twist] = friction.impulse;
            patch.friction = u * friction.tangents[0].axis + v * friction.tangents[1].axis;
            patch.twist = twist;
            let range = friction.first as usize..(friction.first + friction.count) as usize;
            let normals = &self.normals[range.clone()];
            let mean = normals.iter().map(|n| n.impulse - n.load).sum::<f32>() / friction.count as f32;
            for (normal, contact) in normals.iter().zip(&mut contacts.points[range]) {
                contact.impulse = normal.impulse;
                let own = normal.impulse - normal.load - mean;
                contact.load = normal.load + patch_share * mean + point_share * own;
            }
        }
    }

    fn load(
        &mut self,
        bodies: &[Body],
        settings: &SimSettings,
        poses: &[Pose],
        velocities: &[Velocity],
        contacts: &ContactSet,
    ) {
        self.bodies.clear();
        self.bodies.extend(bodies.iter().zip(poses).zip(velocities).map(|((body, pose), &velocity)| {
            let turn = Mat3::from_quat(pose.rotation);
            Moving {
                velocity,
                inverse_mass: body.inverse_mass,
                inverse_inertia: turn * Mat3::from_diagonal(body.inverse_inertia) * turn.transpose(),
                ..Default::default()
            }
        }));
        self.bodies.push(Moving { inverse_inertia: Mat3::ZERO, ..Default::default() });
        let ground = bodies.len() as u32;
        let origin = |i: u32| poses.get(i as usize).map_or(Vec3::ZERO, |p| p.translation);
        self.normals.clear();
        self.frictions.clear();
        for patch in &contacts.patches {
            let a = if patch.a == GROUND { ground } else { patch.a };
            let b = patch.b;
            let points = contacts.points_of(patch);
            self.bodies[a as usize].touched = true;
            self.bodies[b as usize].touched = true;
            let center = center_of_pressure(points);
            let arms = |point: Vec3| (point - origin(a), point - origin(b));
            let [u, v] = tangents(patch.normal);
            self.frictions.push(Friction {
                a,
                b,
                first: patch.first,
                count: patch.count,
                tangents: [u, v].map(|axis| self.row(a, b, arms(center), axis)),
                arms: arms(center).into(),
                twist: self.twist(a, b, patch.normal),
                passed: Vec3::ZERO,
                impulse: [patch.friction.dot(u), patch.friction.dot(v), patch.twist],
            });
            for contact in points {
                self.normals.push(Normal {
                    a,
                    b,
                    row: self.row(a, b, arms(contact.point), contact.normal),
                    start: contact.separation - settings.rest_offset,
                    separation: contact.separation - settings.rest_offset,
                    lever: contact.point.distance(center),
                    impulse: contact.impulse,
                    rigid: contact.impulse,
                    load: contact.load,
                });
            }
        }
    }

    fn row(&self, a: u32, b: u32, (arm_a, arm_b): (Vec3, Vec3), axis: Vec3) -> Row {
        self.finish(a, b, axis, arm_a.cross(axis), arm_b.cross(axis))
    }

    /// Relative spin about `axis`.
    fn twist(&self, a: u32, b: u32, axis: Vec3) -> Row {
        self.finish(a, b, Vec3::ZERO, axis, axis)
    }

    fn finish(&self, a: u32, b: u32, axis: Vec3, angular_a: Vec3, angular_b: Vec3) -> Row {
        Row::new(axis, angular_a, angular_b, &self.bodies[a as usize], &self.bodies[b as usize])
    }

    fn accelerate(&mut self, bodies: &[Body], settings: &SimSettings, h: f32) {
        let linear = 1.0 / (1.0 + h * settings.linear_damping);
        let angular = 1.0 / (1.0 + h * settings.angular_damping);
        for (moving, body) in self.bodies.iter_mut().zip(bodies) {
            if !body.is_static() {
                moving.velocity.linear.y += h * settings.gravity;
                moving.velocity.linear *= linear;
                moving.velocity.angular *= angular;
            }
        }
    }

    fn warm_start(&mut self) {
        for f in &self.frictions {
            let mut pair = Velocities::of(&self.bodies, f.a, f.b);
            for (row, impulse) in f.tangents.iter().chain([&f.twist]).zip(f.impulse) {
                pair.push(row, impulse);
            }
            pair.store(&mut self.bodies);
        }
        for n in &self.normals {
            let mut pair = Velocities::of(&self.bodies, n.a, n.b);
            pair.push(&n.row, n.impulse);
            pair.store(&mut self.bodies);
        }
    }

    /// Coulomb: the tangential impulse stays in the disk of radius μ times the patch's normal impulse, the twist below
    /// what the points' friction can resist about the centre.
    fn sweep_friction(&mut self, coefficient: f32) {
        for f in &mut self.frictions {
            let mut pair = Velocities::of(&self.bodies, f.a, f.b);
            let points = &self.normals[f.first as usize..][..f.count as usize];
            let limit = coefficient * points.iter().map(|n| n.rigid).sum::<f32>();
            let twist_limit = coefficient * points.iter().map(|n| n.rigid * n.lever).sum::<f32>();

            let twist = (f.impulse[2] - f.twist.mass * pair.relative(&f.twist)).clamp(-twist_limit, twist_limit);
            pair.push(&f.twist, twist - f.impulse[2]);
            let [u, v] = &f.tangents;
            let wanted = [f.impulse[0] - u.mass * pair.relative(u), f.impulse[1] - v.mass * pair.relative(v)];
            let length = (wanted[0] * wanted[0] + wanted[1] * wanted[1]).sqrt();
            let scale = if length > limit { limit / length } else { 1.0 };
            let tangential = wanted.map(|impulse| impulse * scale);
            pair.push(u, tangential[0] - f.impulse[0]);
            pair.push(v, tangential[1] - f.impulse[1]);
            f.impulse = [tangential[0], tangential[1], twist];
            pair.store(&mut self.bodies);
        }
    }

    /// One sweep over all patches, one way or the other: with `soft` overlap is pushed out, without only approach is
    /// stopped. What is still apart may come no closer than touching. Gives the largest change of a contact's relative
    /// speed, m/s.
    fn sweep_normals(&mut self, settings: &SimSettings, h: f32, soft: Option<Softness>, backwards: bool) -> f32 {
        let mut largest = 0.0f32;
        let count = self.frictions.len();
        for i in 0..count {
            let f = &self.frictions[if backwards { count - 1 - i } else { i }];
            let mut pair = Velocities::of(&self.bodies, f.a, f.b);
            let points = &mut self.normals[f.first as usize..][..f.count as usize];
            for k in 0..points.len() {
                let n = &mut points[turn_of(k, backwards, points.len())];
                let separation = n.separation;
                let (mut bias, mut stiffness, mut leak) = (separation.max(0.0) / h, 1.0, 0.0);
                if let Some(soft) = soft
                    && separation <= 0.0
                {
                    bias = soft.push_out(separation).max(-settings.max_push_out);
                    stiffness = soft.mass_scale;
                    leak = soft.impulse_scale;
                }
                let correction = n.row.mass * stiffness * (pair.relative(&n.row) + bias);
                let total = (n.impulse - correction - leak * (n.impulse - n.load)).max(0.0);
                let change = total - n.impulse;
                pair.push(&n.row, change);
                largest = largest.max(change.abs() / n.row.mass);
                n.impulse = total;
            }
            if soft.is_none() {
                for n in points {
                    n.rigid = n.impulse;
                }
            }
            pair.store(&mut self.bodies);
        }
        largest
    }

    /// Moves the bodies by their velocities.
    fn advance(&mut self, h: f32) {
        for moving in &mut self.bodies {
            moving.shift += h * moving.velocity.linear;
            moving.turn += h * moving.velocity.angular;
        }
    }

    /// Separations where the bodies are now.
    fn measure(&mut self) {
        for n in &mut self.normals {
            n.separation = n.start + moved(&n.row, &self.bodies[n.a as usize], &self.bodies[n.b as usize]);
        }
    }

    /// Two free bodies that have moved past each other push at a common point again, half-way: else their impulses would
    /// turn the pair. On something fixed a contact's points go with the body that moves.
    fn follow(&mut self) {
        for f in &mut self.frictions {
            let (a, b) = (&self.bodies[f.a as usize], &self.bodies[f.b as usize]);
            let passed = b.shift - a.shift;
            let fixed = a.inverse_mass == 0.0 || b.inverse_mass == 0.0;
            if fixed || passed.distance_squared(f.passed) < ARM_TOLERANCE * ARM_TOLERANCE {
                continue;
            }
            let by = 0.5 * (passed - f.passed);
            f.passed = passed;
            f.arms = [f.arms[0] + by, f.arms[1] - by];
            let [on_a, on_b] = f.arms;
            f.tangents = f.tangents.map(|row| Row::new(row.axis, on_a.cross(row.axis), on_b.cross(row.axis), a, b));
            for n in &mut self.normals[f.first as usize..][..f.count as usize] {
                n.row = n.row.shifted(by, a, b);
            }
        }
    }

    /// Writes the substep's motion into the poses.
    fn integrate(&mut self, bodies: &[Body], poses: &mut [Pose], dt: f32) {
        for ((moving, body), pose) in self.bodies.iter_mut().zip(bodies).zip(poses) {
            if body.is_static() {
                continue;
            }
            let turning = Turning {
                inverse_inertia: body.inverse_inertia,
                old: pose.rotation,
                spin: moving.velocity.angular,
                turn: moving.turn,
                touched: moving.touched,
            };
            let (rotation, spin) = turning.end(dt);
            *pose = Pose::new(rotation, pose.translation + moving.shift);
            moving.velocity.angular = spin;
        }
    }
}

/// Which of `count` points of a patch comes as the `k`-th of a sweep. Every third, so that points across the patch follow
/// one another and its lean is settled first.
#[inline]
fn turn_of(k: usize, backwards: bool, count: usize) -> usize {
    let k = if backwards { count - 1 - k } else { k };
    if count.is_multiple_of(3) { k } else { 3 * k % count }
}

/// How far the touching points have moved apart along the row's axis since the substep's start, m.
#[inline]
fn moved(row: &Row, a: &Moving, b: &Moving) -> f32 {
    row.axis.dot(b.shift - a.shift) + row.angular_b.dot(b.turn) - row.angular_a.dot(a.turn)
}

/// Where the patch carries its load: the mean of its points, weighted by their last impulses; unweighted at first.
fn center_of_pressure(points: &[Contact]) -> Vec3 {
    let total: f32 = points.iter().map(|p| p.impulse).sum();
    if total > 0.0 {
        points.iter().map(|p| p.impulse * p.point).sum::<Vec3>() / total
    } else {
        points.iter().map(|p| p.point).sum::<Vec3>() / points.len() as f32
    }
}

/// Velocities of two bodies while their constraint is solved.
struct Velocities {
    a: u32,
    b: u32,
    mass_a: f32,
    mass_b: f32,
    velocity_a: Velocity,
    velocity_b: Velocity,
}

impl Velocities {
    #[inline]
    fn of(bodies: &[Moving], a: u32, b: u32) -> Self {
        let (body_a, body_b) = (&bodies[a as usize], &bodies[b as usize]);
        Self {
            a,
            b,
            mass_a: body_a.inverse_mass,
            mass_b: body_b.inverse_mass,
            velocity_a: body_a.velocity,
            velocity_b: body_b.velocity,
        }
    }

    /// Relative velocity along the row, m/s or rad/s.
    #[inline]
    fn relative(&self, row: &Row) -> f32 {
        row.axis.dot(self.velocity_b.linear - self.velocity_a.linear) + row.angular_b.dot(self.velocity_b.angular)
            - row.angular_a.dot(self.velocity_a.angular)
    }

    #[inline]
    fn push(&mut self, row: &Row, impulse: f32) {
        self.velocity_a.linear -= impulse * self.mass_a * row.axis;
        self.velocity_a.angular -= impulse * row.turn_a;
        self.velocity_b.linear += impulse * self.mass_b * row.axis;
        self.velocity_b.angular += impulse * row.turn_b;
    }

    #[inline]
    fn store(self, bodies: &mut [Moving]) {
        bodies[self.a as usize].velocity = self.velocity_a;
        bodies[self.b as usize].velocity = self.velocity_b;
    }
}
