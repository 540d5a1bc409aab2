//! What stands, what has fallen, and what is off its support.

use crate::fixture::*;
use glam::{DVec3, Quat, Vec2, Vec3};
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::optimize::{Config, ObjectOutcome, Outcome, run};
use rest3d_gpu::scene::{Parent, Pose, Relation};
use rest3d_gpu::shape::{Alternative, MassProperties, Part};
use std::f32::consts::TAU;

#[test]
fn lost_support_is_seen() {
    let mut boxes = Boxes::default();
    let size = Vec3::splat(0.2);
    let table = boxes.add("table", GROUND, Vec3::new(1.0, 0.5, 1.0), DVec3::ZERO);
    let on = Parent::Object(table);
    boxes.add("near", on, size, DVec3::new(-0.3, 0.504, 0.0));
    boxes.add("far", on, size, DVec3::new(0.0, 0.506, 0.0));
    boxes.add("first book", on, size, DVec3::new(0.3, 0.5, 0.0));
    boxes.add("second book", on, size, DVec3::new(0.3, 0.702, 0.0));
    boxes.add("on the floor", on, size, DVec3::new(2.0, 0.0, 0.0));
    boxes.add("floats", GROUND, size, DVec3::new(3.0, 0.02, 0.0));
    let rug = boxes.add("rug", GROUND, Vec3::new(1.0, 0.02, 1.0), DVec3::new(5.0, 0.0, 0.0));
    boxes.add("chair on the rug", GROUND, size, DVec3::new(5.0, 0.02, 0.0));
    boxes.add("picture", WALL, size, DVec3::new(8.0, 1.0, 0.0));
    boxes.add("beside it", on, size, DVec3::new(0.601, 0.0, 0.3));
    let thin = boxes.add("thin rug", GROUND, Vec3::new(1.0, 0.003, 1.0), DVec3::new(5.0, 0.0, 2.0));
    boxes.add("chair on the thin rug", Parent::Object(thin), size, DVec3::new(5.0, 0.003, 2.0));
    // Its lower face passes through the table's edge, and a corner of it stands on the ground.
    let plank = boxes.add("plank over the edge", on, Vec3::new(1.2, 0.02, 0.1), DVec3::new(0.4, 0.5, -0.3));
    boxes.turn(plank, -0.8, DVec3::new(0.5728, 0.4394, -0.3));
    boxes.objects[rug].movable = false;
    let outcome = simple(&boxes, &Fake::default(), &frozen());
    let lost: Vec<&str> = (boxes.objects.iter().zip(&outcome.objects))
        .filter(|(_, outcome)| outcome.lost_support)
        .map(|(object, _)| object.name)
        .collect();
    assert_eq!(lost, ["far", "on the floor", "floats", "beside it", "plank over the edge"]);
}

#[test]
fn what_hangs_on_something_and_does_not_touch_it_is_told() {
    let notes = |gap: f64| {
        let mut boxes = Boxes::default();
        let board = boxes.add("board", WALL, Vec3::new(1.0, 1.0, 0.02), DVec3::Y);
        let bag = boxes.add("bag", Parent::Object(board), Vec3::splat(0.2), DVec3::new(0.0, 1.2, 0.11 + gap));
        let mut scene = boxes.scene();
        scene.objects[bag].relation = Relation::Hanging;
        run(&scene, &boxes.shapes, &Fake::default(), &frozen(), 1, None, &mut Watch::default()).unwrap().notes
    };
    let told = |notes: &[String]| notes.iter().any(|note| note.contains("\"bag\" does not touch \"board\""));
    assert!(told(&notes(0.05)) && !told(&notes(0.001)), "{:?} {:?}", notes(0.05), notes(0.001));
}

/// What becomes of a crate of 20 cm whose middle is at `x` on a table that ends at 0.5 m.
fn crate_at(x: f64) -> ObjectOutcome {
    let mut boxes = Boxes::default();
    let stone = boxes.add("stone", GROUND, Vec3::new(1.0, 0.5, 1.0), DVec3::ZERO);
    boxes.objects[stone].movable = false;
    let object = boxes.add("crate", Parent::Object(stone), Vec3::splat(0.2), DVec3::new(x, 0.5, 0.1));
    let config = Config { seat: true, ..frozen() };
    let outcome = simple(&boxes, &CpuBackend, &config);
    outcome.objects[object].clone()
}

