//! Concave compounds hold what is in them.

use super::{both, drift, measured, settings};
use crate::common::hulls::{prism, ring, shifted};
use crate::common::scenario::{Scenario, box_inertia, run};
use glam::{Quat, Vec3};
use rest3d_gpu::world::{Backend, Pose, SimSettings};

/// The centre of every body after the container (body 0) stays, in the container's frame, within `room` at every step.
fn stays_inside(
    backend: &dyn Backend,
    name: &str,
    s: &Scenario,
    settings: &SimSettings,
    room: impl Fn(usize, Vec3) -> bool,
) {
    let states = run(backend, &s.world(), settings);
    for (step, (poses, _)) in states.iter().enumerate() {
        for (body, pose) in poses.iter().enumerate().skip(1) {
            let local = poses[0].inverse_point(pose.translation);
            assert!(room(body, local), "{name}: body {body} has left at step {step}, to {local}");
        }
    }
    let speed = super::peak_speed(&states[states.len() - 1..]);
    measured(&format!("{name}: speed at the end, m/s"), speed, 0);
    assert!(speed < 2e-3, "{name}: {speed} m/s at the end");
}

/// A cone rests on all of the ring at once: more directions than a body pair has patches.
pub fn a_cone_stays_in_its_ring(backend: &dyn Backend) {
    const SIDES: usize = 16;
    const SLOPE: f32 = 0.105;
    const GAP: f32 = 5e-4;
    for settings in both(backend, 300) {
        let radius = |height: f32| 0.1 + SLOPE * height;
        let mut s = Scenario::default();
        let hole = [radius(-0.05), radius(0.05)];
        s.fixed(
            ring([hole[0], hole[0] + 0.03], [hole[1], hole[1] + 0.03], [0.15, 0.25], SIDES),
            Vec3::ZERO,
            Quat::IDENTITY,
        );
        let corner = |i: usize, height: f32| {
            let (sin, cos) = (std::f32::consts::TAU * i as f32 / SIDES as f32).sin_cos();
            Vec3::new(radius(height) * cos, height, radius(height) * sin)
        };
        let cone = (0..SIDES).flat_map(|i| [corner(i, -0.08), corner(i, 0.08)]).collect();
        let start = Pose::new(Quat::IDENTITY, Vec3::Y * (0.2 + GAP / SLOPE));
        let cone = s.body(vec![cone], 1.0, box_inertia(1.0, Vec3::splat(0.09)), start);
        let states = run(backend, &s.world(), &settings);
        let sunk = 0.2 - states.last().unwrap().0[cone].translation.y;
        let speed = super::peak_speed(&states[states.len() - 60..]);
        measured("a cone in a ring has sunk by, m", sunk, 0);
        assert!(sunk < 5e-3, "the cone has sunk by {sunk} m");
        assert!(speed < 5e-3, "the cone moves at {speed} m/s");
    }
}

pub fn a_bowl_holds_its_fruit(backend: &dyn Backend) {
    for settings in both(backend, 300) {
        let mut s = Scenario::default();
        let mut parts = ring([0.05, 0.07], [0.14, 0.15], [-0.04, 0.06], 24);
        parts.push(shifted(&prism(0.06, 0.005, 24), Vec3::Y * -0.035));
        s.body(parts, 0.8, 0.8 * Vec3::new(0.007, 0.012, 0.007), Pose::new(Quat::IDENTITY, Vec3::Y * 0.04));
        for i in 0..4 {
            let (sin, cos) = (1.6 * i as f32).sin_cos();
            let at = Vec3::new(0.05 * cos, 0.1 + 0.03 * i as f32, 0.05 * sin);
            let turn = Quat::from_rotation_x(i as f32) * Quat::from_rotation_z(0.5);
            if i % 2 == 0 {
                s.cuboid(Vec3::splat(0.025), 0.2, at, turn);
            } else {
                let inertia = box_inertia(0.2, Vec3::splat(0.03));
                s.body(vec![prism(0.03, 0.03, 8)], 0.2, inertia, Pose::new(turn, at));
            }
        }
        stays_inside(backend, "bowl", &s, &settings, |_, p| p.y > -0.03 && Vec3::new(p.x, 0.0, p.z).length() < 0.14);
    }
}

