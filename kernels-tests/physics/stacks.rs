//! What people pile up stays where it was put.

use super::concave::snug_shelf;
use super::{both, drift, measured, peak_speed, settings};
use crate::common::hulls::{cuboid, prism, ring, shifted, truncated_cube};
use crate::common::scenario::{Scenario, State, any, box_inertia, run};
use glam::{Quat, Vec3};
use rest3d_gpu::world::{Backend, Pose, SimSettings, Velocity};

pub fn ten_high_stacks_stand(backend: &dyn Backend) {
    // Near touching, the axes of GJK and EPA are too noisy for the reference to hold so tall a stack still.
    let settings = settings(600);
    let shapes =
        [("boxes", cuboid(Vec3::splat(0.1))), ("truncated cubes", truncated_cube(0.1)), ("prisms", prism(0.1, 0.1, 8))];
    for (name, shape) in shapes {
        let mut s = Scenario::default();
        for i in 0..10 {
            let at = Pose::new(Quat::IDENTITY, Vec3::Y * (0.1 + 0.2 * i as f32));
            s.body(vec![shape.clone()], 1.0, box_inertia(1.0, Vec3::splat(0.1)), at);
        }
        let found = drift(backend, &s, &settings, 180);
        measured(&format!("drift of ten {name} in 10 s, m"), found.moved, "< 0.001");
        assert!(found.moved < 1e-3 && found.turned < 1e-3 && found.speed < 5e-4, "{name}: {found:?}");
    }
}

/// Cubes on one another: the mass of each, and how far they are shifted, as a share of their half size, and turned.
fn tower(half: f32, masses: &[f32], crooked: f32) -> Scenario {
    let mut s = Scenario::default();
    for (i, &mass) in masses.iter().enumerate() {
        let beside = |which: usize| crooked * half * (any(i, which) - 0.5);
        let at = Vec3::new(beside(0), half * (1.0 + 2.0 * i as f32), beside(1));
        s.cuboid(Vec3::splat(half), mass, at, Quat::from_rotation_y(3.0 * crooked * (any(i, 2) - 0.5)));
    }
    s
}

pub fn small_and_crooked_towers_stand(backend: &dyn Backend) {
    for half in [0.1, 0.05, 0.03, 0.02, 0.01] {
        for crooked in [0.0, 0.3] {
            let found = drift(backend, &tower(half, &[1.0; 10], crooked), &settings(600), 300);
            measured(
                &format!("drift of ten cubes of {} m, {crooked} crooked, in 10 s, m", 2.0 * half),
                found.moved,
                "< 0.001",
            );
            assert!(found.moved < 1e-3 && found.turned < 2e-2, "{half} m, {crooked} crooked: {found:?}");
        }
    }
}

pub fn uneven_loads_stand(backend: &dyn Backend) {
    let rising: Vec<f32> = (1..=10).map(|i| i as f32).collect();
    let falling: Vec<f32> = rising.iter().rev().copied().collect();
    let topped = |top: f32| [vec![1.0; 9], vec![top]].concat();
    let loads = [rising, falling, topped(5.0), topped(10.0), vec![1.0, 1.0, 1.0, 100.0], vec![1.0, 100.0, 1.0, 100.0]];
    for masses in &loads {
        for half in [0.1, 0.05] {
            let found = drift(backend, &tower(half, masses, 0.0), &settings(600), 300);
            measured(&format!("drift of {masses:?} kg of {} m in 10 s, m", 2.0 * half), found.moved, 0);
            assert!(found.moved < 5e-3 && found.speed < 2e-2, "{masses:?} kg, {half} m: {found:?}");
        }
    }
    // A heavy thing beside the middle of a light one.
    for half in [0.1, 0.05] {
        let mut s = Scenario::default();
        s.cuboid(Vec3::splat(half), 1.0, Vec3::Y * half, Quat::IDENTITY);
        s.cuboid(Vec3::splat(half), 100.0, half * Vec3::new(0.7, 3.0, 0.2), Quat::IDENTITY);
        let found = drift(backend, &s, &settings(600), 300);
        measured(&format!("drift of 100 kg beside the middle of 1 kg of {} m, m", 2.0 * half), found.moved, 0);
        assert!(found.moved < 5e-3 && found.speed < 2e-3, "{half} m: {found:?}");
    }
}

