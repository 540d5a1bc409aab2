//! A world of boxes, and what stands for its simulation.

use crate::common::hulls::cuboid;
use glam::{Quat, Vec3};
use rest3d_gpu::cpu::search::{GoesOn, Record, Rollout};
use rest3d_gpu::world::{BodyDef, CemSettings, Pose, STATIC, SearchSettings, Status, Stream, Velocity, World};

pub const STREAM: Stream = Stream { seed: 5, stage: 2 };

pub fn def(unit: u32, start: Pose, reference: Pose) -> BodyDef {
    let parts = vec![cuboid(Vec3::splat(0.1))];
    BodyDef { parts, mass: 1.0, inertia: Vec3::splat(0.01), unit, start, reference }
}

/// A static body, a unit of two bodies, a unit of one.
pub fn world() -> World {
    let at = |x: f32| Pose::new(Quat::from_rotation_y(0.1 * x), Vec3::new(x, 1.0, 0.0));
    let wanted = |x: f32| Pose::new(Quat::from_rotation_y(0.1 * x), Vec3::new(x + 0.03, 1.0, -0.02));
    World::new(
        &[
            def(STATIC, at(0.0), at(0.0)),
            def(0, at(1.0), wanted(1.0)),
            def(0, at(2.0), wanted(2.0)),
            def(1, at(5.0), at(5.0)),
        ],
        &[1, 3],
    )
}

pub fn settings(candidates: u32) -> SearchSettings {
    let cem = CemSettings { candidates, elite_fraction: 0.1, ..Default::default() };
    SearchSettings { cem, ..Default::default() }
}

/// Things stay where they are placed; candidates with a first body left of `fail_below` fail.
pub struct Still {
    pub fail_below: f32,
}

impl Rollout for Still {
    /// Counts its own rollouts, so that a search that leaks scratch into results can be caught.
    type Scratch = u32;

    /// Some, so that every population has a smaller run at its end.
    fn at_once(&self) -> usize {
        3
    }

    fn scratch(&self) -> u32 {
        0
    }

    fn run(&self, scratch: &mut u32, placed: &[Pose], _: u32, records: &mut [Record], _: &GoesOn<'_>) {
        let bodies = placed.len() / records.len();
        for (record, placed) in records.iter_mut().zip(placed.chunks_exact(bodies)) {
            *scratch += 1;
            record.settled.copy_from_slice(placed);
            record.snapshot.fill(Velocity::default());
            record.depths_placed.fill(0.0);
            record.depths_settled.fill(0.0);
            let fails = placed[1].translation.x < self.fail_below;
            record.status = if fails { Status::NOT_FINITE } else { Status::default() };
        }
    }
}

pub const NEVER: Still = Still { fail_below: f32::NEG_INFINITY };
pub const ALWAYS: Still = Still { fail_below: f32::INFINITY };
