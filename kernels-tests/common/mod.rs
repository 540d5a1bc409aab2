//! Scenario builders shared by the physics tests: simple bodies with exact mass properties.

#![allow(dead_code, clippy::unwrap_used)]

use glam::{Quat, Vec3};
use rest3d_gpu::world::Backend;
use rest3d_gpu::world::{BodyDef, Flow, Pose, STATIC, SimSettings, Velocity, World};

/// Corners of a box with these half extents.
pub fn cuboid(half: Vec3) -> Vec<Vec3> {
    (0..8)
        .map(|i| {
            half * Vec3::new((i & 1) as f32 * 2.0 - 1.0, (i >> 1 & 1) as f32 * 2.0 - 1.0, (i >> 2) as f32 * 2.0 - 1.0)
        })
        .collect()
}

/// A prism with `sides` corners in the xz plane.
pub fn prism(radius: f32, half_height: f32, sides: usize) -> Vec<Vec3> {
    (0..sides)
        .flat_map(|i| {
            let angle = std::f32::consts::TAU * (i as f32 + 0.5) / sides as f32;
            [-1.0, 1.0].map(|s| Vec3::new(radius * angle.cos(), s * half_height, radius * angle.sin()))
        })
        .collect()
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
}

/// The states after every step of one candidate, from the world's start.
pub fn run(backend: &dyn Backend, world: &World, settings: &SimSettings) -> Vec<(Vec<Pose>, Vec<Velocity>)> {
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