/// Nothing has to sag before it bears: neither books and boards under a weight, nor what begins a little above another.
pub fn high_piles_bear_from_the_start(backend: &dyn Backend) {
    let books = |gap: f32| {
        let mut s = Scenario::default();
        for i in 0..20 {
            let at = Vec3::Y * (0.015 + (0.03 + gap) * i as f32);
            s.cuboid(Vec3::new(0.1, 0.015, 0.075), 0.5, at, Quat::IDENTITY);
        }
        s
    };
    // In no order, with a weight on top and 4 cm beside the middle.
    let mut boards = Scenario::default();
    for i in 0..20 {
        let at = Vec3::Y * 0.005 * (0.5 + (7 * i % 20) as f32);
        boards.cuboid(Vec3::new(0.15, 0.0025, 0.1), 0.2, at, Quat::IDENTITY);
    }
    boards.cuboid(Vec3::splat(0.05), 4.0, Vec3::new(0.04, 0.15, 0.0), Quat::IDENTITY);
    // What is snug in a shelf bears and is borne by it, but what stands on the shelf presses on the ground alone.
    let mut shelf = snug_shelf(0.0, [1.0, 0.2], false);
    shelf.cuboid(Vec3::splat(0.1), 20.0, Vec3::Y * 0.34, Quat::IDENTITY);
    let scenes = [
        ("a full shelf under a weight", shelf, 1e-5, 1e-3),
        ("books", books(0.0), 1e-4, 1e-3),
        ("books with gaps of 0.3 mm", books(3e-4), 2e-3, 5e-3),
        ("boards under a weight", boards, 1e-4, 1e-3),
        ("cubes of 1 and 100 kg", tower(0.1, &[1.0, 100.0, 1.0, 100.0], 0.0), 1e-4, 1e-3),
    ];
    for (name, s, most_sag, most_gained) in scenes {
        let settings = settings(300);
        let world = s.world();
        let states = run(backend, &world, &settings);
        let bodies = 0..world.bodies.len();
        let height = |(poses, _): &State, i: usize| poses[i].translation.y;
        let last = &states[states.len() - 1];
        let sag = |state: &State| bodies.clone().map(|i| height(last, i) - height(state, i)).fold(0.0, f32::max);
        let most = states.iter().map(sag).fold(0.0, f32::max);
        measured(&format!("sag of {name} below where they come to rest, m"), most, 0);
        assert!(most < most_sag, "{name} sag by {most} m");
        let start = s.energy(&(world.start.clone(), vec![Velocity::default(); world.bodies.len()]), settings.gravity);
        let (mut lowest, mut gained) = (start, 0.0f64);
        for energy in states.iter().map(|state| s.energy(state, settings.gravity)) {
            lowest = lowest.min(energy);
            gained = gained.max(energy - lowest);
        }
        measured(&format!("energy that {name} gain, share of the first"), gained / start, 0);
        assert!(gained < most_gained * start, "{name} gain {gained} J of {start}");
    }
}

pub fn round_stacks_stand(backend: &dyn Backend) {
    let stacks = [("cans", 0.033, 0.06, 24, 8), ("plates", 0.1, 0.01, 32, 10), ("rods", 0.05, 0.1, 16, 10)];
    for (name, radius, half_height, sides, count) in stacks {
        let mut s = Scenario::default();
        for i in 0..count {
            let at = Pose::new(Quat::IDENTITY, Vec3::Y * half_height * (1.0 + 2.0 * i as f32));
            let inertia = box_inertia(0.4, Vec3::new(0.87 * radius, half_height, 0.87 * radius));
            s.body(vec![prism(radius, half_height, sides)], 0.4, inertia, at);
        }
        let found = drift(backend, &s, &settings(600), 300);
        measured(&format!("drift of {count} {name} in 10 s, m"), found.moved, "< 0.001");
        assert!(found.moved < 1e-3 && found.speed < 2e-3, "{name}: {found:?}");
    }
}

