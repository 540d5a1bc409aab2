//! Simple bodies with exact mass properties, and what becomes of them.

use super::hulls::{cuboid, shifted};
use glam::{DQuat, DVec3, Quat, Vec3};
use rest3d_gpu::world::{Backend, BodyDef, Flow, Pose, STATIC, SimSettings, Velocity, World};

/// Poses and velocities of all bodies after a step.
pub type State = (Vec<Pose>, Vec<Velocity>);

/// A number in [0, 1) that is the same for the same arguments.
pub fn any(number: usize, which: usize) -> f32 {
    (((number * 61 + which * 5) as f32 * 12.9898).sin() * 43758.547).rem_euclid(1.0)
}

/// Principal moments of a box.
pub fn box_inertia(mass: f32, half: Vec3) -> Vec3 {
    let s = half * half;
    mass / 3.0 * Vec3::new(s.y + s.z, s.x + s.z, s.x + s.y)
}

/// Builds worlds body by body; every moving body is a unit of its own.
#[derive(Default)]
pub struct Scenario {
    defs: Vec<BodyDef>,
    units: u32,
}

impl Scenario {
    /// A body of any parts.
    pub fn body(&mut self, parts: Vec<Vec<Vec3>>, mass: f32, inertia: Vec3, start: Pose) -> usize {
        self.defs.push(BodyDef { parts, mass, inertia, unit: self.units, start, reference: start });
        self.units += 1;
        self.defs.len() - 1
    }

    /// A solid box.
    pub fn cuboid(&mut self, half: Vec3, mass: f32, at: Vec3, rotation: Quat) -> usize {
        self.body(vec![cuboid(half)], mass, box_inertia(mass, half), Pose::new(rotation, at))
    }

    /// One solid of boxes, each (half extents, centre), set up with their common frame's origin at `at`. The boxes must
    /// lie symmetrically enough that the axes are principal ones.
    pub fn furniture(&mut self, boxes: &[(Vec3, Vec3)], mass: f32, at: Vec3) -> usize {
        let volume = |half: Vec3| half.element_product();
        let total: f32 = boxes.iter().map(|&(half, _)| volume(half)).sum();
        let center = boxes.iter().map(|&(half, at)| volume(half) * at).sum::<Vec3>() / total;
        let mut inertia = Vec3::ZERO;
        for &(half, at) in boxes {
            let (m, d) = (mass * volume(half) / total, at - center);
            inertia += box_inertia(m, half) + m * (d.length_squared() - d * d);
        }
        let parts = boxes.iter().map(|&(half, at)| shifted(&cuboid(half), at - center)).collect();
        self.body(parts, mass, inertia, Pose::new(Quat::IDENTITY, at + center))
    }

    /// A table of 1.2 m by 0.8 m, 0.74 m high, on four legs of 4 cm.
    pub fn table(&mut self, mass: f32) {
        let leg = |x: f32, z: f32| (Vec3::new(0.02, 0.35, 0.02), Vec3::new(x, 0.35, z));
        let top = (Vec3::new(0.6, 0.02, 0.4), Vec3::Y * 0.72);
        let boxes = [top, leg(-0.55, -0.35), leg(0.55, -0.35), leg(-0.55, 0.35), leg(0.55, 0.35)];
        self.furniture(&boxes, mass, Vec3::ZERO);
    }

    /// Something that never moves.
    pub fn fixed(&mut self, parts: Vec<Vec<Vec3>>, at: Vec3, rotation: Quat) -> usize {
        let start = Pose::new(rotation, at);
        self.defs.push(BodyDef { parts, mass: 1.0, inertia: Vec3::ONE, unit: STATIC, start, reference: start });
        self.defs.len() - 1
    }

    /// The tables.
    pub fn world(&self) -> World {
        let roots: Vec<u32> = (0..self.defs.len() as u32).filter(|&i| self.defs[i as usize].unit != STATIC).collect();
        World::new(&self.defs, &roots)
    }

    fn moving(&self) -> impl Iterator<Item = (usize, &BodyDef)> {
        self.defs.iter().enumerate().filter(|(_, def)| def.unit != STATIC)
    }

    /// Total mass of what moves, kg.
    pub fn mass(&self) -> f64 {
        self.moving().map(|(_, def)| f64::from(def.mass)).sum()
    }

    /// Common centre of mass of what moves.
    pub fn center(&self, (poses, _): &State) -> DVec3 {
        let sum: DVec3 = self.moving().map(|(i, def)| f64::from(def.mass) * poses[i].translation.as_dvec3()).sum();
        sum / self.mass()
    }

    /// Momentum of a body, N s.
    pub fn momentum_of(&self, body: usize, (_, velocities): &State) -> DVec3 {
        f64::from(self.defs[body].mass) * velocities[body].linear.as_dvec3()
    }

    /// Momentum of all bodies, N s.
    pub fn momentum(&self, state: &State) -> DVec3 {
        self.moving().map(|(i, _)| self.momentum_of(i, state)).sum()
    }

    /// Angular momentum of a body about its centre of mass, N m s.
    pub fn spin_of(&self, body: usize, (poses, velocities): &State) -> DVec3 {
        let rotation: DQuat = poses[body].rotation.as_dquat().normalize();
        let local = rotation.conjugate() * velocities[body].angular.as_dvec3();
        rotation * (self.defs[body].inertia.as_dvec3() * local)
    }

    /// Angular momentum of a body about the common centre of mass, N m s: its spin and its orbit.
    pub fn angular_momentum_of(&self, body: usize, state: &State) -> DVec3 {
        let mass = f64::from(self.defs[body].mass);
        let drift = self.momentum(state) / self.mass();
        let arm = state.0[body].translation.as_dvec3() - self.center(state);
        self.spin_of(body, state) + arm.cross(self.momentum_of(body, state) - mass * drift)
    }

    /// Angular momentum of all bodies about their common centre of mass, N m s.
    pub fn angular_momentum(&self, state: &State) -> DVec3 {
        self.moving().map(|(i, _)| self.angular_momentum_of(i, state)).sum()
    }

    /// Kinetic and potential energy, J; zero at rest with the centres of mass on the ground.
    pub fn energy(&self, state: &State, gravity: f32) -> f64 {
        let (poses, velocities) = state;
        self.moving()
            .map(|(i, def)| {
                let height = f64::from(poses[i].translation.y);
                0.5 * self.momentum_of(i, state).dot(velocities[i].linear.as_dvec3())
                    + 0.5 * self.spin_of(i, state).dot(velocities[i].angular.as_dvec3())
                    - f64::from(def.mass) * f64::from(gravity) * height
            })
            .sum()
    }

    /// Height of the lowest vertex of a body, m.
    pub fn lowest(&self, body: usize, (poses, _): &State) -> f32 {
        self.defs[body].parts.iter().flatten().map(|&v| poses[body].point(v).y).fold(f32::INFINITY, f32::min)
    }
}

/// The states after every step of one candidate, from the world's start.
pub fn run(backend: &dyn Backend, world: &World, settings: &SimSettings) -> Vec<State> {
    let mut states = Vec::new();
    let status = backend
        .simulate(world, settings, &world.start, &mut |_, poses, velocities| {
            states.push((poses.to_vec(), velocities.to_vec()));
            Flow::Continue
        })
        .unwrap();
    assert!(status.iter().all(|s| s.is_usable()), "status {status:?}");
    states
}