#[test]
fn what_would_fall_off_its_support_is_moved_inwards() {
    for (x, least, most) in [(0.4, 0.0, 1e-3), (0.495, 0.014, 0.022), (0.53, 0.03, 0.065), (0.6, 0.1, 0.16)] {
        let object = crate_at(x);
        assert!(object.stable && !object.fallen && !object.lost_support, "at {x} m: {object:?}");
        assert!((least..=most).contains(&object.moved), "at {x} m: {object:?}");
    }
    let object = crate_at(0.9);
    assert!(object.lost_support, "{object:?}");
}

#[test]
fn what_would_tip_with_what_is_on_it_is_moved_inwards() {
    for (x, least, most) in [(0.45, 0.0, 1e-3), (0.57, 0.014, 0.031), (0.6, 0.018, 0.035)] {
        let mut boxes = Boxes::default();
        let stone = boxes.add("stone", GROUND, Vec3::new(1.0, 0.5, 1.0), DVec3::ZERO);
        boxes.objects[stone].movable = false;
        // Alone it would stay, with its middle 8 cm from the edge.
        let tray = boxes.add("tray", Parent::Object(stone), Vec3::new(0.5, 0.02, 0.3), DVec3::new(0.42, 0.5, 0.0));
        let jug = boxes.add("jug", Parent::Object(tray), Vec3::splat(0.1), DVec3::new(x, 0.52, 0.0));
        let outcome = simple(&boxes, &CpuBackend, &Config { seat: true, ..frozen() });
        for object in [tray, jug] {
            let object = &outcome.objects[object];
            assert!(object.stable && !object.fallen && !object.lost_support, "jug at {x} m: {object:?}");
            assert!((least..=most).contains(&object.moved), "jug at {x} m: {object:?}");
        }
    }
}

/// Where a toy 10 cm long ends that is inside a tray 50 cm long, or on it, with rims 2 cm wide and 8 cm high on a floor
/// of 2 cm. Its middle is at `x` and its bottom at `y`.
fn toy_at(x: f64, y: f64, relation: Relation) -> DVec3 {
    let mut boxes = Boxes::default();
    let tray = boxes.add("tray", GROUND, Vec3::new(0.5, 0.1, 0.4), DVec3::ZERO);
    boxes.objects[tray].movable = false;
    let blocks = [
        [Vec3::new(-0.25, 0.0, -0.2), Vec3::new(0.25, 0.02, 0.2)],
        [Vec3::new(-0.25, 0.02, -0.2), Vec3::new(-0.23, 0.1, 0.2)],
        [Vec3::new(0.23, 0.02, -0.2), Vec3::new(0.25, 0.1, 0.2)],
        [Vec3::new(-0.23, 0.02, -0.2), Vec3::new(0.23, 0.1, -0.18)],
        [Vec3::new(-0.23, 0.02, 0.18), Vec3::new(0.23, 0.1, 0.2)],
    ];
    boxes.carve(tray, &blocks);
    let toy = boxes.add("toy", Parent::Object(tray), Vec3::new(0.1, 0.04, 0.06), DVec3::new(x, y, 0.0));
    let mut scene = boxes.scene();
    scene.objects[toy].relation = relation;
    let config = Config { seat: true, ..frozen() };
    let outcome = run(&scene, &boxes.shapes, &CpuBackend, &config, 1, None, &mut Watch::default()).unwrap();
    let pose = outcome.objects[toy].pose;
    pose.translation + pose.rotation * boxes.shapes[toy].mass.center.as_dvec3() - DVec3::Y * 0.02
}

#[test]
fn what_is_inside_is_not_set_onto_the_rim() {
    for relation in [Relation::Inside, Relation::On] {
        for (x, least, most) in [(0.1, -1e-3, 1e-3), (0.2, 0.01, 0.04), (-0.22, 0.03, 0.06)] {
            let place = toy_at(x, 0.02, relation);
            assert!((place.y - 0.02).abs() < 1e-3, "{relation:?} from {x}: {place}");
            assert!((least..=most).contains(&(x.abs() - place.x.abs())), "{relation:?} from {x}: {place}");
        }
    }
}

#[test]
fn what_is_on_something_may_be_on_its_rim() {
    let place = toy_at(0.24, 0.08, Relation::On);
    assert!((place.y - 0.1).abs() < 1e-3 && (place.x - 0.24).abs() < 0.02, "{place}");
}

