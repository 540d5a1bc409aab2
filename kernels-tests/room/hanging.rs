//! What is on walls and ceiling, given or fitted, and what has no place there.

use crate::common::meshes::corners;
use crate::fixture::*;
use glam::{DVec3, Vec3};
use parry3d::math::Pose as Isometry;
use parry3d::query::contact;
use parry3d::shape::ConvexPolyhedron;
use rest3d_gpu::report::Summary;
use rest3d_gpu::scene::{Parent, Pose, Root, Scene};
use serde_json::json;

#[test]
fn what_hangs_touches_and_meets_nothing_at_any_angle() {
    for turn in [0.0, 0.52, -1.1, 2.9] {
        let ready = furnished(turn).with_room(2.5).done();
        let done = ready.run(&config());
        done.check();
        for name in ["picture", "clock", "shelf"] {
            assert!(done.askew(name, turn).abs() < 1e-3, "{name} is askew by {} at {turn}", done.askew(name, turn));
            assert!((done.pose(name).rotation * DVec3::Y).distance(DVec3::Y) < 1e-6, "{name} is plumb");
        }
        let cabinet = done.nearest_gap(ready.index("cabinet"));
        assert!((-SUNK..TOUCHES).contains(&cabinet), "the cabinet is {cabinet} m from its wall");
        // The lamp and the fan were in each other.
        let apart = done.pose("lamp").translation.distance(done.pose("fan").translation);
        assert!(apart > 0.6, "{apart}");
        let moved =
            ["picture", "clock", "shelf", "lamp", "fan"].map(|name| done.outcome.objects[ready.index(name)].moved);
        let summary = Summary::new(&ready.scene, &done.outcome);
        assert_eq!(summary.hung, moved.len());
        assert!((summary.mean_moved_hung - moved.iter().sum::<f64>() / 5.0).abs() < 1e-9, "{moved:?}");
        assert_eq!(summary.max_moved_hung, moved.into_iter().fold(0.0, f64::max));
        assert!(done.outcome.objects.iter().all(|object| object.stable && !object.lost_support));
    }
}

#[test]
fn books_ride_along_with_their_shelf_and_are_searched_there() {
    let ready = furnished(0.4).with_room(2.5).done();
    let done = ready.run(&config());
    let input = |name: &str| ready.scene.objects[ready.index(name)].pose;
    let moved = done.pose("shelf").translation.distance(input("shelf").translation);
    assert!(moved > 0.02, "a canary: the shelf is moved, by {moved}");
    let local = |shelf: Pose, book: Pose| shelf.rotation.conjugate() * (book.translation - shelf.translation);
    for name in ["book0", "book1", "book2"] {
        let (before, after) = (local(input("shelf"), input(name)), local(done.pose("shelf"), done.pose(name)));
        assert!(before.distance(after) < 0.02, "{name} has gone from {before} to {after}");
    }
    assert!(done.outcome.groups.iter().any(|group| group.name == "shelf" && group.units.len() == 3));
}

/// A bag on a coat stand that was reconstructed askew.
#[test]
fn what_hangs_on_something_is_set_upright_with_it() {
    let mut boxes = Boxes::new(0.0);
    boxes.add("stand", "ground", [0.4, 1.5, 0.4], [0.0, 0.78, 0.0], 0.0, -0.13);
    boxes.add("bag", "stand", [0.05, 0.3, 0.2], [0.226, 1.2, 0.0], 0.0, -0.13)["relation"] = "hanging".into();
    let ready = boxes.done();
    let done = ready.run(&config());
    let [stand, bag] = ["stand", "bag"].map(|name| done.pose(name));
    assert!((stand.rotation * DVec3::Y).y > 0.999, "{stand:?}");
    let local = |stand: Pose, bag: Pose| stand.rotation.conjugate() * (bag.translation - stand.translation);
    let [before, after] = [local(ready.scene.objects[0].pose, ready.scene.objects[1].pose), local(stand, bag)];
    assert!(before.distance(after) < 0.02, "from {before} to {after}");
    assert!((bag.rotation * DVec3::Y).y > 0.999, "{bag:?}");
}

