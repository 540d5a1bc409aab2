//! Odd but valid scenes give a result.

use crate::fixture::*;
use serde_json::{Value, json};
use std::fs;

#[test]
fn a_scene_without_movable_objects_is_done_at_once() {
    let mut input = scene(vec![
        cuboid("shelf", "wall", [0.0, 1.0, 0.0], [0.5, 0.1, 0.2]),
        cuboid("stove", "ground", [1.0, 0.4, 0.0], [0.5, 0.8, 0.5]),
    ]);
    input["objects"][1]["movable"] = json!(false);
    let case = Case::new(&input);
    let report = case.report(&[]);
    assert_eq!(report["summary"]["simulated"], 0);
    assert!(report["notes"].to_string().contains("movable"), "{}", report["notes"]);
    let scene: Value = serde_json::from_slice(&fs::read(case.path("out/scene.json")).unwrap()).unwrap();
    for i in 0..2 {
        assert_eq!(scene["objects"][i]["position"], input["objects"][i]["position"]);
    }
}

#[test]
fn a_single_object_is_put_on_the_ground() {
    let case = Case::new(&scene(vec![cuboid("box", "ground", [0.3, 0.12, 0.0], [0.2, 0.2, 0.2])]));
    let report = case.report(&TINY);
    assert_eq!(report["summary"]["stable"], 1);
    let scene: Value = serde_json::from_slice(&fs::read(case.path("out/scene.json")).unwrap()).unwrap();
    let height = scene["objects"][0]["position"][1].as_f64().unwrap();
    // Half its height, to within the simulator's slop of 0.1 mm and the compliance of a contact.
    assert!((height - 0.1).abs() < 5e-4, "{height}");
}

#[test]
fn objects_at_the_same_place_give_a_result() {
    let objects = (0..8).map(|i| cuboid(&format!("box {i}"), "ground", [0.0, 0.1, 0.0], [0.2, 0.2, 0.2])).collect();
    let report = Case::new(&scene(objects)).report(&TINY);
    assert_eq!(report["summary"]["simulated"], 8);
}

#[test]
fn objects_far_below_the_ground_give_a_result() {
    let objects = (0..3)
        .map(|i| cuboid(&format!("box {i}"), "ground", [f64::from(i), -40.0 - f64::from(i), 0.0], [0.2, 0.2, 0.2]));
    let report = Case::new(&scene(objects.collect())).report(&TINY);
    assert_eq!(report["summary"]["simulated"], 3);
}

#[test]
fn a_mesh_of_one_triangle_gives_a_result() {
    let case = Case::new(&scene(vec![json!({"name": "flake", "mesh": "flake.obj", "position": [0, 0.05, 0]})]));
    fs::write(case.path("flake.obj"), "v 0 0 0\nv 0.3 0 0\nv 0 0 0.2\nf 1 2 3\n").unwrap();
    let report = case.report(&TINY);
    assert!(report["objects"][0]["notes"].to_string().contains("thick"), "{}", report["objects"][0]);
}

/// Deeper in it than what is set onto something is shifted otherwise: beside it, it would have lost its support.
#[test]
fn what_a_closed_box_swallows_is_set_onto_it() {
    for relation in ["inside", "on"] {
        let mut ring = cuboid("ring", "chest", [0.02, 0.8, 0.03], [0.05, 0.05, 0.05]);
        ring["relation"] = json!(relation);
        let chest = cuboid("chest", "ground", [0.0, 0.55, 0.0], [0.4, 1.1, 0.3]);
        let report = Case::new(&scene(vec![chest, ring])).report(&TINY);
        assert_eq!(report["summary"]["support_violations"], 0, "{}", report["summary"]);
        let moved = report["objects"][1]["moved"].as_f64().unwrap();
        assert!((moved - 0.325).abs() < 0.01, "{moved}");
        assert!(report["notes"].to_string().contains("\\\"ring\\\" (0.3"), "{}", report["notes"]);
    }
}

#[test]
fn two_hundred_objects_give_a_result_and_the_memory_is_told() {
    let objects = (0..200).map(|i| {
        let place = [f64::from(i % 20) * 0.5, 0.12, f64::from(i / 20) * 0.5];
        cuboid(&format!("box {i}"), "ground", place, [0.2, 0.2, 0.2])
    });
    let case = Case::new(&scene(objects.collect()));
    let output = case.optimize("out", &["--candidates", "4", "--iterations", "1", "--json"]);
    let messages = text(&output.stderr);
    assert!(output.status.success(), "{messages}");
    assert!(messages.contains("200 bodies") && messages.contains("MB"), "{messages}");
}
