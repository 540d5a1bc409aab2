//! Pictures: that both painters agree, that they show what they should, and what becomes of bad input.
//!
//! Without an adapter the comparison is left out, visibly; with `REST3D_GPU_REQUIRE_ADAPTER=1` it fails.
#![allow(clippy::unwrap_used)]

mod common;

use common::meshes::CUBE;
use glam::{DVec3, Vec3};
use rest3d_gpu::cpu::CpuPainter;
use rest3d_gpu::gpu::{AdapterChoice, GpuPainter};
use rest3d_gpu::render::{Camera, Models, Painter, Picture, Size, Stage, Viewpoint, camera, lights, stage};
use rest3d_gpu::scene::Scene;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

const SIZE: Size = Size { width: 320, height: 240 };

/// A folder with meshes, removed at the end.
struct Case(TempDir);

impl Case {
    fn new() -> Self {
        let case = Self(tempfile::tempdir().unwrap());
        case.file("cube.obj", CUBE);
        case
    }

    fn file(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.0.path().join(name), content).unwrap();
    }

    fn scene(&self, document: &Value) -> Scene {
        self.file("scene.json", document.to_string());
        Scene::read(self.0.path()).unwrap()
    }
}

fn cuboid(name: &str, position: [f64; 3], size: [f64; 3]) -> Value {
    json!({"name": name, "mesh": "cube.obj", "position": position, "scale": size})
}

fn document(objects: &[Value]) -> Value {
    let walls = json!([{"name": "back", "point": [0, 0, -1], "normal": [0, 0, 1]}]);
    json!({"format": "rest3d-scene", "version": 1, "room": {"walls": walls}, "objects": objects})
}

/// A table's worth of boxes before a wall.
fn boxes() -> Vec<Value> {
    vec![
        cuboid("desk", [0.0, 0.35, 0.0], [1.2, 0.7, 0.6]),
        cuboid("box", [0.2, 0.8, 0.1], [0.2, 0.2, 0.2]),
        cuboid("stool", [0.1, 0.2, 0.9], [0.3, 0.4, 0.3]),
    ]
}

fn staged(scene: &Scene) -> Stage {
    stage(scene, &mut Models::default()).unwrap()
}

fn shot(scene: &Scene, painter: &dyn Painter) -> Picture {
    let stage = staged(scene);
    painter.paint(&stage, &camera(Viewpoint::Auto, scene, &[&stage], SIZE), SIZE).unwrap()
}

/// Mean difference of the bytes, and share of the pixels that differ by more than a sixteenth of the range.
fn difference(a: &Picture, b: &Picture) -> (f64, f64) {
    assert_eq!(a.size, b.size);
    let off = |(a, b): (&u8, &u8)| f64::from(a.abs_diff(*b));
    let mean = a.rgb.iter().zip(&b.rgb).map(off).sum::<f64>() / a.rgb.len() as f64;
    let pixels = a.rgb.chunks_exact(3).zip(b.rgb.chunks_exact(3));
    let differing = pixels.filter(|(a, b)| a.iter().zip(*b).any(|both| off(both) > 16.0)).count();
    (mean, differing as f64 / (a.rgb.len() / 3) as f64)
}

fn agree(a: &Picture, b: &Picture) -> bool {
    let (mean, differing) = difference(a, b);
    eprintln!("mean difference {mean:.3}, differing pixels {:.3} %", 100.0 * differing);
    mean < 0.3 && differing < 2e-3
}

/// The adapter, if there is one or must be.
fn adapter() -> Option<GpuPainter> {
    let required = std::env::var("REST3D_GPU_REQUIRE_ADAPTER").is_ok_and(|value| value != "0");
    match GpuPainter::open(&AdapterChoice::Auto) {
        Ok(painter) => Some(painter),
        Err(error) if required => panic!("{error}"),
        Err(error) => {
            eprintln!("left out: {error}");
            None
        }
    }
}

/// A PNG of four coloured quarters, the last one transparent.
fn texture() -> Vec<u8> {
    let mut pixels = image::RgbaImage::new(64, 64);
    for (x, y, pixel) in pixels.enumerate_pixels_mut() {
        *pixel = image::Rgba(match (x < 32, y < 32) {
            (true, true) => [220, 40, 40, 255],
            (false, true) => [40, 200, 60, 255],
            (true, false) => [50, 70, 220, 255],
            (false, false) => [0, 0, 0, 0],
        });
    }
    let mut bytes = Vec::new();
    pixels.write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Png).unwrap();
    bytes
}

