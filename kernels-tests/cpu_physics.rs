//! Physics of the CPU backend: the tests that every backend passes, and those that look inside this one.

#![allow(clippy::unwrap_used)]

mod common;
mod physics;

use common::scenario::Scenario;
use glam::{Quat, Vec3};
use physics::{determinism, measured, settings};
use rest3d_gpu::cpu::narrow_phase::Separator;
use rest3d_gpu::cpu::{CpuBackend, Group};

/// The shared bodies, in modules of their own so that names do not clash.
mod cpu {
    crate::physics::physics_suite!(make_tests(rest3d_gpu::cpu::CpuBackend));
}

#[test]
fn contact_impulses_carry_the_weight() {
    let settings = settings(120);
    let mut s = Scenario::default();
    s.cuboid(Vec3::splat(0.1), 3.0, Vec3::Y * 0.1, Quat::IDENTITY);
    let world = s.world();
    let narrow = Separator::new(settings.narrow_phase, &world.hulls);
    let mut group = Group::new(&world, 1);
    group.start(&world.start);
    for _ in 0..settings.steps {
        group.step(&world, &settings, &narrow);
    }
    // The impulses are those of one small step.
    let small = settings.dt / (settings.substeps * settings.position_iterations) as f32;
    let force = group.candidates()[0].contacts().points.iter().map(|p| p.impulse).sum::<f32>() / small;
    measured("contact force of 3 kg at rest, N", force, 3.0 * 9.8);
    assert!((force / (3.0 * 9.8) - 1.0).abs() < 5e-3, "{force} N");
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let hash = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| determinism::batch_hash(&CpuBackend))
    };
    let one = hash(1);
    assert_eq!(one, hash(2));
    assert_eq!(one, hash(7));
}

/// Change the hash only together with a change that is meant to alter the simulation (solver, contacts, narrow phase,
/// their constants, or the order of their sums), never to silence a change that is not. Other processors may multiply
/// and add in one step, so it is checked on one platform only.
#[cfg(all(target_arch = "x86_64", target_os = "linux", target_env = "gnu"))]
#[test]
fn the_states_of_a_batch_are_pinned() {
    assert_eq!(determinism::batch_hash(&CpuBackend), "9e56b7adb2db83603945e2d6cf583930");
}
