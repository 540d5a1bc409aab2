//! Canonicalization: synthetic rooms whose right layout is known, what must stay the same, bad input, and the shared rooms.

#![allow(clippy::unwrap_used)]

use glam::{DMat3, DQuat, DVec3};
use rest3d_gpu::canonicalize::{Canonicalization, canonicalize};
use rest3d_gpu::optimize::shape_requests;
use rest3d_gpu::scene::{Pose, Scene};
use rest3d_gpu::shape::{Mesh, scaled_mesh};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// Lowest and highest corner of a box, m.
type Block = [[f64; 3]; 2];

/// Front is +Z; origins are on the floor.
const DESK: &[Block] = &[
    [[-0.6, 0.72, -0.3], [0.6, 0.75, 0.3]],
    [[-0.6, 0.0, -0.3], [-0.57, 0.72, 0.3]],
    [[0.57, 0.0, -0.3], [0.6, 0.72, 0.3]],
    // The hutch: a wall behind and a board over the back of the top.
    [[-0.6, 0.75, -0.3], [0.6, 1.3, -0.28]],
    [[-0.6, 1.1, -0.28], [0.6, 1.12, -0.05]],
];
const CHAIR: &[Block] = &[
    [[-0.22, 0.43, -0.22], [0.22, 0.46, 0.22]],
    [[-0.22, 0.46, -0.22], [0.22, 0.95, -0.19]],
    [[-0.22, 0.0, -0.22], [-0.18, 0.43, -0.18]],
    [[0.18, 0.0, -0.22], [0.22, 0.43, -0.18]],
    [[-0.22, 0.0, 0.18], [-0.18, 0.43, 0.22]],
    [[0.18, 0.0, 0.18], [0.22, 0.43, 0.22]],
];
const SHELF: &[Block] = &[
    [[-0.4, 0.0, -0.15], [-0.38, 1.5, 0.15]],
    [[0.38, 0.0, -0.15], [0.4, 1.5, 0.15]],
    [[-0.38, 0.1, -0.15], [0.38, 0.12, 0.15]],
    [[-0.38, 0.5, -0.15], [0.38, 0.52, 0.15]],
    [[-0.38, 0.9, -0.15], [0.38, 0.92, 0.15]],
    [[-0.38, 1.48, -0.15], [0.38, 1.5, 0.15]],
];
const CRATE: &[Block] = &[[[-0.25, 0.0, -0.2], [0.25, 0.4, 0.2]]];
const TIN: &[Block] = &[[[-0.05, 0.0, -0.04], [0.05, 0.12, 0.04]]];
const BOOK: &[Block] = &[[[-0.1, 0.0, -0.07], [0.1, 0.03, 0.07]]];

fn obj(blocks: &[Block]) -> String {
    const FACES: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut text = String::new();
    for block in blocks {
        for i in 0..8 {
            let [x, y, z] = std::array::from_fn(|axis| block[i >> axis & 1][axis]);
            text += &format!("v {x} {y} {z}\n");
        }
    }
    for first in (0..blocks.len()).map(|n| 8 * n + 1) {
        for [a, b, c, d] in FACES.map(|face| face.map(|i| first + i)) {
            text += &format!("f {a} {b} {c} {d}\n");
        }
    }
    text
}

/// An object of a known layout.
struct Thing {
    name: &'static str,
    mesh: &'static str,
    pose: Pose,
    parent: &'static str,
    relation: &'static str,
    movable: bool,
}

fn thing(name: &'static str, mesh: &'static str, at: [f64; 3], yaw: f64, parent: &'static str) -> Thing {
    let pose = Pose { rotation: DQuat::from_rotation_y(yaw), translation: DVec3::from(at) };
    Thing { name, mesh, pose, parent, relation: "on", movable: true }
}

/// A room in which everything stands where it belongs.
fn room() -> Vec<Thing> {
    let mut things = vec![
        thing("desk", "desk", [0.0, 0.0, -1.5], 0.1, "ground"),
        thing("chair", "chair", [0.1, 0.0, -0.8], 3.0, "ground"),
        thing("shelf", "shelf", [-1.5, 0.0, -1.0], 1.5, "ground-wall"),
        thing("crate", "crate", [1.2, 0.0, 0.3], 0.4, "ground"),
        thing("second crate", "crate", [-1.0, 0.0, 0.9], -0.8, "ground"),
        thing("tin", "tin", [0.2, 0.75, -1.35], 0.5, "desk"),
        thing("tin below", "tin", [-0.3, 0.75, -1.62], 0.2, "desk"),
        thing("tin above", "tin", [0.3, 1.12, -1.66], -0.4, "desk"),
        thing("book", "book", [0.1, 0.46, -0.8], 2.0, "chair"),
        thing("shelf book", "book", [-1.5, 0.52, -1.0], 1.5, "shelf"),
        thing("top book", "book", [-1.5, 0.55, -1.0], 1.2, "shelf book"),
        thing("clock", "tin", [0.0, 1.7, -1.9], 0.0, "wall"),
        thing("lamp", "tin", [0.0, 2.3, 0.0], 0.0, "ceiling"),
        thing("cabinet", "crate", [1.5, 0.0, -1.5], 0.0, "ground"),
    ];
    things[9].relation = "inside";
    things[12].relation = "hanging";
    things[13].movable = false;
    things
}