/// A plant 10 cm deep in the upper of two steps, whose pot 15 cm farther out would clear that step, and its leaves rest on it.
#[test]
fn what_is_on_a_step_is_not_hung_over_its_edge() {
    let mut boxes = Boxes::default();
    let steps = boxes.add("steps", GROUND, Vec3::new(0.6, 0.5, 0.4), DVec3::ZERO);
    boxes.objects[steps].movable = false;
    let lower = [Vec3::new(-0.3, 0.0, -0.2), Vec3::new(0.0, 0.25, 0.2)];
    boxes.carve(steps, &[lower, [Vec3::new(0.0, 0.0, -0.2), Vec3::new(0.3, 0.5, 0.2)]]);
    let plant = boxes.add("plant", Parent::Object(steps), Vec3::new(0.24, 0.3, 0.24), DVec3::new(0.1, 0.405, 0.0));
    let pot = [Vec3::new(-0.04, 0.0, -0.04), Vec3::new(0.04, 0.1, 0.04)];
    boxes.carve(plant, &[pot, [Vec3::new(-0.12, 0.1, -0.12), Vec3::new(0.12, 0.3, 0.12)]]);
    let outcome = simple(&boxes, &CpuBackend, &Config { seat: true, ..frozen() });
    let object = &outcome.objects[plant];
    assert!((boxes.foot(plant, object) - 0.5).abs() < 1e-3, "{object:?}");
    assert!(object.stable && (object.moved - 0.095).abs() < 2e-3, "{object:?}");
}

/// What lies on a board is thin enough, and what stands below it high enough, to be taken for a pile.
#[test]
fn what_is_on_a_board_is_not_piled_on_what_is_below_it() {
    for height in [0.19, 0.2, 0.215] {
        let mut boxes = Boxes::default();
        let cabinet = boxes.add("cabinet", GROUND, Vec3::new(0.8, 0.5, 0.4), DVec3::ZERO);
        let side = |x: f32| [Vec3::new(x - 0.01, 0.0, -0.2), Vec3::new(x + 0.01, 0.5, 0.2)];
        let board = |y: f32| [Vec3::new(-0.38, y, -0.2), Vec3::new(0.38, y + 0.02, 0.2)];
        boxes.carve(cabinet, &[side(-0.39), side(0.39), board(0.0), board(0.23)]);
        let parent = Parent::Object(cabinet);
        boxes.add("below", parent, Vec3::new(0.3, height, 0.2), DVec3::new(0.0, 0.02, 0.0));
        let book = boxes.add("book", parent, Vec3::new(0.2, 0.03, 0.15), DVec3::new(0.0, 0.25, 0.0));
        let outcome = simple(&boxes, &CpuBackend, &Config { seat: true, ..frozen() });
        let foot = boxes.foot(book, &outcome.objects[book]);
        assert!((foot - 0.25).abs() < 1e-3, "{foot} m high, over what is {height} m high");
        assert!(outcome.objects[book].stable, "{:?}", outcome.objects[book]);
    }
}

#[test]
fn what_stands_on_something_narrow_stays_where_it_is() {
    let mut boxes = Boxes::default();
    let beam = boxes.add("beam", GROUND, Vec3::new(0.015, 0.5, 0.4), DVec3::ZERO);
    boxes.objects[beam].movable = false;
    let cube = boxes.add("cube", Parent::Object(beam), Vec3::splat(0.05), DVec3::Y * 0.5);
    let config = Config { seat: true, ..frozen() };
    let outcome = simple(&boxes, &CpuBackend, &config);
    let object = &outcome.objects[cube];
    assert!(object.stable && !object.lost_support && object.moved < 1e-3, "{object:?}");
}

