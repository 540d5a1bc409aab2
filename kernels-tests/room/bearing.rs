//! Walls that bear, and what leans on them.

use crate::fixture::*;
use glam::{DQuat, DVec3};
use rest3d_gpu::optimize::Config;
use rest3d_gpu::scene::Root;

#[test]
fn furniture_is_brought_inside_and_stays_there() {
    let mut boxes = Boxes::new(0.7).with_room(2.5);
    boxes.add("desk", "ground", [1.2, 0.7, 0.6], [0.0, 0.35, -1.8], 0.1, 0.0);
    boxes.add("cup", "desk", [0.1, 0.1, 0.1], [0.0, 0.75, -1.97], 0.1, 0.0);
    boxes.add("chest", "ground", [0.5, 0.5, 0.5], [2.3, 0.25, 0.5], 0.0, 0.0);
    let ready = boxes.done();
    let done = ready.run(&config());
    let walls = done.outcome.room.sides.iter().filter(|side| side.kind == Root::Wall);
    assert_eq!(walls.clone().count(), 3);
    for side in walls {
        assert!(side.bears);
        for (i, object) in ready.scene.objects.iter().enumerate() {
            let gap = done.gap(i, side.point, side.normal);
            assert!(gap > -SUNK, "{} is {gap} m from {}", object.name, side.name);
        }
    }
    assert!(done.outcome.objects.iter().all(|object| object.stable && !object.lost_support));
}

/// Of a bed with its head at the back wall the middle is nearer to the wall at its side.
#[test]
fn what_stands_at_a_wall_keeps_its_wall() {
    let mut boxes = Boxes::new(0.3).with_room(2.5);
    boxes.add("bed", "ground-wall", [0.9, 0.5, 2.0], [-1.6, 0.25, -0.96], 0.05, 0.0);
    // About as far from two walls it belongs to the one that its back is along.
    boxes.add("bookcase", "ground-wall", [0.8, 1.8, 0.3], [2.07, 0.9, -1.8], 0.0, 0.0);
    let ready = boxes.done();
    let done = ready.run(&config());
    for name in ["bed", "bookcase"] {
        let (i, back) = (ready.index(name), &done.outcome.room.sides[0]);
        assert!((-SUNK..TOUCHES).contains(&done.gap(i, back.point, back.normal)), "{name} is not at the back wall");
        assert!(done.outcome.objects[i].moved < 0.07, "{name}: {:?}", done.outcome.objects[i]);
    }
}

/// A long sideboard was reconstructed askew. What stands on its ends was seen for itself, and stays where it was seen.
#[test]
fn what_furniture_bears_does_not_turn_with_it_to_the_wall() {
    let mut boxes = Boxes::new(0.4).with_room(2.5);
    boxes.add("sideboard", "ground-wall", [1.8, 0.6, 0.5], [0.0, 0.32, -1.74], 0.15, 0.02);
    boxes.add("vase", "sideboard", [0.1, 0.2, 0.1], [0.75, 0.68, -1.74], 0.0, 0.0);
    boxes.add("tin", "sideboard", [0.12, 0.15, 0.08], [-0.75, 0.72, -1.74], 0.0, 0.03);
    let ready = boxes.done();
    let done = ready.run(&config());
    let yaw = done.outcome.placements[0].as_ref().unwrap().yaw;
    assert!((yaw + 0.15).abs() < 0.02, "the sideboard was turned by {yaw}");
    for name in ["vase", "tin"] {
        let (i, was) = (ready.index(name), ready.scene.objects[ready.index(name)].pose);
        let now = done.pose(name);
        let aside = (now.translation - was.translation).with_y(0.0).length();
        assert!(aside < 0.02, "{name} was moved by {aside} m");
        assert!(now.rotation.angle_between(was.rotation) < 0.06, "{name} was turned");
        assert!(done.outcome.objects[i].stable && !done.outcome.objects[i].lost_support, "{name}");
    }
}

#[test]
fn a_wall_in_the_middle_of_the_furniture_bears_nothing() {
    let mut boxes = Boxes::new(0.0).with_room(2.5);
    boxes.add("table", "ground", [1.6, 0.7, 0.8], [0.0, 0.35, -2.1], 0.0, 0.0);
    let ready = boxes.done();
    let done = ready.run(&config());
    assert!(done.outcome.objects[0].moved < 0.01, "{}", done.outcome.objects[0].moved);
    assert!(done.outcome.notes.iter().any(|note| note.contains("wall 1")), "{:?}", done.outcome.notes);
}

#[test]
fn what_leans_needs_its_wall_and_keeps_leaning() {
    let leaning = |boxes: &mut Boxes| {
        boxes.add("mattress", "ground-wall", [1.4, 2.0, 0.2], [0.0, 1.0, -1.6], 0.03, -0.26);
        boxes.add("picture", "ground-wall", [0.6, 0.8, 0.03], [1.5, 0.4, -1.85], 0.0, -0.2);
        boxes.add("chest", "ground", [1.0, 0.5, 0.5], [0.0, 0.25, 0.5], 0.0, 0.0);
    };
    let (mut given, mut implied) = (Boxes::new(0.4).with_room(2.5), Boxes::new(0.4));
    leaning(&mut given);
    leaning(&mut implied);
    for boxes in [given, implied] {
        let ready = boxes.done();
        let done = ready.run(&config());
        for name in ["mattress", "picture"] {
            let outcome = &done.outcome.objects[ready.index(name)];
            assert!(outcome.stable && !outcome.fallen && !outcome.lost_support, "{name}: {outcome:?}");
            assert!(outcome.turned < 0.12, "{name} leans as it did, but for {} rad", outcome.turned);
            assert!((-SUNK..TOUCHES).contains(&done.nearest_gap(ready.index(name))), "{name}");
        }
        let told = done.outcome.notes.iter().find(|note| note.contains("leans"));
        assert!(told.is_some_and(|note| note.contains("mattress, picture; ")), "{:?}", done.outcome.notes);
        let alone = ready.run(&Config { room: false, ..config() });
        let fallen =
            alone.outcome.objects.iter().filter(|object| object.fallen || !object.stable || object.turned > 0.15);
        assert!(fallen.count() >= 2, "a canary: without a wall they do not stay");
    }
}

