//! Friction, tipping, weight and rolling against their closed forms.

use super::{both, drift, measured, settings, undamped};
use crate::common::hulls::{cuboid, prism, shifted, sliced_ball};
use crate::common::scenario::{Scenario, box_inertia, run};
use glam::{Quat, Vec3};
use rest3d_gpu::world::{Backend, Pose, Velocity};

/// A slope that rises along +x.
fn rising(degrees: f32) -> Quat {
    Quat::from_rotation_z(degrees.to_radians())
}

/// A fixed slope through (0, 30, 0) with a body on it: its parts, its mass and inertia, and its height above the slope.
fn on_slope(slope: Quat, part: Vec<Vec<Vec3>>, mass: f32, inertia: Vec3, height: f32) -> Scenario {
    let at = |local: Vec3| slope * local + Vec3::Y * 30.0;
    let mut s = Scenario::default();
    s.fixed(vec![cuboid(Vec3::new(20.0, 0.5, 2.0))], at(Vec3::Y * -0.5), slope);
    s.body(part, mass, inertia, Pose::new(slope, at(Vec3::Y * height)));
    s
}

fn box_on_slope(slope: Quat, half: Vec3) -> Scenario {
    on_slope(slope, vec![cuboid(half)], 1.0, box_inertia(1.0, half), half.y)
}

pub fn friction_cone(backend: &dyn Backend) {
    for settings in both(backend, 60).map(undamped) {
        let half = Vec3::new(0.2, 0.05, 0.2);
        let slid = |degrees: f32| drift(backend, &box_on_slope(rising(degrees), half), &settings, 0).moved;
        let held = slid(44.0);
        measured("slid in 1 s at 44°, m", held, 0);
        assert!(held < 1e-3, "44° must hold, slid {held} m");
        for (degrees, tolerance) in [(46.0, 0.1), (60.0, 0.02)] {
            let angle = f32::to_radians(degrees);
            let exact = 0.5 * 9.8 * (angle.sin() - angle.cos());
            let found = slid(degrees);
            measured(&format!("slid in 1 s at {degrees}°, m"), found, exact);
            assert!((found - exact).abs() < tolerance * exact, "{degrees}°: slid {found} m, expected {exact}");
        }
    }
}

/// The ends of the slabs touch what slides from one onto the next, but do not bar its way.
pub fn what_slides_over_seams_is_not_stopped(backend: &dyn Backend) {
    const SLAB: Vec3 = Vec3::new(0.1, 0.05, 0.5);
    let half = Vec3::new(0.15, 0.05, 0.1);
    let foot = |i: usize| {
        let corner = Vec3::new((i & 1) as f32 - 0.5, 0.0, (i >> 1) as f32 - 0.5);
        shifted(&cuboid(0.45 * half), 1.1 * half * corner - 0.55 * half.y * Vec3::Y)
    };
    let feet: Vec<Vec<Vec3>> = (0..4).map(foot).chain([cuboid(half * Vec3::new(1.0, 0.1, 1.0))]).collect();
    for settings in both(backend, 60) {
        for (part, height) in [(vec![cuboid(half)], half.y), (feet.clone(), half.y)] {
            for (degrees, turned) in [(50.0, 0.0), (54.0, 20f32), (60.0, 0.0), (70.0, 30.0)] {
                let slope = rising(degrees) * Quat::from_rotation_y(turned.to_radians());
                let inertia = box_inertia(1.0, half);
                let whole = on_slope(slope, part.clone(), 1.0, inertia, height);
                let slab =
                    |i: usize| shifted(&cuboid(SLAB), Vec3::X * (1.07 - 2.0 * SLAB.x * i as f32) - SLAB.y * Vec3::Y);
                let mut of_slabs = Scenario::default();
                of_slabs.fixed((0..40).map(slab).collect(), 30.0 * Vec3::Y, rising(degrees));
                let start = Pose::new(slope, 30.0 * Vec3::Y + height * (slope * Vec3::Y));
                of_slabs.body(part.clone(), 1.0, inertia, start);
                let [expected, found] = [&whole, &of_slabs].map(|s| drift(backend, s, &settings, 0).moved);
                measured(&format!("slid over slabs in 1 s at {degrees}°, turned by {turned}°, m"), found, expected);
                assert!((found - expected).abs() < 0.02 * expected, "{degrees}°, {turned}°: {found} of {expected} m");
            }
        }
    }
}

