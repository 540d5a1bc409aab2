//! Starts that no world has: bodies inside one another. They must come apart gently, completely and in time.

use super::{both, drift, measured, settings};
use crate::common::hulls::cuboid;
use crate::common::scenario::{Scenario, State, any, run};
use glam::{Quat, Vec3};
use rest3d_gpu::cpu::Workspace;
use rest3d_gpu::cpu::narrow_phase::Separator;
use rest3d_gpu::world::constants::{LINEAR_SLOP, TOUCHING_DEPTH};
use rest3d_gpu::world::{Backend, NarrowPhase, SimSettings, World};

/// Deepest overlap of any two bodies, m.
fn overlap(world: &World, state: &State) -> f32 {
    let narrow = Separator::new(NarrowPhase::Reference, &world.hulls);
    let mut ruler = Workspace::new(world);
    ruler.start(&state.0);
    let mut depths = vec![0.0; world.pairs.len()];
    ruler.measure_depths(world, &narrow, &mut depths);
    depths.into_iter().fold(0.0, f32::max)
}

/// Runs the steps; nothing may be or get on faster than the push-out and gravity make it, sink into the ground, or
/// overlap at the end.
fn comes_apart(backend: &dyn Backend, name: &str, s: &Scenario, settings: &SimSettings) -> Vec<State> {
    let world = s.world();
    let states = run(backend, &world, settings);
    let mut fastest = 0.0f32;
    for (step, state) in states.iter().enumerate() {
        let limit = settings.max_push_out - settings.gravity * settings.dt * (step + 1) as f32;
        for (body, velocity) in state.1.iter().enumerate() {
            // Push-out moves bodies without leaving them a velocity, so the way counts too.
            let before = if step == 0 { &world.start } else { &states[step - 1].0 };
            let way = state.0[body].translation.distance(before[body].translation);
            let speed = velocity.linear.length().max(way / settings.dt);
            fastest = fastest.max(speed);
            assert!(speed <= limit, "{name}: body {body} has {speed} m/s after step {step}");
        }
    }
    let last = &states[states.len() - 1];
    for body in 0..world.bodies.len() {
        let lowest = s.lowest(body, last);
        assert!(lowest > -2.0 * TOUCHING_DEPTH, "{name}: body {body} ends {lowest} m below the ground");
    }
    let deep = overlap(&world, last);
    measured(&format!("{name}: fastest speed, m/s"), fastest, "< 5");
    measured(&format!("{name}: overlap left after {} steps, m", states.len()), deep, "< 0.001");
    assert!(deep < TOUCHING_DEPTH, "{name}: {deep} m overlap after {} steps", states.len());
    states
}

pub fn overlap_is_pushed_apart_gently(backend: &dyn Backend) {
    for settings in both(backend, 60) {
        for (name, shift) in [("5 cm", 0.15), ("90 %", 0.02), ("coincident", 0.0)] {
            let mut s = Scenario::default();
            s.cuboid(Vec3::splat(0.1), 1.0, Vec3::new(0.0, 0.1, 0.0), Quat::IDENTITY);
            s.cuboid(Vec3::splat(0.1), 1.0, Vec3::new(shift, 0.1, 0.0), Quat::IDENTITY);
            let states = comes_apart(backend, name, &s, &settings);
            let (poses, _) = &states[59];
            let apart = (poses[1].translation - poses[0].translation).abs().max_element();
            assert!(apart > 0.198, "{name}: still {apart} m apart after 60 steps");
        }
    }
}

/// Each pushes all others at once.
pub fn five_in_one_place_come_apart(backend: &dyn Backend) {
    for settings in both(backend, 60) {
        let mut s = Scenario::default();
        for i in 0..5 {
            let beside = |which: usize| 0.002 * (any(i, which) - 0.5);
            let at = Vec3::new(beside(0), 0.1 + 0.002 * any(i, 1), beside(2));
            s.cuboid(Vec3::splat(0.1), 1.0, at, Quat::from_rotation_y(beside(3)));
        }
        let states = comes_apart(backend, "five in one place", &s, &settings);
        // At rest bodies overlap by half a slop at most; the spring alone, without the push for deep overlap, leaves
        // twice this.
        let left = overlap(&s.world(), &states[59]);
        assert!(left < 2.0 * LINEAR_SLOP, "{left} m overlap: they have not come to rest");
    }
}

pub fn what_is_swallowed_comes_out(backend: &dyn Backend) {
    for settings in both(backend, 60) {
        for (name, at) in [("off the centre", Vec3::new(0.03, 0.22, 0.01)), ("at the centre", Vec3::Y * 0.2)] {
            for movable in [false, true] {
                let mut s = Scenario::default();
                let half = Vec3::splat(0.2);
                if movable {
                    s.cuboid(half, 10.0, Vec3::Y * 0.2, Quat::IDENTITY);
                } else {
                    s.fixed(vec![cuboid(half)], Vec3::Y * 0.2, Quat::IDENTITY);
                }
                s.cuboid(Vec3::splat(0.05), 0.5, at, Quat::from_rotation_y(0.3));
                let name = format!("swallowed {name}, {}", if movable { "movable" } else { "fixed" });
                comes_apart(backend, &name, &s, &settings);
            }
        }
    }
}

