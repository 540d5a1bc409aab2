//! Physics invariants, written against the `Backend` trait.

#![allow(clippy::unwrap_used)]

mod common;

use common::{Scenario, box_inertia, cuboid, prism, run};
use glam::{Quat, Vec3};
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::world::{NarrowPhase, Pose, SimSettings, angle_between};

fn settings(steps: u32) -> SimSettings {
    SimSettings { steps, ..Default::default() }
}

/// Both hull–hull algorithms must pass.
fn both(steps: u32) -> [SimSettings; 2] {
    [NarrowPhase::Twin, NarrowPhase::Reference].map(|narrow_phase| SimSettings { narrow_phase, ..settings(steps) })
}

fn undamped(settings: SimSettings) -> SimSettings {
    SimSettings { linear_damping: 0.0, angular_damping: 0.0, ..settings }
}

/// Largest distance and angle of any body from its start at the end, and the fastest speed after step `from`.
fn drift(scenario: &Scenario, settings: &SimSettings, from: usize) -> (f32, f32, f32) {
    let world = scenario.world();
    let states = run(&CpuBackend, &world, settings);
    let (poses, _) = states.last().unwrap();
    let moved = poses.iter().zip(&world.start).map(|(p, q)| p.translation.distance(q.translation)).fold(0.0, f32::max);
    let turned = poses.iter().zip(&world.start).map(|(p, q)| angle_between(p.rotation, q.rotation)).fold(0.0, f32::max);
    let speed = states[from..].iter().flat_map(|(_, v)| v).map(|v| v.linear.length()).fold(0.0, f32::max);
    (moved, turned, speed)
}

#[test]
fn free_fall_follows_the_scheme() {
    let settings = settings(60);
    let mut s = Scenario::default();
    s.cuboid(Vec3::splat(0.1), 1.0, Vec3::new(0.0, 20.0, 0.0), Quat::IDENTITY);
    let states = run(&CpuBackend, &s.world(), &settings);
    let small = (settings.substeps * settings.position_iterations) as usize;
    let h = f64::from(settings.dt) / small as f64;
    let (mut y, mut v) = (20.0f64, 0.0f64);
    for _ in 0..60 * small {
        v = (v + h * f64::from(settings.gravity)) / (1.0 + h * f64::from(settings.linear_damping));
        y += h * v;
    }
    let fallen = 20.0 - f64::from(states[59].0[0].translation.y);
    assert!((fallen - (20.0 - y)).abs() < 1e-3 * (20.0 - y), "fell {fallen} m, the scheme says {}", 20.0 - y);
    // The continuous solution with damping c: v' = g - c v.
    let c = f64::from(settings.linear_damping);
    let exact = 9.8 / c - 9.8 / (c * c) * (1.0 - (-c).exp());
    assert!((fallen - exact).abs() < 5e-3 * exact, "fell {fallen} m, exact {exact}");
}

#[test]
fn angular_momentum_of_a_free_body_stays() {
    // An uneven plank falls onto a peg beside its centre, is set spinning, and then tumbles freely.
    let half = Vec3::new(0.1, 0.02, 0.4);
    let inertia = box_inertia(1.0, half);
    let mut s = Scenario::default();
    s.fixed(vec![cuboid(Vec3::splat(0.02))], Vec3::new(0.05, 50.0, 0.3), Quat::IDENTITY);
    s.cuboid(half, 1.0, Vec3::new(0.0, 50.3, 0.0), Quat::from_rotation_x(0.1));
    let states = run(&CpuBackend, &s.world(), &undamped(settings(120)));
    let momentum = |step: usize| {
        let (pose, spin) = (states[step].0[1], states[step].1[1].angular);
        pose.rotation * (inertia * (pose.rotation.conjugate() * spin))
    };
    let energy = |step: usize| 0.5 * momentum(step).dot(states[step].1[1].angular);
    assert!(states[60].0[1].translation.y < 49.0, "the plank must have left the peg");
    let first = momentum(60);
    assert!(first.length() > 1e-2, "the hit must spin the plank, momentum {first}");
    for step in 61..120 {
        let change = momentum(step).distance(first) / first.length();
        assert!(change < 1e-4, "step {step}: momentum changed by {change}");
        assert!(energy(step) < 1.001 * energy(60), "step {step}: spin energy grows");
    }
}