#[test]
fn without_a_room_walls_follow_the_furniture() {
    for turn in [0.0, 0.52, -0.3] {
        let ready = furnished(turn).done();
        let done = ready.run(&config());
        done.check();
        for side in done.outcome.room.sides.iter().filter(|side| side.kind == Root::Wall) {
            assert!(side.fitted && !side.bears);
            let yaw = (side.normal.x.atan2(side.normal.z) - turn).rem_euclid(std::f64::consts::FRAC_PI_2);
            assert!(!(0.03..std::f64::consts::FRAC_PI_2 - 0.03).contains(&yaw), "{} is off by {yaw}", side.name);
            for i in 0..ready.scene.objects.len() {
                assert!(done.gap(i, side.point, side.normal) > -SUNK, "{} is through {}", i, side.name);
            }
        }
    }
}

/// What was reconstructed too far back takes nothing else there.
#[test]
fn a_fitted_wall_is_where_most_of_what_is_at_it_was() {
    let mut boxes = Boxes::new(0.6);
    boxes.add("table", "ground", [1.6, 0.7, 0.8], [0.0, 0.35, 0.5], 0.0, 0.0);
    let add = |boxes: &mut Boxes, name: &str, parent: &str, size: [f64; 3], x: f64, y: f64, back: f64| {
        boxes.add(name, parent, size, [x, y, -2.0 + back + 0.5 * size[2]], 0.0, 0.0);
    };
    add(&mut boxes, "cupboard", "ground-wall", [1.0, 1.8, 0.5], -1.6, 0.9, -0.15);
    add(&mut boxes, "chest", "ground-wall", [1.0, 0.6, 0.5], 0.0, 0.3, 0.04);
    add(&mut boxes, "bookcase", "ground-wall", [0.8, 1.5, 0.3], 1.5, 0.75, -0.01);
    add(&mut boxes, "picture", "wall", [0.8, 0.5, 0.03], 0.0, 1.5, 0.0);
    add(&mut boxes, "clock", "wall", [0.3, 0.3, 0.05], 1.5, 1.9, -0.03);
    let ready = boxes.done();
    let done = ready.run(&config());
    done.check();
    let [wall] = &done.outcome.room.sides[..] else { panic!("{:?}", done.outcome.room.sides) };
    assert!((wall.point.dot(wall.normal) + 2.0).abs() < 0.02, "{wall:?}");
    for name in ["cupboard", "chest", "bookcase"] {
        let gap = done.gap(ready.index(name), wall.point, wall.normal);
        assert!((-SUNK..TOUCHES).contains(&gap), "{name} is {gap} m from the wall");
    }
}

#[test]
fn a_wall_is_fitted_behind_what_is_held_too() {
    let mut boxes = Boxes::new(0.3);
    boxes.add("cabinet", "ground-wall", [1.4, 1.2, 0.5], [0.0, 0.6, -1.75], 0.0, 0.0)["movable"] = false.into();
    boxes.add("table", "ground", [1.6, 0.7, 0.8], [0.3, 0.35, 0.4], 0.0, 0.0);
    boxes.add("picture", "wall", [0.8, 0.5, 0.03], [0.2, 1.6, -1.9], 0.1, 0.0);
    let ready = boxes.done();
    let done = ready.run(&config());
    done.check();
    let side = &done.outcome.room.sides[0];
    assert!((done.gap(0, side.point, side.normal) - 0.5e-3).abs() < 1e-6, "{side:?}");
}