/// Near the ground it bars the nearest way out, which only the search of all axes can mind.
pub fn what_is_swallowed_anywhere_comes_out(backend: &dyn Backend) {
    for i in 0..24 {
        let movable = i % 2 == 0;
        let mut s = Scenario::default();
        let half = Vec3::splat(0.1) + 0.3 * Vec3::new(any(i, 0), any(i, 1), any(i, 2));
        // Boxes, books and cards.
        let inner = (Vec3::splat(0.03) + 0.06 * Vec3::new(any(i, 3), any(i, 4), any(i, 5))).min(0.7 * half);
        let inner = if i % 3 == 0 { inner } else { inner.with_y(0.005 + 0.02 * any(i, 11)) };
        let turn = Quat::from_rotation_y(1.5 * any(i, 6));
        if movable {
            s.cuboid(half, 10.0, Vec3::Y * half.y, turn);
        } else {
            s.fixed(vec![cuboid(half)], Vec3::Y * half.y, turn);
        }
        let free = half - inner;
        // Half of them stand on the ground.
        let height = inner.y + free.y * (2.0 * any(i, 7) - 1.0).max(0.0);
        let at = Vec3::new(free.x * (2.0 * any(i, 8) - 1.0), height, free.z * (2.0 * any(i, 9) - 1.0));
        s.cuboid(inner, 0.5, turn * at, turn * Quat::from_rotation_y(0.5 * any(i, 10)));
        let name = format!("swallowed anywhere, {i}, {}", if movable { "movable" } else { "fixed" });
        comes_apart(backend, &name, &s, &settings(60));
    }
}

/// It is wider than the wall is thick, and deeper in it than it is high.
pub fn a_book_in_a_wall_comes_out(backend: &dyn Backend) {
    for depth in [0.03, 0.05, 0.08] {
        let mut s = Scenario::default();
        s.fixed(vec![cuboid(Vec3::new(0.05, 1.0, 1.5))], Vec3::Y, Quat::IDENTITY);
        s.cuboid(Vec3::new(0.125, 0.01, 0.175), 0.5, Vec3::new(0.175 - depth, 0.01, 0.0), Quat::IDENTITY);
        comes_apart(backend, &format!("a book {depth} m in a wall"), &s, &settings(60));
    }
}

/// What does not quite fit under something fixed is neither thrown out nor pushed through it.
pub fn what_is_squeezed_to_the_ground_stays(backend: &dyn Backend) {
    let slats = |half_width: f32, half_height: f32| -> Vec<Vec<Vec3>> {
        let at = |k: i32| Vec3::X * 0.13 * k as f32;
        let slat = cuboid(Vec3::new(half_width, half_height, 0.4));
        (-5..=5).map(|k| slat.iter().map(|v| *v + at(k)).collect()).collect()
    };
    for (name, fixed, bottom, half) in [
        ("a crate under slats", slats(0.04, 0.01), 0.194, Vec3::new(0.18, 0.1, 0.15)),
        ("a crate under a board", vec![cuboid(Vec3::new(0.5, 0.006, 0.4))], 0.192, Vec3::splat(0.1)),
        ("a rug under legs", slats(0.03, 0.3), 0.004, Vec3::new(0.8, 0.004, 0.5)),
    ] {
        let mut s = Scenario::default();
        let half_height = fixed[0].iter().map(|v| v.y).fold(0.0, f32::max);
        s.fixed(fixed, Vec3::Y * (bottom + half_height), Quat::IDENTITY);
        s.cuboid(half, 2.0, Vec3::new(0.013, half.y, 0.0), Quat::IDENTITY);
        let states = run(backend, &s.world(), &settings(120));
        let way = states[119].0[1].translation - Vec3::new(0.013, half.y, 0.0);
        measured(&format!("{name}: way in 2 s, m"), way, "0");
        assert!(way.with_y(0.0).length() < 1e-3 && way.y.abs() < 0.01, "{name}: {way}");
    }
}