/// Rods on facets of 0.4 to 1 mm, of which none may move by half.
pub fn thin_rods_lie_still(backend: &dyn Backend) {
    for (radius, half_length, sides) in [(0.002, 0.06, 32), (0.003, 0.009, 24), (0.004, 0.075, 30), (0.005, 0.075, 32)]
    {
        let mut s = Scenario::default();
        let apothem = radius * (std::f32::consts::PI / sides as f32).cos();
        // Turned onto the facet between its first corners.
        let lying = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
        let turned = Quat::from_rotation_y(std::f32::consts::TAU / sides as f32 * (0.25 * sides as f32).fract());
        let inertia = box_inertia(0.02, Vec3::new(0.87 * radius, half_length, 0.87 * radius));
        s.body(vec![prism(radius, half_length, sides)], 0.02, inertia, Pose::new(lying * turned, Vec3::Y * apothem));
        let found = drift(backend, &s, &settings(600), 300);
        measured(&format!("turn of a rod of {radius} m with {sides} sides in 10 s, rad"), found.turned, 0);
        assert!(found.turned < 0.02 && found.moved < 0.2e-3 && found.speed < 2e-3, "{radius} m: {found:?}");
    }
}

pub fn a_pyramid_stands(backend: &dyn Backend) {
    for settings in both(backend, 300) {
        let mut s = Scenario::default();
        for row in 0..5 {
            for i in 0..5 - row {
                let x = 0.21 * (i as f32 + 0.5 * row as f32);
                s.cuboid(Vec3::splat(0.1), 1.0, Vec3::new(x, 0.1 + 0.2 * row as f32, 0.0), Quat::IDENTITY);
            }
        }
        let found = drift(backend, &s, &settings, 120);
        measured("drift of a pyramid in 5 s, m", found.moved, "< 0.001");
        assert!(found.moved < 1e-3 && found.speed < 2e-3, "{found:?}");
    }
}

pub fn a_mass_ratio_of_a_hundred(backend: &dyn Backend) {
    for settings in both(backend, 300) {
        for masses in [[1.0, 100.0], [100.0, 1.0]] {
            let mut s = Scenario::default();
            for (i, mass) in masses.into_iter().enumerate() {
                s.cuboid(Vec3::splat(0.1), mass, Vec3::Y * (0.1 + 0.2 * i as f32), Quat::IDENTITY);
            }
            let found = drift(backend, &s, &settings, 120);
            measured(&format!("drift of {masses:?} kg in 5 s, m"), found.moved, 0);
            assert!(found.moved < 2e-3 && found.speed < 2e-3, "{masses:?}: {found:?}");
        }
    }
}

/// Three blocks side by side and one across their middle, by turns: what lies on the one across is borne on a third of
/// its length. Solving contacts in one order only once shook such stacks for ever.
pub fn crossed_blocks_stand(backend: &dyn Backend) {
    let half = Vec3::new(0.0375, 0.0075, 0.0125);
    for levels in [3, 9] {
        let mut s = Scenario::default();
        for level in 0..levels {
            let beside = if level % 2 == 0 { 0.0255 } else { 0.0 };
            for k in if level % 2 == 0 { -1..=1 } else { 0..=0 } {
                let turn = Quat::from_rotation_y(if level % 2 == 0 { std::f32::consts::FRAC_PI_2 } else { 0.0 });
                s.cuboid(half, 0.02, Vec3::new(beside * k as f32, half.y * (1.0 + 2.0 * level as f32), 0.0), turn);
            }
        }
        let found = drift(backend, &s, &settings(600), 300);
        measured(&format!("drift of {levels} levels of crossed blocks in 10 s, m"), found.moved, "< 0.001");
        assert!(found.moved < 1e-3 && found.speed < 1e-3, "{levels} levels: {found:?}");
    }
}