/// Friction has no directions of its own: whichever way a slope faces, an oblong box slides straight down.
pub fn what_slides_goes_straight_down(backend: &dyn Backend) {
    for settings in both(backend, 60) {
        for (degrees, turned) in [(46.0, 15f32), (50.0, 45.0), (50.0, 60.0), (60.0, 15.0)] {
            let slope = Quat::from_rotation_y(turned.to_radians()) * rising(degrees);
            let world = box_on_slope(slope, Vec3::new(0.2, 0.05, 0.15)).world();
            let states = run(backend, &world, &settings);
            let way = states[59].0[1].translation - world.start[1].translation;
            let (down, aside) = (way.dot(slope * -Vec3::X), way.dot(slope * Vec3::Z).abs());
            measured(&format!("aside of {down} m down {degrees}°, turned by {turned}°, m"), aside, 0);
            assert!(aside < 1e-3 * down, "{degrees}°, turned by {turned}°: {aside} m aside of {down} m");
        }
    }
}

pub fn a_block_tips_at_its_aspect(backend: &dyn Backend) {
    for width in [0.2, 0.05, 0.01, 0.005] {
        let half = 0.5 * width * Vec3::new(1.0, 2.0, 1.0);
        let limit = (half.x / half.y).atan().to_degrees();
        for settings in both(backend, 240) {
            for (degrees, tips) in [(limit - 0.25, false), (limit + 0.25, true)] {
                let found = drift(backend, &box_on_slope(rising(degrees), half), &settings, 0);
                let what = format!("turn of a block of {width} m at {degrees}° of {limit}°, rad");
                measured(&what, found.turned, tips);
                assert_eq!(found.turned > 0.5, tips, "{what}: {found:?}");
                assert!(tips || found.moved < 1e-3, "{what}: {found:?}");
            }
        }
    }
}

pub fn an_overhang_tips_when_its_centre_passes_the_edge(backend: &dyn Backend) {
    for settings in both(backend, 240) {
        for (past, tips) in [(-1e-3, false), (1e-3, true)] {
            let mut s = Scenario::default();
            s.fixed(vec![cuboid(Vec3::splat(0.5))], Vec3::Y * 0.5, Quat::IDENTITY);
            s.cuboid(Vec3::new(0.3, 0.05, 0.1), 1.0, Vec3::new(0.5 + past, 1.05, 0.0), Quat::IDENTITY);
            let found = drift(backend, &s, &settings, 0);
            measured(&format!("turn of an overhang {past} m past the edge, rad"), found.turned, tips);
            assert_eq!(found.turned > 0.05, tips, "centre {past} m past the edge: {found:?}");
        }
    }
}

/// What bears has corners of up to 170°, none of which may be left out.
pub fn a_turned_overhang_tips_there_too(backend: &dyn Backend) {
    let halves = [Vec3::new(0.3, 0.1, 0.05), Vec3::new(0.3, 0.02, 0.05), Vec3::new(0.25, 0.12, 0.03)];
    for (half, degrees) in halves.into_iter().flat_map(|half| [20.0f32, 45.0, 75.0, 77.0, 80.0].map(|d| (half, d))) {
        for (past, tips) in [(-1e-3, false), (1e-3, true)] {
            let mut s = Scenario::default();
            s.fixed(vec![cuboid(Vec3::new(0.3, 0.2, 0.8))], Vec3::Y * 0.2, Quat::IDENTITY);
            let turn = Quat::from_rotation_y(degrees.to_radians());
            s.cuboid(half, 1.0, Vec3::new(0.3 + past, 0.4 + half.y, 0.0), turn);
            let found = drift(backend, &s, &settings(240), 0);
            measured(&format!("{half} m turned by {degrees}°, {past} m past the edge: turn"), found.turned, tips);
            assert_eq!(found.turned > 0.05, tips, "{half} m turned by {degrees}°, {past} m past the edge: {found:?}");
        }
    }
}

