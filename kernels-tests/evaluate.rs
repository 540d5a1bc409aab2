//! `evaluate`: metrics of scenes of boxes, whose values are known.
#![allow(clippy::unwrap_used)]

mod common;

use common::meshes::CUBE;
use common::program::program;
use glam::{DQuat, DVec3};
use image::{GrayImage, Luma};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use tempfile::TempDir;

/// A folder of scenes around one mesh.
struct Case {
    folder: TempDir,
}

impl Case {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("cube.obj"), CUBE).unwrap();
        Self { folder }
    }

    /// Writes a scene of cubes, each a name, a position, a turn about y and a size.
    fn scene(&self, name: &str, cubes: &[(&str, [f64; 3], f64, [f64; 3])]) -> PathBuf {
        let objects: Vec<Value> = cubes
            .iter()
            .map(|(name, position, turn, size)| {
                let rotation = DQuat::from_rotation_y(*turn).to_array();
                json!({
                    "name": name, "mesh": "cube.obj", "position": position, "rotation_xyzw": rotation, "scale": size
                })
            })
            .collect();
        let path = self.folder.path().join(name);
        fs::write(&path, json!({"format": "rest3d-scene", "version": 1, "objects": objects}).to_string()).unwrap();
        path
    }

    fn run(&self, arguments: &[&Path]) -> Output {
        program().arg("evaluate").args(arguments).args(["--json", "--backend", "cpu"]).output().unwrap()
    }

    fn metrics(&self, arguments: &[&Path]) -> Value {
        let output = self.run(arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

const SIZE: [f64; 3] = [0.2; 3];

#[test]
fn collisions_have_the_depth_of_the_overlap() {
    let case = Case::new();
    // One beside the other along x: overlapping by 5 mm, by 0.5 mm, touching in f64, and 10 µm apart.
    for (gap, strict, deep) in [(-5e-3, 2, 2), (-5e-4, 2, 0), (1e-5, 0, 0), (0.1, 0, 0)] {
        let scene =
            case.scene("a.json", &[("a", [0.0, 0.1, 0.0], 0.0, SIZE), ("b", [0.2 + gap, 0.12, 0.03], 0.0, SIZE)]);
        let collision = &case.metrics(&[&scene])["collision"];
        assert_eq!(collision["strict"]["objects"], strict, "{gap}");
        assert_eq!(collision["deeper_than_1mm"]["objects"], deep, "{gap}");
        let depth = number(&collision["max_depth_m"]);
        assert!((depth - f64::max(-gap, 0.0)).abs() < 1e-6, "{gap}: {depth}");
    }
}

#[test]
fn what_is_swallowed_collides() {
    let case = Case::new();
    let scene = case.scene("a.json", &[("box", [0.0, 0.5, 0.0], 0.3, [1.0; 3]), ("in", [0.1, 0.5, 0.0], 0.0, SIZE)]);
    let collision = &case.metrics(&[&scene])["collision"];
    assert_eq!(collision["strict"]["collision_rate_pct"], 100.0);
    assert_eq!(collision["pairs"][0]["contained"], true);
    // The middle of one of its sides is the middle of the box; the samples nearly hit it.
    assert!((0.48..=0.5).contains(&number(&collision["max_depth_m"])), "{collision}");
}

/// Neither stable nor unstable; and a flat box is like itself.
#[test]
fn of_what_cannot_move_there_is_no_stable_rate() {
    let case = Case::new();
    let standing = case.scene("a.json", &[("stands", [0.0, 0.1, 0.0], 0.0, SIZE)]);
    let mut held: Value = serde_json::from_slice(&fs::read(&standing).unwrap()).unwrap();
    held["objects"][0]["movable"] = json!(false);
    let path = case.folder.path().join("held.json");
    fs::write(&path, held.to_string()).unwrap();
    let stability = &case.metrics(&[&path])["stability"];
    assert_eq!((&stability["movable"], stability.get("stable_rate_pct")), (&json!(0), None));
    let overall = &case.metrics(&[&path, &standing])["over_scenes"];
    assert_eq!(overall["stable_rate_pct"], json!({"mean": 100.0, "standard_deviation": 0.0, "scenes": 1}));
    fs::write(case.folder.path().join("cube.obj"), "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 3 2\n").unwrap();
    let geometry = &case.metrics(&[&path, Path::new("--reference"), &path])["geometry"];
    assert!(number(&geometry["box_iou"]) > 0.999, "{geometry}");
}

#[test]
fn only_what_falls_is_unstable() {
    let case = Case::new();
    let scene = case.scene("a.json", &[("stands", [0.0, 0.1, 0.0], 0.0, SIZE), ("falls", [1.0, 1.1, 0.0], 0.0, SIZE)]);
    let stability = &case.metrics(&[&scene])["stability"];
    assert_eq!(stability["stable_rate_pct"], 50.0);
    assert_eq!(stability["objects"][0]["stable"], true);
    assert_eq!(stability["objects"][1]["stable"], false);
    let (drift, speed) =
        (number(&stability["objects"][1]["drift_m"]), number(&stability["objects"][1]["peak_linear_velocity_mps"]));
    assert!((drift - 1.0).abs() < 2e-3, "it falls 1 m: {drift}");
    // √(2 · 9.8 · 1) less the damping of 0.3/s over 0.46 s.
    assert!((4.0..4.43).contains(&speed), "{speed}");
    assert!(number(&stability["objects"][0]["peak_linear_velocity_mps"]) < 1e-2);
}

/// Five different boxes in a room, moved as a whole.
fn room(turn: f64, shift: DVec3) -> Vec<(&'static str, [f64; 3], f64, [f64; 3])> {
    let boxes = [
        ("a", DVec3::new(0.0, 0.1, 0.0), 0.2, [0.2, 0.2, 0.4]),
        ("b", DVec3::new(1.0, 0.2, 0.3), 0.0, [0.3, 0.4, 0.2]),
        ("c", DVec3::new(-0.6, 0.3, 0.9), 1.0, [0.2, 0.6, 0.5]),
        ("d", DVec3::new(0.4, 0.05, -1.2), 0.5, [0.7, 0.1, 0.3]),
        ("e", DVec3::new(-1.1, 0.4, -0.7), 0.1, [0.3, 0.8, 0.3]),
    ];
    let rotation = DQuat::from_rotation_y(turn);
    boxes.map(|(name, at, yaw, size)| (name, (rotation * at + shift).to_array(), yaw + turn, size)).to_vec()
}

#[test]
fn a_scene_moved_as_a_whole_is_the_same_scene() {
    let case = Case::new();
    let truth = case.scene("truth.json", &room(0.0, DVec3::ZERO));
    for (turn, shift) in [(0.0, DVec3::ZERO), (0.1, DVec3::new(0.05, 0.0, 0.03)), (2.4, DVec3::new(3.0, 0.0, 1.0))] {
        let scene = case.scene("moved.json", &room(turn, shift));
        let metrics = case.metrics(&[&scene, Path::new("--reference"), &truth]);
        let (geometry, layout) = (&metrics["geometry"], &metrics["layout"]);
        assert!(number(&geometry["chamfer_distance_m"]) < 1e-4, "{turn}: {geometry}");
        assert!(number(&geometry["f_score"]) > 0.9999 && number(&geometry["box_iou"]) > 0.999, "{turn}: {geometry}");
        assert!((number(&geometry["aligned_by_rad"]) - turn).abs() < 1e-3, "{turn}: {geometry}");
        assert!(number(&layout["max_translation_m"]) < 1e-6 && number(&layout["max_rotation_rad"]) < 1e-6, "{layout}");
    }
}

#[test]
fn one_object_out_of_place_shows() {
    let case = Case::new();
    let truth = case.scene("truth.json", &room(0.0, DVec3::ZERO));
    let mut moved = room(0.0, DVec3::ZERO);
    moved[1].1[0] += 0.5;
    moved[2].2 += 0.7;
    let scene = case.scene("moved.json", &moved);
    let metrics = case.metrics(&[&scene, Path::new("--reference"), &truth]);
    let (geometry, layout) = (&metrics["geometry"], &metrics["layout"]);
    assert!(number(&geometry["box_iou"]) < 0.9 && number(&geometry["f_score"]) < 0.99, "{geometry}");
    assert!(number(&geometry["chamfer_distance_m"]) > 0.01, "{geometry}");
    assert!((0.3..0.5).contains(&number(&layout["max_translation_m"])), "{layout}");
    assert_eq!(layout["fallen"], json!(["c"]), "turned by 40°");
    assert_eq!(layout["objects"], 5);
}

#[test]
fn a_reference_of_other_names_is_told() {
    let case = Case::new();
    let truth = case.scene("truth.json", &room(0.0, DVec3::ZERO));
    let same = case.run(&[&truth, Path::new("--reference"), &truth]);
    assert!(!String::from_utf8_lossy(&same.stderr).contains("names of objects"));
    let mut named = room(0.0, DVec3::ZERO);
    named.iter_mut().zip(["one", "two", "three", "four", "five"]).for_each(|(cube, name)| cube.0 = name);
    let other = case.run(&[&case.scene("other.json", &named), Path::new("--reference"), &truth]);
    let said = String::from_utf8_lossy(&other.stderr);
    assert!(other.status.success() && said.contains("names of objects in") && said.contains("truth.json"), "{said}");
}

#[test]
fn many_scenes_have_a_mean_and_failures() {
    let case = Case::new();
    let good = case.scene("good.json", &[("a", [0.0, 0.1, 0.0], 0.0, SIZE)]);
    let bad = case.scene("bad.json", &[("a", [0.0, 1.1, 0.0], 0.0, SIZE)]);
    let gone = case.folder.path().join("gone.json");
    let overall = case.metrics(&[&good, &bad, &gone]);
    assert_eq!(overall["over_scenes"]["stable_rate_pct"]["mean"], 50.0);
    assert_eq!(overall["over_scenes"]["stable_rate_pct"]["standard_deviation"], 50.0);
    assert!((number(&overall["failure_rate_pct"]) - 100.0 / 3.0).abs() < 1e-9);
    assert_eq!(overall["scenes"].as_array().unwrap().len(), 2);
    assert!(overall["failures"][0].as_str().unwrap().contains("gone.json"));
}

#[test]
fn masks_are_matched_by_their_overlap() {
    let case = Case::new();
    let folder = |name: &str, rows: &[[u32; 2]]| {
        let path = case.folder.path().join(name);
        fs::create_dir(&path).unwrap();
        for (i, [from, to]) in rows.iter().enumerate() {
            let image = GrayImage::from_fn(10, 100, |_, y| Luma([if (*from..*to).contains(&y) { 255 } else { 0 }]));
            image.save(path.join(format!("{i}.png"))).unwrap();
        }
        path
    };
    // Found whole, found by 8 of 12 rows, found by 5 of 20, and not at all.
    let truth = folder("truth", &[[0, 10], [20, 30], [40, 60], [80, 100]]);
    let masks = folder("masks", &[[0, 10], [22, 32], [40, 45]]);
    let scene = case.scene("a.json", &[("a", [0.0, 0.1, 0.0], 0.0, SIZE)]);
    let options = ["--masks", "--true-masks"].map(Path::new);
    let detection = &case.metrics(&[&scene, options[0], &masks, options[1], &truth])["detection"];
    assert_eq!(detection["recall_at_50"], 0.5);
    assert_eq!(detection["miss_rate"], 0.25);
    assert!((number(&detection["mean_iou"]) - (1.0 + 8.0 / 12.0 + 0.25) / 3.0).abs() < 1e-12);

    fs::write(masks.join("3.png"), b"no picture").unwrap();
    let output = case.run(&[&scene, options[0], &masks, options[1], &truth]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("3.png"));
}

#[test]
fn bad_usage_is_told() {
    let case = Case::new();
    let scene = case.scene("a.json", &[("a", [0.0, 0.1, 0.0], 0.0, SIZE)]);
    let (reference, gone) = (Path::new("--reference"), case.folder.path().join("gone.json"));
    let cases: [(&[&Path], &str); 3] = [
        (&[&gone], "gone.json"),
        (&[&scene, reference, &gone], "gone.json"),
        (&[&scene, &scene, &scene, reference, &scene, reference, &scene], "one for each"),
    ];
    for (arguments, wanted) in cases {
        let output = case.run(arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(wanted) && output.stdout.is_empty(), "{message}");
    }
}