/// A heavy thing that reaches beyond a light one, its centre well inside; and one whose centre is near the edge.
pub fn heavy_overhangs_stand(backend: &dyn Backend) {
    for mass in [77.0, 100.0] {
        let mut s = Scenario::default();
        s.cuboid(Vec3::new(0.25, 0.15, 0.35), 1.0, Vec3::Y * 0.15, Quat::IDENTITY);
        s.cuboid(Vec3::new(0.45, 0.15, 0.4), mass, Vec3::new(-0.1, 0.45, 0.14), Quat::IDENTITY);
        let found = drift(backend, &s, &settings(600), 300);
        measured(&format!("drift of {mass} kg that overhang 1 kg in 10 s, m"), found.moved, 0);
        assert!(found.moved < 5e-3 && found.speed < 2e-3, "{mass} kg: {found:?}");
    }
    for (mass, inside) in [(20.0, 0.002), (40.0, 0.004), (100.0, 0.01)] {
        let mut s = Scenario::default();
        s.cuboid(Vec3::splat(0.05), 1.0, Vec3::Y * 0.05, Quat::IDENTITY);
        s.cuboid(Vec3::new(0.15, 0.05, 0.15), mass, Vec3::new(0.05 - inside, 0.15, 0.0), Quat::IDENTITY);
        let found = drift(backend, &s, &settings(300), 200);
        measured(&format!("drift of {mass} kg, {inside} m from the edge of 1 kg, in 5 s, m"), found.moved, 0);
        assert!(found.moved < 5e-3 && found.turned < 0.05, "{mass} kg, {inside} m: {found:?}");
    }
}

const BOOK: Vec3 = Vec3::new(0.125, 0.01, 0.09);

/// A book that leans on a fixed wall, `degrees` from the ground.
pub fn leaning_book(degrees: f32) -> Scenario {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let mut s = Scenario::default();
    s.fixed(
        vec![cuboid(Vec3::new(0.5, 1.0, 1.0))],
        Vec3::new(0.5 + BOOK.x * cos + BOOK.y * sin, 1.0, 0.0),
        Quat::IDENTITY,
    );
    let turn = Quat::from_rotation_z(degrees.to_radians());
    s.cuboid(BOOK, 1.0, Vec3::Y * (BOOK.x * sin + BOOK.y * cos), turn);
    s
}

/// Angle at which a book begins to slide with friction μ on ground and wall. With both contacts at their limit, moments
/// about the lower edge give tan θ · (1 + t (1 + μ²) / 2μ) = (1 − μ²) / 2μ for a book t times as thick as long; without
/// thickness, the ladder's (1 − μ²) / 2μ.
fn sliding_angle(friction: f32) -> f32 {
    let square = friction * friction;
    let thick = BOOK.y / BOOK.x * (1.0 + square) / (2.0 * friction);
    ((1.0 - square) / (2.0 * friction) / (1.0 + thick)).atan().to_degrees()
}

pub fn a_book_leans_as_statics_say(backend: &dyn Backend) {
    // μ = 1 holds at any angle; at μ = 0.5 the limit lies between 30° and 60°.
    assert_eq!(sliding_angle(1.0), 0.0);
    let limit = sliding_angle(0.5);
    let cases = [(1.0, 60.0), (1.0, 30.0), (0.5, 60.0), (0.5, 30.0), (0.5, limit + 2.0), (0.5, limit - 2.0)];
    for settings in both(backend, 300) {
        for (friction, degrees) in cases {
            let holds = degrees > sliding_angle(friction);
            let settings = SimSettings { friction, ..settings.clone() };
            let found = drift(backend, &leaning_book(degrees), &settings, 120);
            measured(
                &format!("drift of a book at {degrees}°, friction {friction}, m"),
                found.moved,
                if holds { "0" } else { "slides" },
            );
            if holds {
                assert!(found.moved < 1e-3, "{degrees}°, friction {friction} must hold: {found:?}");
            } else {
                assert!(found.moved > 0.02, "{degrees}°, friction {friction} must slide: {found:?}");
            }
        }
    }
}