fn on_incline(degrees: f32, settings: &SimSettings) -> f32 {
    let slope = Quat::from_rotation_z(degrees.to_radians());
    let mut s = Scenario::default();
    s.fixed(vec![cuboid(Vec3::new(20.0, 0.5, 2.0))], slope * Vec3::new(0.0, -0.5, 0.0) + Vec3::Y * 30.0, slope);
    let half = Vec3::new(0.2, 0.05, 0.2);
    s.cuboid(half, 1.0, slope * Vec3::new(0.0, 0.05, 0.0) + Vec3::Y * 30.0, slope);
    let world = s.world();
    let states = run(&CpuBackend, &world, settings);
    states.last().unwrap().0[1].translation.distance(world.start[1].translation)
}

#[test]
fn friction_cone() {
    for settings in both(60).map(undamped) {
        let held = on_incline(44.0, &settings);
        assert!(held < 1e-3, "44° must hold, slid {held} m");
        let angle = 46f32.to_radians();
        let exact = 0.5 * 9.8 * (angle.sin() - angle.cos());
        let slid = on_incline(46.0, &settings);
        assert!((slid - exact).abs() < 0.1 * exact, "46°: slid {slid} m, expected {exact}");
        let angle = 60f32.to_radians();
        let exact = 0.5 * 9.8 * (angle.sin() - angle.cos());
        let slid = on_incline(60.0, &settings);
        assert!((slid - exact).abs() < 0.02 * exact, "60°: slid {slid} m, expected {exact}");
    }
}

#[test]
fn overhang_tips_when_its_centre_passes_the_edge() {
    for settings in both(120) {
        for (past, tips) in [(-1e-3, false), (1e-3, true)] {
            let mut s = Scenario::default();
            s.fixed(vec![cuboid(Vec3::new(0.5, 0.5, 0.5))], Vec3::new(0.0, 0.5, 0.0), Quat::IDENTITY);
            s.cuboid(Vec3::new(0.3, 0.05, 0.1), 1.0, Vec3::new(0.5 + past, 1.05, 0.0), Quat::IDENTITY);
            let (_, turned, _) = drift(&s, &SimSettings { steps: 240, ..settings.clone() }, 0);
            assert_eq!(turned > 0.05, tips, "centre {past} m past the edge, turned {turned} rad");
        }
    }
}

#[test]
fn ten_boxes_stand() {
    // Near touching, the axes of GJK and EPA are too noisy for the reference to hold so tall a stack still.
    for settings in [settings(600)] {
        let mut s = Scenario::default();
        for i in 0..10 {
            s.cuboid(Vec3::splat(0.1), 1.0, Vec3::new(0.0, 0.1 + 0.2 * i as f32, 0.0), Quat::IDENTITY);
        }
        let (moved, turned, speed) = drift(&s, &settings, 120);
        assert!(
            moved < 1e-3 && turned < 1e-3,
            "{:?} drift {moved} m, {turned} rad, speed {speed}",
            settings.narrow_phase
        );
        assert!(speed < 1e-3, "still moving at {speed} m/s");
    }
}

#[test]
fn ten_octagonal_prisms_stand() {
    // Near touching, the axes of GJK and EPA are too noisy for the reference to hold so tall a stack still.
    for settings in [settings(600)] {
        let mut s = Scenario::default();
        for i in 0..10 {
            let inertia = box_inertia(1.0, Vec3::splat(0.1));
            let at = Pose::new(Quat::IDENTITY, Vec3::new(0.0, 0.1 + 0.2 * i as f32, 0.0));
            s.body(vec![prism(0.1, 0.1, 8)], 1.0, inertia, at);
        }
        let (moved, turned, speed) = drift(&s, &settings, 120);
        assert!(
            moved < 1e-3 && turned < 1e-3,
            "{:?} drift {moved} m, {turned} rad, speed {speed}",
            settings.narrow_phase
        );
        assert!(speed < 1e-3, "still moving at {speed} m/s");
    }
}

