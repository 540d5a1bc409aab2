//! Kernels by hand-made numbers.

use crate::fixture::*;
use glam::{Quat, Vec3};
use rest3d_gpu::cpu::elites::{elites, orderable};
use rest3d_gpu::cpu::energy::{Trial, energy, penetration};
use rest3d_gpu::cpu::moments::moments;
use rest3d_gpu::cpu::place::place;
use rest3d_gpu::world::{Energy, EnergyWeights, PenetrationMode, Pose, Status, Velocity};
use std::f32::consts::FRAC_PI_2;

#[test]
fn a_unit_turns_about_its_root_and_takes_its_bodies_along() {
    let world = world();
    let mut poses = world.start.clone();
    let mut delta = [0.0; 12];
    delta[..6].copy_from_slice(&[0.1, 0.2, 0.3, 0.0, FRAC_PI_2, 0.0]);
    place(&world, &delta, &mut poses);
    assert_eq!(poses[0], world.start[0]);
    // A quarter turn about y takes the second body from +x to −z of the root. f32 rounding at coordinates near 1.
    let near = |a: Vec3, b: Vec3| a.distance(b) < 1e-6;
    assert!(near(poses[1].translation, Vec3::new(1.1, 1.2, 0.3)), "{:?}", poses[1]);
    assert!(near(poses[2].translation, Vec3::new(1.1, 1.2, -0.7)), "{:?}", poses[2]);
    assert!(poses[2].rotation.dot(Quat::from_rotation_y(FRAC_PI_2 + 0.2)).abs() > 1.0 - 1e-6);
    assert!(near(poses[3].translation, world.start[3].translation));
}

#[test]
fn no_adjustment_leaves_everything_in_place() {
    let world = world();
    let mut poses = vec![Pose::IDENTITY; 4];
    place(&world, &[0.0; 12], &mut poses);
    for (pose, start) in poses.iter().zip(&world.start) {
        assert!(pose.translation.distance(start.translation) < 1e-6 && pose.rotation.dot(start.rotation) > 1.0 - 1e-6);
    }
}

#[test]
fn energy_by_hand() {
    let world = world();
    let weights = EnergyWeights::default();
    let placed = world.start.clone();
    let mut settled = placed.clone();
    settled[0].translation.y -= 9.0; // static: must not count
    settled[1].translation.y -= 0.1;
    settled[3].rotation *= Quat::from_rotation_x(0.2);
    let mut snapshot = vec![Velocity::default(); 4];
    snapshot[0].linear = Vec3::X * 100.0;
    snapshot[2] = Velocity::new(Vec3::new(0.0, 0.3, 0.4), Vec3::splat(7.0));
    let depths_placed = [0.0, 0.002, 0.5, 0.0009, 0.0];
    let depths_settled = [0.0, 0.0, 0.0, 0.0, 0.0011];
    let trial = Trial {
        placed: &placed,
        settled: &settled,
        snapshot: &snapshot,
        depths_placed: &depths_placed,
        depths_settled: &depths_settled,
        status: Status::default(),
    };
    let found = energy(&world, &weights, &trial);
    // Sums of a few f32 terms below 10.
    let near = |a: f32, b: f32| (a - b).abs() < 1e-5;
    assert!(near(found.stability, 0.1 + 0.2), "{found:?}");
    assert!(near(found.velocity, 0.5), "{found:?}");
    assert_eq!(found.penetration, 3.0);
    let layout = 6.0 * (Vec3::new(0.03, 0.1, 0.02).length() + Vec3::new(0.03, 0.0, 0.02).length()) + 0.2;
    assert!(near(found.layout, layout), "{found:?} {layout}");
    assert!(near(found.total, 0.3 + 0.5 + 0.5 * 3.0 + layout), "{found:?}");

    let failed = energy(&world, &weights, &Trial { status: Status::CONTACTS, ..trial });
    assert_eq!(failed.total, f32::INFINITY);
    let mut broken = settled.clone();
    broken[2].translation.x = f32::NAN;
    assert_eq!(energy(&world, &weights, &Trial { settled: &broken, ..trial }).total, f32::INFINITY);
}

#[test]
fn depth_counts_beyond_touching() {
    let weights = EnergyWeights { penetration_mode: PenetrationMode::Depth, ..Default::default() };
    // (21 mm + 11 mm − 2 · 1 mm) / 20 mm
    let found = penetration(&[0.021, 0.001, 0.0, 0.011], &weights);
    assert!((found - 1.5).abs() < 1e-5, "{found}");
}

fn of_total(total: f32) -> Energy {
    Energy { total, stability: 0.0, velocity: 0.0, penetration: 0.0, layout: 0.0 }
}

#[test]
fn keys_have_the_order_of_energies() {
    let sorted = [f32::NEG_INFINITY, -1.0, -0.0, 0.0, 1e-40, 1.0, f32::MAX, f32::INFINITY, f32::NAN];
    assert!(sorted.windows(2).all(|pair| orderable(pair[0]) < orderable(pair[1])));
}

#[test]
fn elites_are_in_rank_order_with_ties_to_the_lower_index() {
    let energies = [3.0, 1.0, f32::INFINITY, 1.0, 0.5, f32::NAN, 3.0].map(of_total);
    let mut order = [99; 7];
    assert_eq!(elites(&energies, 4, &mut order), 4);
    assert_eq!(order, [4, 1, 3, 0, 6, 2, 5]);
    assert_eq!(elites(&energies, 6, &mut order), 5, "failed candidates are no elites");
}

#[test]
fn moments_by_hand() {
    let deltas = [1.0, 10.0, f32::NAN, f32::NAN, 3.0, 10.0, 5.0, 10.0];
    let (mut mean, mut std) = ([0.0; 2], [0.0; 2]);
    moments(&deltas, &[3, 0, 2], 0.5, &[0.0, 2.0], &mut mean, &mut std);
    assert_eq!(mean, [3.0, 10.0]);
    assert!((std[0] - ((8.0_f32 / 3.0).sqrt() + 0.5)).abs() < 1e-6, "{std:?}");
    assert_eq!(std[1], 2.0, "floor");
    moments(&deltas, &[], 0.5, &[0.0, 2.0], &mut mean, &mut std);
    assert_eq!(mean, [3.0, 10.0]);
}