pub fn a_table_on_thin_legs_bears_a_load(backend: &dyn Backend) {
    // Few heavy things, and many that cover it.
    let few = [-0.3, 0.3].map(|x| [-0.2, 0.2].map(|z| (x, z))).concat();
    let many = [-0.45, -0.15, 0.15, 0.45].map(|x| [-0.25, 0.0, 0.25].map(|z| (x, z))).concat();
    for settings in both(backend, 120) {
        for (load, places) in [(20.0, &few), (5.0, &many)] {
            let mut s = Scenario::default();
            s.table(10.0);
            for &(x, z) in places {
                s.cuboid(Vec3::splat(0.1), load, Vec3::new(x, 0.84, z), Quat::IDENTITY);
            }
            let found = drift(backend, &s, &settings, 30);
            measured(&format!("drift of a table with {} loads of {load} kg in 2 s, m", places.len()), found.moved, 0);
            assert!(found.moved < 1e-3 && found.speed < 0.02, "{} loads of {load} kg: {found:?}", places.len());
        }
    }
}

/// Each load shifts the table against the others, and all that holds it is what they press it down with.
pub fn a_light_table_bears_several_heavy_things(backend: &dyn Backend) {
    let places = [(-0.35, 0.1), (0.05, -0.12), (0.36, 0.12), (0.1, 0.15), (-0.12, 0.02)];
    for (count, load, overlap) in [(3, 10.0, 0.0), (3, 10.0, 2e-3), (4, 5.0, 1e-3), (5, 6.0, 2e-3), (5, 2.0, 1e-3)] {
        let mut s = Scenario::default();
        s.table(1.0);
        for &(x, z) in &places[..count] {
            s.cuboid(Vec3::splat(0.08), load, Vec3::new(x, 0.82 - overlap, z), Quat::IDENTITY);
        }
        let found = drift(backend, &s, &settings(600), 300);
        let name = format!("{count} loads of {load} kg, {overlap} m in a table of 1 kg");
        measured(&format!("drift of {name} in 10 s, m"), found.moved, 0);
        // They rattle a little: 2.5 mm/s under 30 kg. With too few sweeps it is 5 to 8 mm/s, and they walk.
        assert!(found.moved < 5e-3 && found.speed < 4e-3, "{name}: {found:?}");
    }
}

/// One to three pairs of cards, whose tops touch exactly, under a plate, each number other ones.
pub fn house_of_cards(number: usize) -> Scenario {
    let any = |j: usize, low: f32, high: f32| low + (high - low) * any(number, j);
    let (thick, long, wide) = (0.5 * any(0, 0.004, 0.02), 0.5 * any(1, 0.1, 0.3), 0.5 * any(2, 0.06, 0.2));
    let (lean, pairs, mass) = (any(3, 10.0, 25.0).to_radians(), 1 + number % 3, [0.05, 0.2, 1.0][number / 3 % 3]);
    let (sin, cos) = lean.sin_cos();
    let apart = 4.0 * long * sin + any(4, 0.02, 0.1) + 4.0 * thick;
    let mut s = Scenario::default();
    for pair in 0..pairs {
        for side in [-1.0, 1.0] {
            let x = pair as f32 * apart + side * (long * sin + thick * cos);
            let at = Vec3::new(x, long * cos + thick * sin, 0.0);
            s.cuboid(Vec3::new(thick, long, wide), mass, at, Quat::from_rotation_z(side * lean));
        }
    }
    let plate = Vec3::new(0.5 * apart * ((pairs - 1) as f32 + any(5, 0.3, 0.9)), 0.5 * any(6, 0.005, 0.02), wide);
    let at = Vec3::new(0.5 * apart * (pairs - 1) as f32, 2.0 * (long * cos + thick * sin) + plate.y, 0.0);
    s.cuboid(plate, mass * [0.5, 1.0, 3.0][number / 9 % 3], at, Quat::IDENTITY);
    s
}