/// What was reconstructed behind the wall, or metres above the lamps, does not take what hangs there along.
#[test]
fn what_is_astray_moves_no_wall_and_no_ceiling() {
    for (turn, behind) in [(0.0, 0.6), (0.6, 1.0), (-0.4, 3.0)] {
        let mut boxes = Boxes::new(turn);
        boxes.add("table", "ground", [1.2, 0.7, 0.8], [0.0, 0.35, 0.0], 0.0, 0.0);
        boxes.add("desk", "ground", [1.2, 0.7, 0.6], [1.4, 0.35, 1.0], 0.0, 0.0);
        boxes.add("sideboard", "ground-wall", [1.0, 0.8, 0.4], [0.0, 0.4, -1.78], 0.0, 0.0);
        boxes.add("picture", "wall", [0.6, 0.5, 0.03], [0.0, 1.5, -1.985], 0.0, 0.0);
        boxes.add("mirror", "wall", [0.5, 0.7, 0.03], [1.0, 1.6, -1.985], 0.0, 0.0);
        boxes.add("lamp", "ceiling", [0.3, 0.3, 0.3], [0.0, 2.35, 0.4], 0.0, 0.0)["relation"] = "hanging".into();
        boxes.add("fan", "ceiling", [0.8, 0.2, 0.8], [1.4, 2.4, 1.0], 0.0, 0.0)["relation"] = "hanging".into();
        boxes.add("stray", "ground", [0.2, 0.2, 0.2], [0.8, 0.1, -2.0 - behind], 0.0, 0.0);
        boxes.add("cup", "desk", [0.1, 0.1, 0.1], [1.7, 9.0, 1.1], 0.0, 0.0);
        let ready = boxes.done();
        let done = ready.run(&config());
        let walls: Vec<_> = done.outcome.room.sides.iter().filter(|side| side.kind == Root::Wall).collect();
        let [back] = walls[..] else { panic!("{walls:?}") };
        assert!((back.point.dot(back.normal) + 2.0).abs() < 0.05, "{behind} m behind: {back:?}");
        for name in ["picture", "mirror", "lamp", "fan"] {
            let moved = done.outcome.objects[ready.index(name)].moved;
            assert!(moved < 0.1, "{behind} m behind: {name} is moved by {moved} m");
        }
        let told = format!("stray: reaches {:.2} m through the wall \"{}\"", behind + 0.1, back.name);
        assert!(done.outcome.notes.contains(&told), "{told}: {:?}", done.outcome.notes);
    }
}

/// As many behind it as on it are no strays: then the wall is behind them.
#[test]
fn what_most_objects_say_moves_the_wall() {
    let mut boxes = Boxes::new(0.0);
    boxes.add("table", "ground", [1.2, 0.7, 0.8], [0.0, 0.35, 0.5], 0.0, 0.0);
    boxes.add("picture", "wall", [0.6, 0.5, 0.03], [0.0, 1.5, -1.5], 0.0, 0.0);
    boxes.add("chest", "ground", [1.0, 0.6, 0.5], [1.5, 0.3, -1.9], 0.0, 0.0);
    boxes.add("stool", "ground", [0.4, 0.5, 0.4], [-1.5, 0.25, -1.9], 0.0, 0.0);
    let ready = boxes.done();
    let done = ready.run(&config());
    let [wall] = &done.outcome.room.sides[..] else { panic!("{:?}", done.outcome.room.sides) };
    assert!((wall.point.z + 2.15).abs() < 0.02, "{wall:?}");
    let note = &done.outcome.notes.iter().find(|note| note.starts_with("picture: on the wall"));
    assert!(note.is_some_and(|note| note.contains("was 0.6")), "{:?}", done.outcome.notes);
}