#[test]
fn pyramid_stands() {
    for settings in both(300) {
        let mut s = Scenario::default();
        for row in 0..5 {
            for i in 0..5 - row {
                let x = 0.21 * (i as f32 + 0.5 * row as f32);
                s.cuboid(Vec3::splat(0.1), 1.0, Vec3::new(x, 0.1 + 0.2 * row as f32, 0.0), Quat::IDENTITY);
            }
        }
        let (moved, _, speed) = drift(&s, &settings, 120);
        assert!(moved < 1e-3 && speed < 2e-3, "drift {moved} m, speed {speed}");
    }
}

#[test]
fn mass_ratio_of_a_hundred() {
    for settings in both(300) {
        for masses in [[1.0, 100.0], [100.0, 1.0]] {
            let mut s = Scenario::default();
            for (i, mass) in masses.into_iter().enumerate() {
                s.cuboid(Vec3::splat(0.1), mass, Vec3::new(0.0, 0.1 + 0.2 * i as f32, 0.0), Quat::IDENTITY);
            }
            let (moved, _, speed) = drift(&s, &settings, 120);
            assert!(moved < 2e-3 && speed < 2e-3, "{masses:?}: drift {moved} m, speed {speed}");
        }
    }
}

#[test]
fn overlap_is_pushed_apart_gently() {
    for settings in both(60) {
        for (name, shift) in [("5 cm", 0.15), ("90 %", 0.02), ("coincident", 0.0)] {
            let mut s = Scenario::default();
            s.cuboid(Vec3::splat(0.1), 1.0, Vec3::new(0.0, 0.1, 0.0), Quat::IDENTITY);
            s.cuboid(Vec3::splat(0.1), 1.0, Vec3::new(shift, 0.1, 0.0), Quat::IDENTITY);
            let world = s.world();
            let states = run(&CpuBackend, &world, &settings);
            let speed = states.iter().flat_map(|(_, v)| v).map(|v| v.linear.length()).fold(0.0, f32::max);
            assert!(speed < 5.0, "{name}: {speed} m/s");
            let (poses, _) = states.last().unwrap();
            let apart = (poses[1].translation - poses[0].translation).abs().max_element();
            assert!(apart > 0.198, "{name}: still {apart} m apart after 60 steps");
        }
    }
}

#[test]
fn touching_hulls_are_not_missed() {
    for settings in both(60) {
        for gap in [-1e-6, 0.0, 1e-6] {
            let mut s = Scenario::default();
            s.cuboid(Vec3::splat(0.1), 1.0, Vec3::new(0.0, 0.1, 0.0), Quat::IDENTITY);
            s.cuboid(Vec3::splat(0.1), 1.0, Vec3::new(0.0, 0.3 + gap, 0.0), Quat::IDENTITY);
            let (moved, _, _) = drift(&s, &settings, 0);
            assert!(moved < 5e-4, "gap {gap}: moved {moved} m");
        }
    }
}

#[test]
fn table_on_thin_legs_bears_a_load() {
    for settings in both(120) {
        let mut s = Scenario::default();
        let leg = |x: f32, z: f32| {
            cuboid(Vec3::new(0.02, 0.35, 0.02)).into_iter().map(|v| v + Vec3::new(x, -0.37, z)).collect::<Vec<_>>()
        };
        let parts = vec![
            cuboid(Vec3::new(0.6, 0.02, 0.4)),
            leg(-0.55, -0.35),
            leg(0.55, -0.35),
            leg(-0.55, 0.35),
            leg(0.55, 0.35),
        ];
        s.body(parts, 10.0, box_inertia(10.0, Vec3::new(0.6, 0.2, 0.4)), Pose::new(Quat::IDENTITY, Vec3::Y * 0.72));
        for (x, z) in [(-0.3, -0.2), (0.3, -0.2), (-0.3, 0.2), (0.3, 0.2)] {
            s.cuboid(Vec3::splat(0.1), 20.0, Vec3::new(x, 0.84, z), Quat::IDENTITY);
        }
        let (moved, _, speed) = drift(&s, &settings, 30);
        assert!(moved < 1e-3 && speed < 0.02, "drift {moved} m, speed {speed}");
    }
}