/// A glTF of one upright square with a texture, holes where it is transparent.
fn square(image: &str) -> String {
    let numbers: [f32; 20] = [
        -0.5, -0.5, 0.0, 0.5, -0.5, 0.0, 0.5, 0.5, 0.0, -0.5, 0.5, 0.0, // positions
        0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, // places in the texture
    ];
    let mut bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0, 1, 2, 0, 2, 3_u16].iter().flat_map(|i| i.to_le_bytes()));
    let data = base64(&bytes);
    json!({
        "asset": {"version": "2.0"},
        "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "alphaMode": "MASK", "alphaCutoff": 0.5
        }],
        "textures": [{"source": 0}], "images": [{"uri": image}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-0.5, -0.5, 0], "max": [0.5, 0.5, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 32},
            {"buffer": 0, "byteOffset": 80, "byteLength": 12}
        ],
        "buffers": [{"byteLength": 92, "uri": format!("data:application/octet-stream;base64,{data}")}]
    })
    .to_string()
}

fn base64(bytes: &[u8]) -> String {
    use base64::Engine;
    base64::engine::general_purpose::STANDARD.encode(bytes)
}

/// Everything that a picture can show: boxes, a wall, a texture with holes, a pane that stands for a wall.
fn everything(case: &Case) -> Scene {
    case.file("square.gltf", square("quarters.png"));
    case.file("quarters.png", texture());
    let mut objects = boxes();
    objects.push(json!({"name": "sign", "mesh": "square.gltf", "position": [-0.7, 0.6, 0.8]}));
    let mut pane = cuboid("pane", [0.9, 0.5, 0.6], [0.05, 1.0, 0.6]);
    (pane["category"], pane["movable"]) = ("wall".into(), false.into());
    objects.push(pane);
    case.scene(&document(&objects))
}

#[test]
fn both_painters_draw_the_same() {
    let Some(adapter) = adapter() else { return };
    let case = Case::new();
    let scene = everything(&case);
    assert!(agree(&shot(&scene, &adapter), &shot(&scene, &CpuPainter)));
}

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
    if let Some(adapter) = adapter() {
        assert_eq!(shot(&scene, &adapter), shot(&scene, &adapter));
    }
}

#[test]
fn textures_are_seen_and_their_holes_are_seen_through() {
    let case = Case::new();
    case.file("square.gltf", square("quarters.png"));
    case.file("quarters.png", texture());
    let mut scene = document(&[json!({"name": "sign", "mesh": "square.gltf", "position": [0, 0.5, 0]})]);
    scene["room"] = json!({});
    let scene = case.scene(&scene);
    let stage = staged(&scene);
    assert!(stage.notes.is_empty(), "{:?}", stage.notes);
    let camera = camera(Viewpoint::Toward { azimuth: 0.0, elevation: 0.0 }, &scene, &[&stage], SIZE);
    let picture = CpuPainter.paint(&stage, &camera, SIZE).unwrap();
    let at = |x: f64, y: f64| {
        let pixel = (y * 240.0) as usize * 320 + (x * 320.0) as usize;
        Vec3::from_array([0, 1, 2].map(|i| f32::from(picture.rgb[3 * pixel + i])))
    };
    let [red, green, blue, hole] = [at(0.4, 0.35), at(0.6, 0.35), at(0.4, 0.65), at(0.6, 0.65)];
    assert!(red.x > 1.5 * red.y.max(red.z), "{red}");
    assert!(green.y > 1.5 * green.x.max(green.z), "{green}");
    assert!(blue.z > 1.5 * blue.x.max(blue.y), "{blue}");
    assert!(hole.min_element() > 100.0, "{hole}");
}

#[test]
fn a_broken_texture_is_told_and_the_colour_drawn() {
    let case = Case::new();
    case.file("square.gltf", square("quarters.png"));
    let document = document(&[json!({"name": "sign", "mesh": "square.gltf", "position": [0, 0.5, 0]})]);
    for content in [None, Some(&b"no image"[..]), Some(&texture()[..100])] {
        if let Some(content) = content {
            case.file("quarters.png", content);
        }
        let scene = case.scene(&document);
        let stage = staged(&scene);
        let notes = stage.notes.join("\n");
        assert!(notes.contains("square.gltf") && notes.contains("plain colour"), "{notes}");
        assert_eq!(stage.textures.len(), 0);
        shot(&scene, &CpuPainter);
    }
}