/// Chairs in one another push for seconds and cannot part; when one slips, they must not fly apart.
pub fn what_is_jammed_stays_calm(backend: &dyn Backend) {
    let leg = |x: f32, z: f32| (Vec3::new(0.02, 0.21, 0.02), Vec3::new(x, 0.21, z));
    let seat = (Vec3::new(0.21, 0.015, 0.21), Vec3::Y * 0.435);
    let rest = (Vec3::new(0.21, 0.225, 0.015), Vec3::new(0.0, 0.675, -0.195));
    let chair = [seat, rest, leg(-0.17, -0.17), leg(0.17, -0.17), leg(-0.17, 0.17), leg(0.17, 0.17)];
    for (depth, chairs) in [(0.002, 3), (0.004, 3), (0.05, 2), (0.1, 2)] {
        let mut s = Scenario::default();
        for at in &[Vec3::ZERO, Vec3::new(0.42 - depth, 0.0, 0.07), Vec3::new(0.2, 0.0, 0.42 - depth)][..chairs] {
            s.furniture(&chair, 5.0, *at);
        }
        let found = drift(backend, &s, &settings(480), 0);
        measured(&format!("{chairs} chairs {depth} m in one another, fastest speed, m/s"), found.speed, "< 1");
        assert!(found.speed < 1.0, "{chairs} chairs, {depth} m: {found:?}");
    }
}

/// A box on the ground that a fixed slanted board touches too deeply slides out; the ground bars no way that leads
/// along it.
pub fn what_a_slanted_board_touches_is_not_thrown(backend: &dyn Backend) {
    for (degrees, along) in [(5.0_f32, 0.1), (35.0, 0.1), (70.0, 0.2), (87.0, 0.2)] {
        for depth in [0.0005, 0.003] {
            let mut s = Scenario::default();
            let turn = Quat::from_rotation_z(degrees.to_radians());
            // The board's lower face lies on the upper left edge of the box.
            let (length, outward, edge) = (turn * Vec3::X, turn * -Vec3::Y, Vec3::new(-0.075, 0.15, 0.0));
            let board = cuboid(Vec3::new(0.4, 0.01, 0.3));
            s.fixed(vec![board], edge + (depth - 0.01) * outward + along * length, turn);
            s.cuboid(Vec3::splat(0.075), 1.0, Vec3::Y * 0.075, Quat::IDENTITY);
            let (poses, _) = &run(backend, &s.world(), &settings(60))[59];
            let way = poses[1].translation - Vec3::Y * 0.075;
            measured(&format!("{degrees} degrees, {} mm deep: way, m", 1e3 * depth), way, "about the depth");
            assert!(way.length() < 0.015, "{degrees} degrees, {depth} m deep: {way}");
            assert!(poses[1].rotation.w.abs() > 0.999, "{degrees} degrees, {depth} m deep: {}", poses[1].rotation);
        }
    }
}

/// A board leans on one corner of a round top: each of many corners bears.
pub fn every_corner_of_a_round_top_bears(backend: &dyn Backend) {
    let (radius, height, slope) = (0.5_f32, 0.1_f32, 25.0_f32.to_radians());
    for sides in [17_usize, 24, 32] {
        for facing in (0..sides).step_by(3) {
            let at = |k: usize, y: f32| {
                let (sin, cos) = ((k + sides - facing) as f32 / sides as f32 * std::f32::consts::TAU).sin_cos();
                Vec3::new(radius * cos, y, radius * sin)
            };
            let mut s = Scenario::default();
            s.fixed(
                vec![(0..2 * sides).map(|k| at(k / 2, height * (k % 2) as f32)).collect()],
                Vec3::ZERO,
                Quat::IDENTITY,
            );
            let turn = Quat::from_rotation_z(-slope);
            let foot = Vec3::X * (radius + height / slope.tan());
            s.cuboid(Vec3::new(0.2, 0.005, 0.1), 1.0, foot + turn * Vec3::new(-0.2, 0.005, 0.0), turn);
            let world = s.world();
            let states = run(backend, &world, &settings(60));
            let deep = overlap(&world, &states[59]);
            assert!(deep < TOUCHING_DEPTH, "corner {facing} of {sides}: {deep} m deep");
            let way = states[59].0[1].translation.distance(world.start[1].translation);
            assert!(way < 2e-3, "corner {facing} of {sides}: moved by {way} m");
        }
    }
}

pub fn a_plate_inside_a_table_top_comes_out(backend: &dyn Backend) {
    for settings in both(backend, 60) {
        for above in [-0.005, 0.0, 0.005] {
            let mut s = Scenario::default();
            s.table(10.0);
            s.cuboid(Vec3::new(0.1, 0.004, 0.08), 0.5, Vec3::new(0.1, 0.72 + above, 0.05), Quat::IDENTITY);
            let name = format!("plate {above} m above the middle of a table top");
            comes_apart(backend, &name, &s, &settings);
        }
    }
}

pub fn touching_hulls_are_not_missed(backend: &dyn Backend) {
    for settings in both(backend, 60) {
        for gap in [-1e-6, 0.0, 1e-6] {
            let mut s = Scenario::default();
            s.cuboid(Vec3::splat(0.1), 1.0, Vec3::Y * 0.1, Quat::IDENTITY);
            s.cuboid(Vec3::splat(0.1), 1.0, Vec3::Y * (0.3 + gap), Quat::IDENTITY);
            let found = drift(backend, &s, &settings, 0);
            assert!(found.moved < 5e-4 && found.speed < 0.02, "gap {gap}: {found:?}");
        }
    }
}
