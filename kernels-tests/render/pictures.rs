//! What pictures show, whatever the scene.

use crate::common::meshes::CUBE;
use crate::fixture::*;
use rest3d_gpu::cpu::CpuPainter;
use rest3d_gpu::render::{Camera, Painter, Viewpoint, camera};
use rest3d_gpu::scene::Scene;
use serde_json::{Value, json};

/// Canary: what the comparison has to notice.
#[test]
fn a_small_change_of_the_scene_is_noticed() {
    let case = Case::new();
    let scene = everything(&case);
    let stage = staged(&scene);
    let camera = camera(Viewpoint::Auto, &scene, &[&stage], SIZE);
    let right = CpuPainter.paint(&stage, &camera, SIZE).unwrap();
    let mut moved = scene.clone();
    moved.objects[1].pose.translation.x += 0.02;
    assert!(!agree(&right, &CpuPainter.paint(&staged(&moved), &camera, SIZE).unwrap()));
    let mut floating = scene.clone();
    floating.objects[2].pose.translation.y += 0.03;
    assert!(!agree(&right, &CpuPainter.paint(&staged(&floating), &camera, SIZE).unwrap()));
}

#[test]
fn the_same_scene_gives_the_same_bytes() {
    let case = Case::new();
    let scene = everything(&case);
    let first = shot(&scene, &CpuPainter).png().unwrap();
    assert_eq!(first, shot(&scene, &CpuPainter).png().unwrap());
    let decoded = image::load_from_memory(&first).unwrap().into_rgb8();
    assert_eq!((decoded.width(), decoded.height()), (SIZE.width, SIZE.height));
}

/// A scene with Z up gives the picture of the same scene with Y up, and an exact camera is given in the file's frame.
#[test]
fn frames_and_units_are_those_of_the_file() {
    let case = Case::new();
    let upright = case.scene(&document(&boxes()));
    let turned: Vec<Value> = boxes()
        .into_iter()
        .map(|mut object| {
            let numbers =
                |key: &str, object: &Value| -> [f64; 3] { [0, 1, 2].map(|i| object[key][i].as_f64().unwrap() * 100.0) };
            let ([x, y, z], [a, b, c]) = (numbers("position", &object), numbers("scale", &object));
            object["position"] = json!([x, -z, y]);
            object["scale"] = json!([a, c, b]);
            object
        })
        .collect();
    let mut document = document(&turned);
    document["frame"] = json!({"up": "Z", "meters_per_unit": 0.01});
    document["room"]["walls"][0] = json!({"name": "back", "point": [0, 100, 0], "normal": [0, -1, 0]});
    let z_up = case.scene(&document);
    assert!(agree(&shot(&upright, &CpuPainter), &shot(&z_up, &CpuPainter)));
    let exact = |scene: &Scene, eye: [f64; 3], target: [f64; 3]| -> Camera {
        let view = Viewpoint::Exact { eye: eye.into(), target: target.into() };
        camera(view, scene, &[], SIZE)
    };
    let (a, b) = (exact(&upright, [1.0, 2.0, 3.0], [0.0; 3]), exact(&z_up, [100.0, -300.0, 200.0], [0.0; 3]));
    assert!(a.eye.distance(b.eye) < 1e-9 && a.forward.distance(b.forward) < 1e-9, "{a:?} {b:?}");
}

/// Sizes, shapes and places that are unusual: every picture shows something, and nothing panics.
#[test]
fn unusual_scenes_are_drawn() {
    let case = Case::new();
    case.file("inside_out.obj", CUBE.lines().map(turned).collect::<Vec<_>>().join("\n"));
    case.file("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 2 0 0\nf 1 2 3\nf 1 2 4\nf 1 1 1\n");
    case.file("many.obj", grid(300));
    let object = |mesh: &str, position: [f64; 3], scale: f64| {
        document(&[json!({"name": mesh, "mesh": mesh, "position": position, "scale": scale})])
    };
    let near = |name: &str, x: f64| cuboid(name, [x, 0.5, 0.0], [1.0; 3]);
    let far = document(&[near("a", 0.0), near("b", 2.0), near("thrown", 9e5)]);
    let cases = [
        ("1 cm", object("cube.obj", [0.0, 0.005, 0.0], 0.01)),
        ("50 m", object("cube.obj", [0.0, 25.0, 0.0], 50.0)),
        ("inside out", object("inside_out.obj", [0.0, 0.5, 0.0], 1.0)),
        ("flat", object("flat.obj", [0.0, 0.0, 0.0], 1.0)),
        ("many triangles", object("many.obj", [0.0, 0.0, 0.0], 1.0)),
        ("far from the origin", object("cube.obj", [9e5, 0.5, -9e5], 1.0)),
        ("below the ground", object("cube.obj", [0.0, -30.0, 0.0], 1.0)),
        ("one far away", far),
    ];
    for (what, document) in cases {
        let scene = case.scene(&document);
        let picture = shot(&scene, &CpuPainter);
        let first = &picture.rgb[..3];
        let shown =
            picture.rgb.chunks_exact(3).filter(|pixel| pixel.iter().zip(first).any(|(a, b)| a.abs_diff(*b) > 8));
        let share = shown.count() as f64 / f64::from(SIZE.width * SIZE.height);
        assert!(share > 0.02, "{what}: only {share} of the picture is not background");
    }
    // Nothing to draw is no reason to fail.
    shot(&case.scene(&document(&[])), &CpuPainter);
}

/// A face of an OBJ seen from the other side.
fn turned(line: &str) -> String {
    match line.strip_prefix("f ") {
        Some(corners) => format!("f {}", corners.split(' ').rev().collect::<Vec<_>>().join(" ")),
        None => line.into(),
    }
}

/// A hilly square of n · n · 2 triangles.
fn grid(n: usize) -> String {
    let mut text = String::new();
    for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
        let (x, z) = (i as f64 / n as f64, j as f64 / n as f64);
        text += &format!("v {x} {} {z}\n", 0.1 * (9.0 * x).sin() * (7.0 * z).cos() + 0.1);
    }
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let at = |i: usize, j: usize| i * (n + 1) + j + 1;
        text += &format!("f {} {} {} {}\n", at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
    }
    text
}