/// A block of 1 : 3 on its edge, past the 18° from which it falls over and past the 20° up to which it is taken for an
/// upright one: standing is 25° away, lying 65°. It stands if it does so with its other parts, too: not if their centre
/// of mass is 10 mm outside its foot.
#[test]
fn what_would_roll_is_set_down_in_the_nearest_pose_that_it_keeps() {
    let turned_to_rest = |off: f32| {
        let mut boxes = Boxes::default();
        let block = boxes.add("block", GROUND, Vec3::new(0.1, 0.3, 0.1), DVec3::ZERO);
        boxes.turn(block, 25.0_f64.to_radians(), DVec3::Y * 0.2);
        for Alternative { mass, .. } in &mut boxes.shapes[block].alternatives {
            mass.center += mass.axes * Vec3::X * off;
        }
        let config = Config { seat: true, second_opinion: false, ..frozen() };
        let outcome = simple(&boxes, &CpuBackend, &config);
        assert!(outcome.objects[block].stable, "{:?}", outcome.objects);
        outcome.objects[block].turned.to_degrees()
    };
    let (stood_up, lay_down) = (turned_to_rest(0.0), turned_to_rest(0.06));
    assert!((stood_up - 25.0).abs() < 0.5 && (lay_down - 65.0).abs() < 0.5, "{stood_up}° {lay_down}°");
}

#[test]
fn what_tumbles_is_fallen_and_unstable() {
    let boxes = room();
    let check = |config: &Config, angle: f32| -> ObjectOutcome {
        let backend = Fake { tumble: Some((3, Quat::from_rotation_x(angle))), ..Default::default() };
        simple(&boxes, &backend, config).objects[3].clone()
    };
    let mut unsettled = frozen();
    unsettled.settle.max_seconds = 0.0;
    // In the check alone. The angle is exact to f32 rounding.
    let chair = check(&unsettled, 0.6);
    assert!(chair.fallen && !chair.stable && chair.turned < 1e-6 && (chair.drift_turn - 0.6).abs() < 1e-6, "{chair:?}");
    let chair = check(&unsettled, 0.2);
    assert!(!chair.fallen && !chair.stable, "{chair:?}");
    let chair = check(&unsettled, 0.05);
    assert!(!chair.fallen && chair.stable, "{chair:?}");
    // While settling too.
    let chair = check(&frozen(), 0.55);
    assert!(chair.fallen && (chair.turned - 0.55).abs() < 1e-6, "{chair:?}");
}

/// A stand of 20 by 4 cm with rounded corners and a beam across it, whose common centre of mass is this far from the
/// middle (m): with four corners the stand ends 3 mm earlier, at 97 mm.
fn stand(center: f32) -> (Boxes, Outcome) {
    let mut boxes = Boxes::default();
    let stand = boxes.add("stand", GROUND, Vec3::splat(0.1), DVec3::ZERO);
    let corner =
        |k: usize| [Vec2::new(0.09, 0.01), Vec2::new(-0.09, 0.01), -Vec2::new(0.09, 0.01), Vec2::new(0.09, -0.01)][k];
    let around = (0..20).map(|i| corner(i / 5) + 0.01 * Vec2::from_angle(TAU * (i / 5 * 4 + i % 5) as f32 / 16.0));
    let foot = around.flat_map(|p| [0.0, 0.02].map(|y| Vec3::new(p.x, y, p.y))).collect();
    let at = |i: usize| Vec3::new((i & 1) as f32 - 0.5, (i >> 1 & 1) as f32, (i >> 2) as f32 - 0.5);
    let beam =
        |middle: f32| (0..8).map(|i| at(i) * Vec3::new(0.5, 0.02, 0.05) + Vec3::new(middle, 0.02, 0.0)).collect();
    let parts = |middle: f32| vec![Part { vertices: foot }, Part { vertices: beam(middle) }];
    let parts = parts(center / 0.759);
    let mass = MassProperties::of(&parts, 2.0);
    let shape = &mut boxes.shapes[stand];
    shape.alternatives = vec![Alternative { parts: parts.clone(), mass: mass.clone() }; 2];
    (shape.parts, shape.mass) = (parts, mass);
    boxes.objects[stand].pose = Pose::IDENTITY;
    let config = Config { second_opinion: false, ..frozen() };
    let outcome = simple(&boxes, &CpuBackend, &config);
    (boxes, outcome)
}

#[test]
fn parts_are_written_as_they_were_where_four_corners_would_not_do() {
    for (center, kept) in [(0.06, false), (0.0985, true)] {
        let (boxes, outcome) = stand(center);
        let found = boxes.shapes[0].mass.center.x;
        assert!((found - center).abs() < 2e-4, "the test is wrong: {found}");
        let object = &outcome.objects[0];
        assert!(object.stable && object.moved < 1e-3, "{object:?}");
        assert_eq!(outcome.parts[0] == boxes.shapes[0].parts, kept, "{} parts", outcome.parts[0].len());
    }
}