/// Colours of OBJ materials and of the vertices of a PLY reach the picture's triangles.
#[test]
fn colours_of_other_formats_are_read() {
    let case = Case::new();
    case.file("red.mtl", "newmtl red\nKd 1 0 0\n");
    case.file("red.obj", format!("mtllib red.mtl\nusemtl red\n{CUBE}"));
    let vertices = "0 0 0 0 0 255\n1 0 0 0 0 255\n0 1 0 0 0 255\n";
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                  property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n\
                  property list uchar int vertex_indices\nend_header\n";
    case.file("blue.ply", format!("{header}{vertices}3 0 1 2\n"));
    for (mesh, color) in [("red.obj", [255, 0, 0]), ("blue.ply", [0, 0, 255])] {
        let scene = case.scene(&document(&[json!({"name": "x", "mesh": mesh})]));
        let stage = staged(&scene);
        assert_eq!(stage.vertices[0].color.to_le_bytes()[..3], color, "{mesh}");
        assert!(stage.notes.is_empty(), "{:?}", stage.notes);
    }
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
        ("empty", document(&[])),
    ];
    for (what, document) in cases {
        if what == "empty" {
            // Not every reader lets this through; nothing to draw is no reason to fail here.
            case.file("scene.json", document.to_string());
            let Ok(scene) = Scene::read(case.0.path()) else { continue };
            shot(&scene, &CpuPainter);
            continue;
        }
        let scene = case.scene(&document);
        let picture = shot(&scene, &CpuPainter);
        let first = &picture.rgb[..3];
        let shown =
            picture.rgb.chunks_exact(3).filter(|pixel| pixel.iter().zip(first).any(|(a, b)| a.abs_diff(*b) > 8));
        let share = shown.count() as f64 / f64::from(SIZE.width * SIZE.height);
        assert!(share > 0.02, "{what}: only {share} of the picture is not background");
    }
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

#[test]
fn cameras_are_understood_or_refused_with_a_remedy() {
    for (text, expected) in [
        ("auto", Viewpoint::Auto),
        (" Top ", Viewpoint::Toward { azimuth: 0.0, elevation: 90.0 }),
        ("-30, 25.5", Viewpoint::Toward { azimuth: -30.0, elevation: 25.5 }),
        ("1,2,3,0,0,0", Viewpoint::Exact { eye: DVec3::new(1.0, 2.0, 3.0), target: DVec3::ZERO }),
    ] {
        assert_eq!(text.parse(), Ok(expected), "{text}");
    }
    for text in ["", "north", "nan,3", "1,2,3", "0,91", "1,inf", "1,2,3,1,2,3", "1,2,3,4,5,x"] {
        let error = text.parse::<Viewpoint>().unwrap_err();
        assert!(error.len() > 20, "{text}: {error}");
    }
    for text in ["", "1600", "0x10", "9000x100", "-3x5", "1e3x1e3"] {
        assert!(text.parse::<Size>().is_err(), "{text}");
    }
    assert_eq!("640X480".parse(), Ok(Size { width: 640, height: 480 }));
}

/// All of the scene is in the picture, and it touches the margin.
#[test]
fn the_camera_frames_the_scene_tightly() {
    let case = Case::new();
    let scene = case.scene(&document(&boxes()));
    let stage = staged(&scene);
    for (azimuth, elevation) in [(0.0, 0.0), (33.0, 27.0), (180.0, -20.0), (70.0, 90.0)] {
        let camera = Camera::framing(azimuth, elevation, &stage.framed, SIZE.aspect());
        let widest = stage.framed.iter().map(|p| {
            let p = *p - camera.eye;
            let depth = p.dot(camera.forward) * camera.slope;
            assert!(depth > 0.0, "{azimuth} {elevation}");
            (p.dot(camera.right) / camera.aspect / depth).abs().max((p.dot(camera.up) / depth).abs())
        });
        let widest = widest.fold(0.0, f64::max);
        assert!((widest - 0.9).abs() < 1e-6, "{azimuth} {elevation}: {widest}");
    }
}

/// An object before another one hides it: the view that is chosen is another.
#[test]
fn the_view_that_is_chosen_hides_nothing() {
    let case = Case::new();
    for (side, hider) in [("front", [0.0, 0.75, 0.6]), ("left", [-0.6, 0.75, 0.0])] {
        let mut size = [1.2, 1.5, 1.2];
        size[if side == "front" { 2 } else { 0 }] = 0.05;
        let objects = [cuboid("small", [0.0, 0.1, 0.0], [0.2; 3]), cuboid("screen", hider, size)];
        let mut document = document(&objects);
        document["room"] = json!({});
        let scene = case.scene(&document);
        let stage = staged(&scene);
        let camera = camera(Viewpoint::Auto, &scene, &[&stage], SIZE);
        let back = camera.toward_viewer();
        let toward = if side == "front" { back.z } else { -back.x };
        // Up to 45° off, the screen hides it.
        assert!(toward < 0.7, "{side}: {back}");
    }
}

#[test]
fn lights_see_all_that_casts_shadows() {
    let case = Case::new();
    let scene = case.scene(&document(&boxes()));
    let stage = staged(&scene);
    let camera = camera(Viewpoint::Auto, &scene, &[&stage], SIZE);
    for light in lights(&stage, &camera) {
        for p in &stage.casters.positions {
            let at = [light.u, light.v, light.depth].map(|row| row.dot(*p));
            assert!(at.iter().all(|x| (0.0..1.0).contains(x)), "{at:?}");
        }
    }
}

#[test]
fn the_shipped_scene_looks_the_same_from_both_painters() {
    let Some(adapter) = adapter() else { return };
    let scene = Scene::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/study")).unwrap();
    assert!(agree(&shot(&scene, &adapter), &shot(&scene, &CpuPainter)));
}