/// What pushes the tops apart is the plate's friction; they must not lose their hold on each other to it.
pub fn houses_of_cards_stand(backend: &dyn Backend) {
    let mut most = 0.0f32;
    for number in 0..27 {
        let found = drift(backend, &house_of_cards(number), &settings(300), 200);
        most = most.max(found.moved);
        assert!(found.moved < 1e-3 && found.turned < 2e-3, "house {number}: {found:?}");
    }
    measured("largest drift of 27 houses of cards in 5 s, m", most, "< 0.001");
}

/// A mug of 31 wall wedges and a bottom: 8 cm wide, 10 cm high, walls of 4 mm.
fn mug(s: &mut Scenario, height: f32) {
    let [inner, outer, top] = [0.036f32, 0.04, 0.1];
    let (wall_mass, bottom_mass) = (0.25, 0.05);
    let mass = wall_mass + bottom_mass;
    let center = (wall_mass * 0.5 * top + bottom_mass * 0.0025) / mass;
    let rim = inner * inner + outer * outer;
    let along = 0.5 * wall_mass * rim + 0.5 * bottom_mass * outer * outer;
    let across = wall_mass * (0.25 * rim + top * top / 12.0 + (0.5 * top - center).powi(2))
        + bottom_mass * (0.25 * outer * outer + center * center);
    let mut parts = ring([inner, outer], [inner, outer], [0.0, top], 31);
    parts.push(shifted(&prism(inner, 0.0025, 31), Vec3::Y * 0.0025));
    let parts = parts.iter().map(|part| shifted(part, Vec3::Y * -center)).collect();
    let at = Pose::new(Quat::IDENTITY, Vec3::new(0.05, height + center, 0.02));
    s.body(parts, mass, Vec3::new(across, along, across), at);
}

pub fn a_mug_rests_on_a_tray_on_a_table(backend: &dyn Backend) {
    for settings in both(backend, 300) {
        let mut s = Scenario::default();
        s.table(15.0);
        let rim_x = Vec3::new(0.005, 0.02, 0.14);
        let rim_z = Vec3::new(0.2, 0.02, 0.005);
        let tray = [
            (Vec3::new(0.2, 0.005, 0.15), Vec3::Y * 0.005),
            (rim_x, Vec3::new(-0.195, 0.02, 0.0)),
            (rim_x, Vec3::new(0.195, 0.02, 0.0)),
            (rim_z, Vec3::new(0.0, 0.02, -0.145)),
            (rim_z, Vec3::new(0.0, 0.02, 0.145)),
        ];
        s.furniture(&tray, 0.8, Vec3::new(0.1, 0.74, 0.0));
        mug(&mut s, 0.75);
        let world = s.world();
        assert_eq!(world.bodies[2].hull_count, 32);
        let states = run(backend, &world, &settings);
        let after_30 = peak_speed(&states[30..]);
        let after_60 = peak_speed(&states[60..]);
        let moved = states[299].0[2].translation.distance(states[60].0[2].translation);
        measured("peak speed of a mug's scene after 30 steps, m/s", after_30, "< 0.02");
        measured("and after 60 steps", after_60, "at rest");
        measured("the mug's way from step 60 to step 300, m", moved, 0);
        assert!(after_30 < 0.02, "{after_30} m/s after 30 steps");
        assert!(after_60 < 2e-3 && moved < 1e-3, "{after_60} m/s after 60 steps, {moved} m from there on");
    }
}