/// A scene on disk with its meshes.
struct Case {
    folder: TempDir,
}

impl Case {
    /// `change` is what the reconstruction gets wrong about all objects alike.
    fn new(things: &[Thing], change: Pose) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (name, blocks) in
            [("desk", DESK), ("chair", CHAIR), ("shelf", SHELF), ("crate", CRATE), ("tin", TIN), ("book", BOOK)]
        {
            fs::write(folder.path().join(format!("{name}.obj")), obj(blocks)).unwrap();
        }
        let place = |p: DVec3| change.translation + change.rotation * p;
        let entry = |thing: &Thing| {
            json!({
                "name": thing.name, "mesh": format!("{}.obj", thing.mesh), "parent": thing.parent,
                "position": place(thing.pose.translation).to_array(),
                "rotation_xyzw": (change.rotation * thing.pose.rotation).to_array(),
                "relation": thing.relation, "movable": thing.movable, "colour": "red",
            })
        };
        let objects: Vec<Value> = things.iter().map(entry).collect();
        let wall = json!({
            "name": "back", "point": place(DVec3::new(0.0, 1.0, -2.0)).to_array(),
            "normal": (change.rotation * DVec3::Z).to_array(),
        });
        let room = json!({"ceiling": place(DVec3::new(0.0, 2.5, 0.0)).y, "walls": [wall]});
        let document = json!({
            "format": "rest3d-scene", "version": 1, "name": "room", "room": room, "objects": objects, "origin": "test"
        });
        fs::write(folder.path().join("scene.json"), document.to_string()).unwrap();
        Self { folder }
    }

    fn read(&self) -> (Scene, Vec<Mesh>) {
        let scene = Scene::read(self.folder.path()).unwrap();
        let meshes = shape_requests(&scene).iter().map(|request| scaled_mesh(request).unwrap()).collect();
        (scene, meshes)
    }

    fn canonical(&self) -> (Scene, Canonicalization) {
        let (mut scene, meshes) = self.read();
        let report = canonicalize(&mut scene, &meshes);
        (scene, report)
    }

    fn run(&self, command: &str, more: &[&str]) -> Output {
        let mut run = Command::new(env!("CARGO_BIN_EXE_rest3d-gpu"));
        run.arg(command).arg(self.folder.path()).arg("-o").arg(self.folder.path().join("out")).args(more);
        run.env("REST3D_GPU_CACHE", cache()).output().unwrap()
    }
}

/// Shared by all tests: entries are found by their content and written in one step.
fn cache() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("shapes")
}

fn tilt(direction: f64, degrees: f64) -> DQuat {
    DQuat::from_axis_angle(DVec3::new(direction.cos(), 0.0, direction.sin()), degrees.to_radians())
}

fn up(pose: &Pose) -> DVec3 {
    pose.rotation * DVec3::Y
}

fn by_name<'a>(scene: &'a Scene, name: &str) -> &'a Pose {
    &scene.objects.iter().find(|object| object.name == name).unwrap().pose
}

/// Everything upright and at its height, with the horizontal distances of the known layout.
fn assert_restored(scene: &Scene, things: &[Thing], tolerance: f64) {
    for (object, thing) in scene.objects.iter().zip(things) {
        assert!(up(&object.pose).angle_between(DVec3::Y) < tolerance, "{}: {:?}", thing.name, object.pose);
        let height = object.pose.translation.y - thing.pose.translation.y;
        assert!(height.abs() < tolerance, "{}: {height} m too high", thing.name);
    }
    let distance = |a: DVec3, b: DVec3| a.distance(b);
    for (object, thing) in scene.objects.iter().zip(things).skip(1) {
        let now = distance(object.pose.translation, scene.objects[0].pose.translation);
        let known = distance(thing.pose.translation, things[0].pose.translation);
        assert!((now - known).abs() < tolerance, "{}: {now} m, not {known} m from the desk", thing.name);
    }
}

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

