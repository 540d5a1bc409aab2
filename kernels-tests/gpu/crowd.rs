//! Bodies of all kinds of hulls, close to each other.

use super::fixture::{noise, noisy_poses};
use crate::common::hulls::{cuboid, prism, shifted};
use glam::{Quat, Vec3};
use rest3d_gpu::world::{BodyDef, Pose, STATIC, Velocity, World};

fn points(seed: u32, count: usize) -> impl Iterator<Item = Vec3> {
    noise(seed, 3 * count).chunks_exact(3).map(Vec3::from_slice).collect::<Vec<_>>().into_iter()
}

/// Eight bodies of up to three hulls, from boxes to hulls of 64 vertices; the first is fixed, one has no hull.
pub fn crowd() -> World {
    let kinds = [
        cuboid(Vec3::new(0.2, 0.1, 0.15)),
        prism(0.15, 0.1, 5),
        points(40, 64).map(|p| 0.15 * p.normalize()).collect(),
        points(41, 20).map(|p| 0.1 * p).collect(),
        cuboid(Vec3::new(0.2, 0.0005, 0.1)),
        prism(0.15, 0.1, 30),
    ];
    let starts = noisy_poses(42, 8);
    let defs: Vec<BodyDef> = (0..8_usize)
        .map(|i| BodyDef {
            parts: (0..[2, 1, 3, 0, 1, 2, 1, 3][i])
                .map(|k| shifted(&kinds[(i + k) % kinds.len()], Vec3::X * 0.2 * k as f32))
                .collect(),
            mass: 1.0,
            inertia: Vec3::ONE,
            unit: if i == 0 { STATIC } else { i as u32 - 1 },
            start: starts[i],
            reference: starts[i],
        })
        .collect();
    World::new(&defs, &[1, 2, 3, 4, 5, 6, 7])
}

/// Poses at which bodies are near, touch or overlap; every fourth candidate's are upright. `step` moves them by a
/// millimetre and a milliradian or so.
pub fn scattered(world: &World, candidates: u32, step: u32) -> Vec<Pose> {
    let bodies = world.bodies.len();
    let count = candidates as usize * bodies;
    let (places, moves) = (noisy_poses(43, count), noisy_poses(44, count));
    let small = 1e-3 * step as f32;
    (places.iter().zip(&moves).enumerate())
        .map(|(i, (at, by))| {
            let turn = if (i / bodies) % 4 == 3 { Quat::IDENTITY } else { at.rotation };
            let nudge = Quat::from_scaled_axis(small * by.translation);
            Pose::new((nudge * turn).normalize(), 0.3 * at.translation + small * by.translation)
        })
        .collect()
}

/// m/s and rad/s, up to what lengthens the margins most.
pub fn speeds(world: &World, candidates: u32) -> Vec<Velocity> {
    let rows = noise(45, 6 * candidates as usize * world.bodies.len());
    rows.chunks_exact(6).map(|v| Velocity::new(Vec3::from_slice(v), Vec3::from_slice(&v[3..]))).collect()
}