/// The rim crosses the foot in three straight pieces, and the corners between them bear. The foot is of many parts, most
/// of whose corners are inside what bears.
pub fn a_foot_of_many_parts_tips_at_the_rim_of_a_round_table(backend: &dyn Backend) {
    const SIDES: usize = 24;
    let apothem = 0.6 * (std::f32::consts::PI / SIDES as f32).cos();
    let tile = |i: usize| {
        shifted(&cuboid(Vec3::new(0.03, 0.01, 0.03)), 0.06 * Vec3::new((i % 4) as f32 - 1.5, 0.0, (i / 4) as f32 - 1.5))
    };
    let pole = shifted(&cuboid(Vec3::new(0.01, 0.1, 0.01)), 0.11 * Vec3::Y);
    let parts: Vec<Vec<Vec3>> = (0..16).map(tile).chain([pole]).collect();
    for degrees in (0..360).step_by(15) {
        for (past, tips) in [(-1e-3, false), (1e-3, true)] {
            let turn = Quat::from_rotation_y((degrees as f32).to_radians());
            let mut s = Scenario::default();
            s.fixed(vec![prism(0.6, 0.02, SIDES)], 0.52 * Vec3::Y, turn);
            let at = Pose::new(Quat::IDENTITY, (apothem + past) * (turn * Vec3::X) + 0.55 * Vec3::Y);
            s.body(parts.clone(), 1.0, Vec3::splat(0.01), at);
            let found = drift(backend, &s, &settings(120), 0);
            measured(&format!("foot at {degrees}°, {past} m past the rim: turn, rad"), found.turned, tips);
            assert_eq!(found.turned > 0.02, tips, "at {degrees}°, {past} m past the rim: {found:?}");
        }
    }
}

/// A beam of 1 kg lies on a fixed block with its centre 0.2 m inside the edge, and a load 0.3 m outside. It tips when
/// the load presses with more than 2/3 of the beam's own weight: a balance for the force of a contact at rest.
pub fn a_lever_weighs_half_a_percent(backend: &dyn Backend) {
    for settings in both(backend, 360) {
        for (share, tips) in [(0.995, false), (1.005, true)] {
            let mut s = Scenario::default();
            s.fixed(vec![cuboid(Vec3::splat(0.5))], Vec3::new(-0.5, 0.5, 0.0), Quat::IDENTITY);
            s.cuboid(Vec3::new(0.6, 0.02, 0.1), 1.0, Vec3::new(-0.2, 1.02, 0.0), Quat::IDENTITY);
            s.cuboid(Vec3::splat(0.05), share * 2.0 / 3.0, Vec3::new(0.3, 1.09, 0.0), Quat::IDENTITY);
            let found = drift(backend, &s, &settings, 0);
            measured(&format!("turn of a lever loaded with {share} of its balance, rad"), found.turned, tips);
            assert_eq!(found.turned > 0.02, tips, "{share} of the balance: {found:?}");
        }
    }
}

/// A solid ball accelerates with 5/7 g sin θ. These have 168 corners around their equator. They roll slower: a contact
/// may sink by `LINEAR_SLOP`, so the large one stands on 2 cm of its rim, whose front brakes; the small one turns by up
/// to 20° between two searches for contacts, and loses 16 %. Without points onto which it may roll it loses 20 %, and
/// slips by 7 % of its speed.
pub fn a_ball_rolls(backend: &dyn Backend) {
    for (radius, degrees, tolerance, most_slip) in [(0.5f32, 10.0f32, 0.05, 0.01), (0.05, 20.0, 0.19, 0.05)] {
        for settings in both(backend, 60).map(undamped) {
            let inertia = Vec3::splat(0.4 * radius * radius);
            let s = on_slope(rising(degrees), sliced_ball(radius, 24, 7), 1.0, inertia, radius);
            let world = s.world();
            let states = run(backend, &world, &settings);
            let (poses, _) = &states[59];
            let rolled = poses[1].translation.distance(world.start[1].translation);
            let exact = 0.5 * 5.0 / 7.0 * 9.8 * degrees.to_radians().sin();
            measured(&format!("ball of {radius} m, rolled in 1 s at {degrees}°, m"), rolled, exact);
            // Of the sums of all steps: at each of its edges a ball slips or spins for a moment.
            let sum = |speed: fn(&Velocity) -> f32| states.iter().map(|(_, v)| speed(&v[1])).sum::<f32>();
            let (speed, spin) = (sum(|v| v.linear.length()), sum(|v| v.angular.z));
            let slip = (speed - radius * spin).abs() / speed;
            measured("slip of the rolling ball, share of its speed", slip, 0);
            assert!((rolled - exact).abs() < tolerance * exact, "{radius} m: rolled {rolled} m, expected {exact}");
            assert!(slip < most_slip, "{radius} m: slips by {slip} of its speed");
        }
    }
}