#[test]
fn what_cannot_be_placed_well_is_said() {
    let mut boxes = furnished(0.2).with_room(2.0);
    boxes.add("screen", "wall", [0.8, 0.5, 0.03], [1.6, 0.9, -1.6], 0.6, 0.0);
    boxes.add("mirror", "wall", [0.4, 0.8, 0.03], [1.3, 1.2, -0.8], 0.0, 0.0);
    boxes.add("hook", "wall", [0.05, 0.05, 0.05], [2.2, 1.2, 1.5], 0.1, 0.0)["movable"] = false.into();
    boxes.add("pole", "ground", [0.3, 2.2, 0.3], [1.5, 1.1, 1.5], 0.0, 0.0);
    let walls = boxes.room.as_mut().unwrap()["walls"].as_array_mut().unwrap();
    walls.push(json!({"name": "floor", "point": [0.0, 0.0, 0.0], "normal": [0.0, 1.0, 0.2]}));
    let ready = boxes.done();
    let done = ready.run(&config());
    let notes = &done.outcome.notes;
    assert!(notes.iter().any(|note| note.contains("floor: left out, because its normal points up")), "{notes:?}");
    assert!(done.note("screen").contains("not turned"), "{}", done.note("screen"));
    assert!(done.note("mirror").contains("was 1.1"), "{}", done.note("mirror"));
    assert!(done.note("hook").contains("not movable"), "{}", done.note("hook"));
    assert_eq!(done.pose("hook"), ready.scene.objects[ready.index("hook")].pose);
    assert!(done.outcome.notes.iter().any(|note| note.contains("pole: reaches 0.2")), "{:?}", done.outcome.notes);
    let far = done.outcome.notes.iter().any(|note| note.starts_with("mirror: on the wall \"wall 1\" (was 1.1"));
    assert!(far, "{:?}", done.outcome.notes);
    // Nothing that hangs is higher than the ceiling.
    done.check();
    let high = |i: usize| corners(done.placed(i)).iter().map(|p| p.y).fold(0.0, f64::max);
    assert!((0..ready.scene.objects.len()).all(|i| high(i) < 2.0 || ready.scene.objects[i].name == "pole"));
}

#[test]
fn what_has_no_place_on_its_wall_stands_off_it() {
    let mut boxes = Boxes::new(0.0).with_room(2.5);
    // A cupboard from wall to wall, up to the ceiling.
    boxes.add("cupboard", "ground", [4.9, 2.45, 0.3], [0.0, 1.225, -1.84], 0.0, 0.0)["movable"] = false.into();
    boxes.add("picture", "wall", [0.8, 0.5, 0.03], [0.2, 1.5, -1.9], 0.0, 0.0);
    let ready = boxes.done();
    let done = ready.run(&config());
    done.check_apart();
    let gap = done.gap(1, DVec3::NEG_Z * 2.0, DVec3::Z);
    assert!((0.31..0.33).contains(&gap), "{gap}");
    assert!(done.note("picture").contains("no free place"), "{}", done.note("picture"));
    assert!(done.outcome.notes.iter().any(|note| note.contains("picture")));
}

#[test]
#[cfg_attr(not(shared_files), ignore = "needs ../shared")]
fn the_test_room_has_everything_in_its_place() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes/wall_ceiling");
    let ready = Ready::new(Scene::read(&folder).unwrap());
    let done = ready.run(&config());
    done.check();
    assert_eq!(done.outcome.clearances.overlaps, []);
    let parts = |i: usize| {
        let pose = done.outcome.objects[i].pose;
        let place = move |v: &Vec3| (pose.translation + pose.rotation * v.as_dvec3()).as_vec3();
        ready.shapes[i].parts.iter().map(move |part| {
            ConvexPolyhedron::from_convex_hull(&part.vertices.iter().map(place).collect::<Vec<_>>()).unwrap()
        })
    };
    let here = Isometry::IDENTITY;
    let bearing = done.outcome.room.sides.iter().filter(|side| side.bears);
    assert!(bearing.clone().count() > 0);
    for side in bearing {
        for (i, object) in ready.scene.objects.iter().enumerate() {
            assert!(done.gap(i, side.point, side.normal) > -SUNK, "{} is through {}", object.name, side.name);
        }
    }
    // What hangs is clear of everything else by its parts, too.
    let hung = |i: &usize| matches!(ready.scene.objects[*i].parent, Parent::Root(Root::Wall | Root::Ceiling));
    for i in (0..ready.scene.objects.len()).filter(hung) {
        for j in (0..i).filter(|&j| ready.scene.objects[j].parent != Parent::Object(i)) {
            for (a, b) in parts(i).flat_map(|a| parts(j).map(move |b| (a.clone(), b))) {
                let depth = contact(&here, &a, &here, &b, 0.0).unwrap().map_or(0.0, |contact| -contact.dist);
                assert!(depth < 1e-3, "{} and {}", ready.scene.objects[i].name, ready.scene.objects[j].name);
            }
        }
    }
}