#[test]
fn the_command_leaves_a_scene_and_a_report() {
    let change = Pose { rotation: tilt(1.0, 12.0), translation: DVec3::Y * 0.4 };
    let case = Case::new(&room(), change);
    let output = case.run("canonicalize", &["--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let out = case.folder.path().join("out");
    let kept: Value = serde_json::from_slice(&fs::read(out.join("canonicalize.json")).unwrap()).unwrap();
    assert_eq!(printed, kept);
    assert!((printed["rotation"]["degrees"].as_f64().unwrap() - 12.0).abs() < 0.01);
    assert_eq!(printed["objects"].as_array().unwrap().len(), room().len());

    let document: Value = serde_json::from_slice(&fs::read(out.join("scene.json")).unwrap()).unwrap();
    assert_eq!(document["origin"], "test");
    assert_eq!(document["objects"][0]["colour"], "red");
    let ceiling = document["room"]["ceiling"].as_f64().unwrap();
    assert!((2.2..2.8).contains(&ceiling), "{ceiling}");
    let scene = Scene::read(&out).unwrap();
    assert_restored(&scene, &room(), 1e-5);
    assert!((scene.room.walls[0].normal.y).abs() < 1e-5);

    let text = case.run("canonicalize", &[]);
    assert!(String::from_utf8_lossy(&text.stdout).contains("12.0°"), "{}", String::from_utf8_lossy(&text.stdout));
}

#[test]
fn optimize_canonicalizes_or_warns() {
    let things: Vec<Thing> = room().into_iter().take(2).collect();
    let case = Case::new(&things, Pose { rotation: tilt(1.0, 12.0), translation: DVec3::Y * 0.4 });
    let tiny = ["--json", "--candidates", "8", "--iterations", "2"];
    let report = |output: Output| -> (Value, String) {
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{message}");
        (serde_json::from_slice(&output.stdout).unwrap(), message)
    };
    let (with, message) = report(case.run("optimize", &[&tiny[..], &["--canonicalize"]].concat()));
    assert!(!message.contains("tilted"), "{message}");
    assert!((with["canonicalization"]["tilt_degrees"].as_f64().unwrap() - 12.0).abs() < 0.01);
    let scene = Scene::read(&case.folder.path().join("out")).unwrap();
    assert!(scene.objects.iter().all(|object| up(&object.pose).y > 0.999), "they stand upright");

    // A replay of the winner makes the scene canonical by itself.
    let stage = with["groups"].as_array().unwrap().len() - 1;
    let winner = &with["groups"][stage]["winner"];
    let mut replay = Command::new(env!("CARGO_BIN_EXE_rest3d-gpu"));
    replay.arg("simulate").arg(case.folder.path()).arg("--run").arg(case.folder.path().join("out"));
    replay.arg("--replay").arg(format!("{stage},{},{}", winner[0], winner[1]));
    let output = replay.env("REST3D_GPU_CACHE", cache()).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !message.contains("went otherwise"), "{message}");

    let (without, message) = report(case.run("optimize", &tiny));
    assert!(without.get("canonicalization").is_none());
    assert!(message.contains("tilted by 12.0°") && message.contains("--canonicalize"), "{message}");
}

#[test]
fn bad_input_is_refused_and_nothing_is_written() {
    let change = |edit: &dyn Fn(&mut Value)| {
        let case = Case::new(&room(), Pose::IDENTITY);
        let file = case.folder.path().join("scene.json");
        let mut document: Value = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
        edit(&mut document["objects"][0]);
        fs::write(&file, document.to_string()).unwrap();
        fs::write(case.folder.path().join("broken.obj"), "v 0 0 0\n").unwrap();
        case
    };
    for (case, words) in [
        (change(&|o| o["mesh"] = json!("absent.obj")), ["scene.json", "desk", "mesh", "absent.obj"]),
        (change(&|o| o["mesh"] = json!("broken.obj")), ["scene.json", "desk", "mesh", "broken.obj"]),
        (change(&|o| o["scale"] = json!(1e3)), ["scene.json", "desk", "scale", "correct"]),
        (change(&|o| o["parent"] = json!("tin")), ["scene.json", "desk", "parent", "cycle"]),
        (change(&|o| o["position"] = json!([0, null, 0])), ["scene.json", "desk", "position", "write"]),
    ] {
        let output = case.run("canonicalize", &["--json"]);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(words.iter().all(|word| message.contains(word)), "{words:?}: {message}");
        assert!(output.stdout.is_empty() && !case.folder.path().join("out").exists(), "{message}");
    }
    let case = Case::new(&room(), Pose::IDENTITY);
    let mut onto_itself = Command::new(env!("CARGO_BIN_EXE_rest3d-gpu"));
    let output = onto_itself.arg("canonicalize").arg(case.folder.path()).arg("-o").arg(case.folder.path()).output();
    assert_eq!(output.unwrap().status.code(), Some(2), "the input is not replaced");
}

/// A scene with the middles of its objects' boxes in the world.
fn shared(file: &Path) -> (Scene, Vec<Mesh>) {
    let scene = Scene::read(file).unwrap();
    let meshes = shape_requests(&scene).iter().map(|request| scaled_mesh(request).unwrap()).collect();
    (scene, meshes)
}

fn middles(scene: &Scene, meshes: &[Mesh]) -> Vec<DVec3> {
    let middle = |mesh: &Mesh| {
        let points = || mesh.vertices.iter().map(|v| v.as_dvec3());
        0.5 * (points().fold(DVec3::INFINITY, DVec3::min) + points().fold(DVec3::NEG_INFINITY, DVec3::max))
    };
    (scene.objects.iter().zip(meshes))
        .map(|(object, mesh)| object.pose.translation + object.pose.rotation * middle(mesh))
        .collect()
}

/// Mean distance of two layouts after the rigid motion that fits them best, as the judge measures it.
fn distance(from: &[DVec3], to: &[DVec3]) -> f64 {
    let centred = |points: &[DVec3]| -> Vec<DVec3> {
        let mean = points.iter().sum::<DVec3>() / points.len() as f64;
        points.iter().map(|p| *p - mean).collect()
    };
    let (mut from, to) = (centred(from), centred(to));
    // Gauss and Newton: the layouts are a few degrees apart.
    for _ in 0..20 {
        let (mut normal, mut moment) = (DMat3::ZERO, DVec3::ZERO);
        for (p, q) in from.iter().zip(&to) {
            normal +=
                DMat3::from_diagonal(DVec3::splat(p.length_squared())) - DMat3::from_cols(*p * p.x, *p * p.y, *p * p.z);
            moment += p.cross(*q);
        }
        let turn = DQuat::from_scaled_axis(normal.inverse() * moment);
        from.iter_mut().for_each(|p| *p = turn * *p);
    }
    from.iter().zip(&to).map(|(p, q)| p.distance(*q)).sum::<f64>() / from.len() as f64
}

/// `limit`: degrees that the vertical may be off, and the distance from the truth over that of `scene.json`.
fn restores_a_shared_room(name: &str, limit: [f64; 2]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes").join(name);
    let corruption: Value = serde_json::from_slice(&fs::read(folder.join("corruption.json")).unwrap()).unwrap();
    let known = |key: &str| corruption["raw_transform"][key].clone();
    let axis: [f64; 2] = serde_json::from_value(known("tilt_axis_xz")).unwrap();
    let axis = DVec3::new(axis[0], 0.0, axis[1]).normalize();
    let tilt = DQuat::from_axis_angle(axis, known("tilt_deg").as_f64().unwrap().to_radians());

    let (mut scene, meshes) = shared(&folder.join("raw.json"));
    let report = canonicalize(&mut scene, &meshes);
    let found = DQuat::from_axis_angle(DVec3::from(report.rotation.axis), report.rotation.degrees.to_radians());
    let error = (found * tilt * DVec3::Y).angle_between(DVec3::Y).to_degrees();

    // The known layout is canonical: pots and crumpled boxes stand on their bases a little better.
    let (truth, truth_meshes) = shared(&folder.join("truth.json"));
    let changes = canonicalize(&mut truth.clone(), &truth_meshes);
    assert_eq!(changes.rotation.degrees, 0.0);
    // A banana has several ways to lie, 11° apart.
    for object in changes.objects.iter().filter(|object| object.name != "banana") {
        assert!(object.turned_degrees < 1.0 && object.raised.abs() < 3e-3, "{object:?}");
    }
    let (corrupted, corrupted_meshes) = shared(&folder.join("scene.json"));
    let truth = middles(&truth, &truth_meshes);
    let own = distance(&middles(&corrupted, &corrupted_meshes), &truth);
    // The raw scene has a scale of its own, which canonicalization leaves alone.
    let scale = known("g").as_f64().unwrap();
    let result: Vec<DVec3> = middles(&scene, &meshes).into_iter().map(|p| p / scale).collect();
    let ratio = distance(&result, &truth) / own;
    eprintln!("{name}: vertical off by {error:.2}°, {ratio:.2} times the distance of scene.json ({:.1} mm)", 1e3 * own);
    assert!(error < limit[0] && ratio < limit[1], "{name}: {error}°, {ratio}");
}

macro_rules! shared_rooms {
    ($($name:ident: $limit:expr;)*) => {$(
        #[test]
        #[cfg_attr(not(shared_files), ignore = "needs ../shared")]
        fn $name() {
            restores_a_shared_room(stringify!($name), $limit);
        }
    )*};
}

shared_rooms! {
    bedroom: [1.5, 1.15];
    deep_interpenetration: [1.5, 1.15];
    dining_room: [1.5, 1.15];
    living_room: [1.5, 1.15];
    // Four objects, of which the table and the mug are turned the same way by 3° and 5°: no vote can tell.
    minimal: [1.8, 1.3];
    office: [1.5, 1.15];
    study: [1.5, 1.15];
    tabletop_desk: [1.5, 1.15];
    wall_ceiling: [1.5, 1.15];
}
