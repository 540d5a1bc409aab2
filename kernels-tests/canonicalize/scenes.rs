//! What is turned, raised and left alone.

use crate::fixture::*;
use glam::{DQuat, DVec3};
use rest3d_gpu::canonicalize::canonicalize;
use rest3d_gpu::scene::{Pose, Scene};
use std::f64::consts::FRAC_PI_2;

#[test]
fn a_tilt_is_taken_back() {
    let things = room();
    for (direction, degrees) in [(0.3, 2.5), (2.0, 8.0), (-1.2, 20.0), (4.0, 35.0)] {
        let change = Pose { rotation: tilt(direction, degrees), translation: DVec3::new(3.0, -1.2, 0.7) };
        let (scene, report) = Case::new(&things, change).canonical();
        assert!((report.tilt_degrees - degrees).abs() < 0.01, "{degrees}° taken for {}°", report.tilt_degrees);
        assert!((report.rotation.degrees - degrees).abs() < 0.01);
        assert!(report.warning().unwrap().contains("tilted"));
        assert_restored(&scene, &things, 1e-5);
        assert!(scene.room.walls[0].normal.y.abs() < 1e-5);
        let clock = by_name(&scene, "clock").translation;
        assert!(((clock - scene.room.walls[0].point).dot(scene.room.walls[0].normal) - 0.1).abs() < 1e-5);
    }
}

#[test]
fn errors_of_single_objects_do_not_tilt_the_scene() {
    let mut things = room();
    let lean = |things: &mut [Thing], name: &str, turn: DQuat| {
        let thing = things.iter_mut().find(|thing| thing.name == name).unwrap();
        thing.pose.rotation = turn * thing.pose.rotation;
    };
    lean(&mut things, "crate", tilt(1.0, 22.0));
    lean(&mut things, "chair", tilt(0.0, 180.0));
    lean(&mut things, "second crate", tilt(0.8, 90.0));
    lean(&mut things, "tin", tilt(2.0, 14.0));
    let (scene, report) =
        Case::new(&things, Pose { rotation: tilt(1.0, 12.0), translation: DVec3::Y * 0.4 }).canonical();
    let found = DQuat::from_axis_angle(DVec3::from(report.rotation.axis), report.rotation.degrees.to_radians());
    let error = (found * tilt(1.0, 12.0) * DVec3::Y).angle_between(DVec3::Y).to_degrees();
    assert!(error < 0.5, "the vertical is wrong by {error}°");
    for name in ["crate", "tin", "desk", "shelf"] {
        assert!(up(by_name(&scene, name)).angle_between(DVec3::Y) < 1e-6, "{name} leans");
    }
    // What lies on its side keeps lying; a chair on its backrest is put on its legs.
    assert!(up(by_name(&scene, "second crate")).y.abs() < 1e-6);
    assert!(up(by_name(&scene, "chair")).y > 0.999, "{:?}", report.objects[1]);
    assert!(report.objects[1].why_turned.contains("upside down"), "{:?}", report.objects[1]);
}

#[test]
fn what_leans_on_a_wall_keeps_leaning() {
    let lean = tilt(FRAC_PI_2, 15.0);
    let mut things = room();
    // A picture, 3 cm deep and 20 cm high, would fall over; a crate was reconstructed so.
    things.push(thing("picture", "book", [0.8, 0.0, -1.9], 0.0, "ground-wall"));
    things.push(thing("crate at the wall", "crate", [-0.8, 0.0, -1.9], 0.0, "ground-wall"));
    let [.., picture, at_wall] = &mut things[..] else { unreachable!() };
    picture.pose.rotation = lean * DQuat::from_rotation_z(FRAC_PI_2);
    at_wall.pose.rotation = lean;
    let (scene, report) =
        Case::new(&things, Pose { rotation: tilt(1.0, 9.0), translation: DVec3::Y * 0.2 }).canonical();
    let picture = by_name(&scene, "picture").rotation * DVec3::X;
    assert!((picture.angle_between(DVec3::Y).to_degrees() - 15.0).abs() < 0.5, "{picture}");
    assert!(report.objects[things.len() - 2].why_turned.contains("leans on its wall"), "{report}");
    assert!(up(by_name(&scene, "crate at the wall")).angle_between(DVec3::Y) < 1e-6);
}

#[test]
fn what_stands_well_upside_down_is_only_reported() {
    let mut things = room();
    things[3].pose.rotation = tilt(0.0, 180.0) * things[3].pose.rotation;
    let (scene, report) = Case::new(&things, Pose::IDENTITY).canonical();
    assert!(up(by_name(&scene, "crate")).y < -0.999);
    assert!(report.objects[3].why_turned.contains("upside down"), "{:?}", report.objects[3]);
    assert!(report.to_string().contains("crate: upside down"), "{report}");
}

#[test]
fn objects_rest_on_the_surface_under_them() {
    let things = room();
    // Floating and sunk, each less than half way to the next surface.
    for (name, error) in [
        ("tin", 0.05),
        ("tin", -0.06),
        ("tin below", 0.1),
        ("tin below", -0.02),
        ("tin above", 0.15),
        ("tin above", -0.06),
        ("book", 0.1),
        ("book", -0.025),
        ("shelf book", 0.12),
        ("shelf book", -0.1),
        ("desk", 0.3),
        ("shelf", -0.2),
        ("chair", 0.04),
    ] {
        let mut moved = room();
        let thing = moved.iter_mut().find(|thing| thing.name == name).unwrap();
        thing.pose.translation.y += error;
        // What stands on it was reconstructed with it.
        for child in moved.iter_mut().filter(|thing| thing.parent == name) {
            child.pose.translation.y += error;
        }
        let (scene, _) = Case::new(&moved, Pose::IDENTITY).canonical();
        assert_restored(&scene, &things, 1e-5);
    }
}