/// A prism rolls over its edges like a rimless wheel (T. McGeer, 1990): it pivots on one, and the next takes what the
/// inelastic hit costs. Slow enough that it never leaves the slope.
pub fn a_prism_rolls_over_its_edges(backend: &dyn Backend) {
    const SIDES: usize = 32;
    for (radius, degrees) in [(0.03f32, 7.0f32), (0.05, 8.0), (0.2, 15.0)] {
        let edges: Vec<Vec3> = (0..SIDES)
            .flat_map(|i| {
                let (sin, cos) = (std::f32::consts::TAU * (i as f32 + 0.5) / SIDES as f32).sin_cos();
                [-1.0, 1.0].map(|side| radius * Vec3::new(cos, sin, side))
            })
            .collect();
        let half_side = std::f32::consts::PI / SIDES as f32;
        let about_axis = radius * radius * (2.0 + (2.0 * half_side).cos()) / 6.0;
        let across = 0.5 * about_axis + radius * radius / 3.0;
        let inertia = Vec3::new(across, across, about_axis);
        let exact = rimless_wheel(radius, half_side, about_axis, degrees.to_radians());
        let (slope, height) = (rising(degrees), radius * half_side.cos());
        let first_fixed = on_slope(slope, vec![edges.clone()], 1.0, inertia, height);
        let mut last_fixed = Scenario::default();
        last_fixed.body(vec![edges], 1.0, inertia, Pose::new(slope, slope * (Vec3::Y * height) + Vec3::Y * 30.0));
        last_fixed.fixed(vec![cuboid(Vec3::new(20.0, 0.5, 2.0))], slope * (Vec3::Y * -0.5) + Vec3::Y * 30.0, slope);
        for (s, body) in [(first_fixed, 1), (last_fixed, 0)] {
            let world = s.world();
            for settings in both(backend, 60).map(undamped) {
                let end = run(backend, &world, &settings)[59].0[body].translation;
                let rolled = end.distance(world.start[body].translation);
                measured(&format!("prism of {radius} m rolled in 1 s at {degrees}°, m"), rolled, exact);
                assert!((rolled - exact).abs() < 0.06 * exact, "{radius} m, {degrees}°: {rolled} m, expected {exact}");
            }
        }
    }
}

/// How far the centre of a rimless wheel of 1 kg comes in 1 s from rest on a side, m.
fn rimless_wheel(radius: f32, half_side: f32, inertia: f32, slope: f32) -> f32 {
    const STEPS: u32 = 100_000;
    let [radius, half_side, inertia, slope] = [radius, half_side, inertia, slope].map(f64::from);
    let about_edge = inertia + radius * radius;
    let h = 1.0 / f64::from(STEPS);
    // The centre's angle about the edge, from the slope's normal.
    let (mut angle, mut spin, mut come) = (-half_side, 0.0, 0.0);
    for _ in 0..STEPS {
        spin += h * 9.8 * radius * (angle + slope).sin() / about_edge;
        angle += h * spin;
        if angle >= half_side {
            angle -= 2.0 * half_side;
            spin *= (inertia + radius * radius * (2.0 * half_side).cos()) / about_edge;
            come += 2.0 * radius * half_side.sin();
        }
    }
    (come + radius * (angle.sin() + half_side.sin())) as f32
}

/// A block that falls over its edge is a pendulum upside down until it hits the ground.
pub fn a_block_topples_like_a_pendulum(backend: &dyn Backend) {
    const STEPS: u32 = 20;
    let half = Vec3::new(0.02, 0.1, 0.05);
    let aspect = half.x.atan2(half.y);
    let size = half.x.hypot(half.y);
    let start = 8f32.to_radians();
    let (mut exact, mut spin) = (f64::from(start), 0.0);
    for _ in 0..STEPS * 1000 {
        let h = 1e-3 / 60.0;
        spin += h * 0.75 * 9.8 / f64::from(size) * exact.sin();
        exact += h * spin;
    }
    for settings in both(backend, STEPS).map(undamped) {
        let turn = Quat::from_rotation_z(-aspect - start);
        let mut s = Scenario::default();
        s.cuboid(half, 1.0, turn * Vec3::new(-half.x, half.y, 0.0), turn);
        let found = f64::from(start + drift(backend, &s, &settings, 0).turned);
        measured("angle of a block that falls over, rad", found, exact);
        assert!((found - exact).abs() < 0.01 * exact, "turned to {found} rad, expected {exact}");
    }
}