/// How far the up axis of an object leans towards the back wall of a room turned by `turn`, and sideways.
fn leans(done: &Done<'_>, name: &str, turn: f64) -> [f64; 2] {
    let up = DQuat::from_rotation_y(-turn) * (done.pose(name).rotation * DVec3::Y);
    [-up.z, up.x.abs()]
}

/// On a rug, and however crooked it was reconstructed.
#[test]
fn what_leans_does_so_squarely_and_on_what_is_below_it() {
    let turn = 0.4;
    for (rug, yaw, sideways) in [(true, 0.0, 0.0), (false, 0.17, 0.0), (false, -0.09, 0.05), (true, 0.0, 0.087)] {
        let mut boxes = Boxes::new(turn).with_room(2.5);
        if rug {
            boxes.add("rug", "ground", [1.6, 0.008, 1.2], [0.0, 0.004, -1.35], 0.0, 0.0);
        }
        let crooked =
            DQuat::from_rotation_y(turn + yaw) * DQuat::from_rotation_z(sideways) * DQuat::from_rotation_x(-0.23);
        for (name, width, x) in [("door", 0.9, 0.0), ("plank", 0.1, 1.2)] {
            let added = boxes.add(name, "ground-wall", [width, 2.0, 0.04], [x, 1.0, -1.66], 0.0, 0.0);
            added["rotation_xyzw"] = crooked.to_array().to_vec().into();
        }
        let ready = boxes.done();
        let done = ready.run(&config());
        for name in ["door", "plank"] {
            let (outcome, [back, aside]) = (&done.outcome.objects[ready.index(name)], leans(&done, name, turn));
            assert!((0.17..0.25).contains(&back) && aside < 0.02, "{name}: {back}, {aside} with {yaw}, {sideways}");
            assert!(outcome.stable && outcome.stable_otherwise && outcome.moved < 0.15, "{name}: {outcome:?}");
        }
        let told = done.outcome.notes.iter().any(|note| note.contains("leans: door, plank; "));
        assert!(told, "{:?}", done.outcome.notes);
    }
}

#[test]
fn what_is_too_thin_to_stand_leans_on_its_wall_not_on_the_sofa() {
    for (given, lean) in [(true, 0.0), (false, 0.0), (true, -0.1), (false, -0.12), (true, 0.05)] {
        let mut boxes = Boxes::new(0.0);
        if given {
            boxes = boxes.with_room(2.5);
        }
        boxes.add("sofa", "ground", [1.8, 0.8, 0.8], [0.0, 0.4, -1.4], 0.0, 0.0);
        boxes.add("plank", "ground-wall", [0.2, 1.8, 0.03], [0.3, 0.9, -1.93], 0.0, lean);
        let ready = boxes.done();
        let done = ready.run(&config());
        let (outcome, [back, _]) = (&done.outcome.objects[1], leans(&done, "plank", 0.0));
        assert!((0.05..0.15).contains(&back) && outcome.moved < 0.12, "{back}, {outcome:?}");
        assert!(outcome.stable && outcome.stable_otherwise, "{outcome:?}");
    }
}

/// Of two things at a wall that nobody gave the one behind is not pushed through it into the room.
#[test]
fn a_wall_is_fitted_behind_the_farther_of_two() {
    let mut boxes = Boxes::new(0.0);
    boxes.add("bookcase", "ground-wall", [0.9, 1.8, 0.3], [-1.0, 0.9, -1.85], 0.0, 0.0);
    boxes.add("door", "ground-wall", [0.9, 2.0, 0.04], [0.6, 1.0, -1.36], 0.0, -0.23);
    let ready = boxes.done();
    let done = ready.run(&config());
    assert!(done.outcome.objects[0].moved < 0.01, "{:?}", done.outcome.objects[0]);
    assert!(done.outcome.objects[1].stable && leans(&done, "door", 0.0)[0] > 0.17, "{:?}", done.outcome.objects[1]);
}

/// What the search left against a given wall, though nobody said that it leans there, falls in every engine that knows
/// objects only.
#[test]
fn what_leans_by_chance_is_set_up_again() {
    let mut boxes = Boxes::new(0.4).with_room(2.5);
    boxes.add("cabinet", "ground", [0.4, 1.0, 0.4], [0.0, 0.537, -1.6], 0.0, -0.45);
    let ready = boxes.done();
    let as_it_is = Config { seat: false, second_opinion: false, ..config() };
    let left = &ready.run(&as_it_is).outcome.objects[0];
    assert!(left.turned < 0.3 && !left.stable, "it leans on, and that is said: {left:?}");
    let up = &ready.run(&Config { second_opinion: true, ..as_it_is }).outcome.objects[0];
    assert!(up.stable && up.stable_otherwise && !up.fallen, "{up:?}");
}