pub fn a_shelf_holds_its_books(backend: &dyn Backend) {
    let board = |y: f32| (Vec3::new(0.4, 0.01, 0.15), Vec3::Y * y);
    let side = |x: f32| (Vec3::new(0.01, 0.5, 0.15), Vec3::new(x, 0.5, 0.0));
    let back = (Vec3::new(0.42, 0.5, 0.005), Vec3::new(0.0, 0.5, -0.155));
    let boards = [0.01, 0.34, 0.67];
    for settings in both(backend, 300) {
        let mut s = Scenario::default();
        let mut boxes = vec![side(-0.41), side(0.41), back, board(0.99)];
        boxes.extend(boards.map(board));
        let shelf = s.furniture(&boxes, 20.0, Vec3::ZERO);
        let center = s.world().start[shelf].translation;
        for y in boards {
            for i in 0..5 {
                // The last ones lean on their neighbours.
                let lean = if i == 4 { 0.15 } else { 0.0 };
                let half = Vec3::new(0.02, 0.12, 0.09);
                let x = -0.3 + 0.045 * i as f32 + lean * 0.14;
                let at = Vec3::new(x, y + 0.01 + half.y * lean.cos() + half.x * lean.sin(), -0.04);
                s.cuboid(half, 0.6, at, Quat::from_rotation_z(lean));
            }
        }
        stays_inside(backend, "shelf", &s, &settings, |body, p| {
            let floor = boards[(body - 1) / 5] - center.y;
            p.x.abs() < 0.4 && p.z.abs() < 0.15 && p.y > floor && p.y < floor + 0.33
        });
    }
}

pub fn a_drawer_holds_its_things(backend: &dyn Backend) {
    let boxes = [
        (Vec3::new(0.25, 0.005, 0.2), Vec3::Y * 0.005),
        (Vec3::new(0.005, 0.06, 0.19), Vec3::new(-0.245, 0.07, 0.0)),
        (Vec3::new(0.005, 0.06, 0.19), Vec3::new(0.245, 0.07, 0.0)),
        (Vec3::new(0.25, 0.06, 0.005), Vec3::new(0.0, 0.07, -0.195)),
        (Vec3::new(0.25, 0.06, 0.005), Vec3::new(0.0, 0.07, 0.195)),
    ];
    for settings in both(backend, 300) {
        let mut s = Scenario::default();
        let drawer = s.furniture(&boxes, 2.0, Vec3::ZERO);
        let center = s.world().start[drawer].translation;
        // Dropped in, sunk 4 mm into the bottom, sunk 4 mm into a wall.
        s.cuboid(Vec3::new(0.05, 0.02, 0.07), 0.3, Vec3::new(0.0, 0.15, 0.0), Quat::from_rotation_z(0.6));
        s.cuboid(Vec3::new(0.03, 0.01, 0.05), 0.2, Vec3::new(0.12, 0.016, 0.08), Quat::from_rotation_y(0.4));
        s.cuboid(Vec3::new(0.03, 0.03, 0.03), 0.3, Vec3::new(-0.214, 0.041, -0.05), Quat::IDENTITY);
        s.cuboid(Vec3::new(0.01, 0.1, 0.01), 0.1, Vec3::new(-0.1, 0.115, 0.1), Quat::from_rotation_x(0.1));
        stays_inside(backend, "drawer", &s, &settings, |_, p| {
            p.x.abs() < 0.25 && p.z.abs() < 0.2 && p.y > 0.0 - center.y && p.y < 0.25
        });
    }
}

/// A cube between the boards of a shelf that stands on the ground, with some room above it, or on a tray in there: each
/// lies on another, round and round, but nothing bears what the ground bears.
pub fn snug_shelf(room: f32, masses: [f32; 2], on_tray: bool) -> Scenario {
    let tray = if on_tray { 0.02 } else { 0.0 };
    let height = 0.24 + tray + room;
    let board = Vec3::new(0.4, 0.01, 0.15);
    let side = Vec3::new(0.01, 0.5 * height, 0.15);
    let boxes = [
        (board, Vec3::Y * 0.01),
        (board, Vec3::Y * (height - 0.01)),
        (side, Vec3::new(-0.41, side.y, 0.0)),
        (side, Vec3::new(0.41, side.y, 0.0)),
    ];
    let mut s = Scenario::default();
    s.furniture(&boxes, masses[0], Vec3::ZERO);
    s.cuboid(Vec3::splat(0.1), masses[1], Vec3::Y * (0.12 + tray), Quat::IDENTITY);
    if on_tray {
        s.cuboid(Vec3::new(0.3, 0.01, 0.12), 0.3, Vec3::Y * 0.03, Quat::IDENTITY);
    }
    s
}

pub fn what_is_snug_in_a_shelf_lies_still(backend: &dyn Backend) {
    for (masses, on_tray) in [([20.0, 0.5], false), ([60.0, 0.2], false), ([5.0, 5.0], false), ([20.0, 0.5], true)] {
        for room in [0.0, 1e-4, 3e-4, 9e-4, 3e-3] {
            let found = drift(backend, &snug_shelf(room, masses, on_tray), &settings(120), 60);
            let what = format!("drift in a shelf of {masses:?} kg with {room} m of room, on a tray: {on_tray}, m");
            measured(&what, found.moved, 0);
            assert!(found.moved < 2e-4 && found.turned < 1e-3 && found.speed < 1e-3, "{what}: {found:?}");
        }
    }
}