#[test]
fn a_leaning_bearer_takes_its_children_along() {
    let mut things = room();
    let lean = tilt(0.5, 9.0);
    let center = things[0].pose.translation + DVec3::Y * 0.6;
    for i in [0, 5, 6, 7] {
        let pose = &mut things[i].pose;
        *pose = Pose { rotation: lean * pose.rotation, translation: center + lean * (pose.translation - center) };
    }
    let (scene, _) = Case::new(&things, Pose::IDENTITY).canonical();
    let known = room();
    let offset = by_name(&scene, "desk").translation - known[0].pose.translation;
    for i in [5, 6, 7] {
        let object = &scene.objects[i];
        let off = object.pose.translation - known[i].pose.translation - offset;
        assert!(off.length() < 1e-5 && up(&object.pose).y > 1.0 - 1e-9, "{}: {off}", object.name);
    }
}

#[test]
fn what_is_fixed_only_follows() {
    let mut things = room();
    for i in [11, 12, 13] {
        things[i].pose.rotation = tilt(0.4, 7.0) * things[i].pose.rotation;
        things[i].pose.translation.y += 0.03;
    }
    let change = Pose { rotation: tilt(2.0, 10.0), translation: DVec3::new(0.0, 0.8, 0.0) };
    let (scene, report) = Case::new(&things, change).canonical();
    // Their places among each other and towards the floor are as they came; the crate tells where the floor went.
    let crate_up = by_name(&scene, "crate").translation.y;
    assert!(crate_up.abs() < 1e-6);
    for i in [11, 12, 13] {
        assert!(up(&scene.objects[i].pose).angle_between(DVec3::Y) > 0.1, "{}", things[i].name);
        assert!(report.objects[i].turned_degrees == 0.0 && report.objects[i].raised == 0.0);
        let from = |poses: &dyn Fn(usize) -> Pose| poses(i).translation.distance(poses(11).translation);
        let (now, known) = (from(&|i| scene.objects[i].pose), from(&|i| things[i].pose));
        assert!((now - known).abs() < 1e-6, "{}", things[i].name);
    }
}

/// Small errors of every object, the same for the same number.
fn disturb(things: &mut [Thing]) {
    let any = |i: usize, k: usize| ((i * 61 + k * 5) as f64 * 12.9898).sin() * 43758.547 % 1.0;
    for (i, thing) in things.iter_mut().enumerate() {
        let lean =
            DQuat::from_axis_angle(DVec3::new(any(i, 1), 0.2 * any(i, 2), any(i, 3)).normalize(), 0.08 * any(i, 4));
        thing.pose.rotation = lean * thing.pose.rotation;
        thing.pose.translation += 0.02 * DVec3::new(any(i, 5), any(i, 6), any(i, 7));
    }
}

#[test]
fn a_canonical_scene_stays_as_it_is() {
    for degrees in [0.0, 0.7, 6.0, 30.0] {
        let mut things = room();
        disturb(&mut things);
        let case = Case::new(&things, Pose { rotation: tilt(1.1, degrees), translation: DVec3::new(0.5, 2.0, -1.0) });
        let (mut scene, meshes) = case.read();
        canonicalize(&mut scene, &meshes);
        let first: Vec<Pose> = scene.objects.iter().map(|object| object.pose).collect();
        let again = canonicalize(&mut scene, &meshes);
        assert!(again.warning().is_none() && again.rotation.degrees == 0.0, "{again}");
        for (object, before) in scene.objects.iter().zip(first) {
            let moved = object.pose.translation.distance(before.translation);
            let turned = object.pose.rotation.angle_between(before.rotation);
            assert!(moved < 1e-4 && turned < 1e-4, "{} at {degrees}°: {moved} m, {turned} rad", object.name);
        }
    }
}

#[test]
fn another_yaw_and_place_of_the_input_gives_the_same_scene_there() {
    let mut things = room();
    disturb(&mut things);
    let change = Pose { rotation: tilt(1.1, 6.0), translation: DVec3::ZERO };
    let (scene, _) = Case::new(&things, change).canonical();
    let yaw = DQuat::from_rotation_y(2.2);
    let moved = Pose { rotation: yaw * change.rotation, translation: DVec3::new(4.0, 0.9, -2.0) };
    let (there, _) = Case::new(&things, moved).canonical();
    let origin = |scene: &Scene| scene.objects[0].pose.translation;
    for (a, b) in scene.objects.iter().zip(&there.objects) {
        let expected = origin(&there) + yaw * (a.pose.translation - origin(&scene));
        // Heights are found on a grid in x and z: half a millimetre between one lean and another.
        assert!(expected.distance(b.pose.translation) < 1e-3, "{}: {expected} {:?}", a.name, b.pose);
        assert!((yaw * a.pose.rotation).angle_between(b.pose.rotation) < 1e-4, "{}", a.name);
    }
}

#[test]
fn a_scene_without_evidence_is_left_alone() {
    let (scene, report) = Case::new(&[], Pose::IDENTITY).canonical();
    assert!(scene.objects.is_empty() && report.votes == 0 && report.warning().is_none());
    let lamp = [thing("lamp", "tin", [0.0, 2.0, 0.0], 0.0, "ceiling")];
    let (scene, _) = Case::new(&lamp, Pose { rotation: tilt(0.0, 20.0), translation: DVec3::Y }).canonical();
    assert!((up(&scene.objects[0].pose).angle_between(DVec3::Y) - 20_f64.to_radians()).abs() < 1e-9);
}
