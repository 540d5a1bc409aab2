//! The scene document: reading, every error of the contract, frames, writing back, and the import of stage2 folders.
#![allow(clippy::unwrap_used)]

use glam::{DQuat, DVec3};
use proptest::prelude::*;
use rest3d_gpu::scene::{Parent, Pose, Relation, Root, Scene, SceneError};
use serde_json::{Value, json};
use std::f64::consts::FRAC_1_SQRT_2;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A folder with two (empty) meshes; reading a scene only looks whether they are there.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("meshes")).unwrap();
        for mesh in ["desk.glb", "mug.glb", "mug_0.obj", "mug_1.obj"] {
            fs::write(folder.path().join("meshes").join(mesh), "").unwrap();
        }
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn read_text(&self, text: impl AsRef<[u8]>) -> Result<Scene, SceneError> {
        fs::write(self.path("scene.json"), text).unwrap();
        Scene::read(&self.path("scene.json"))
    }

    fn read(&self, document: &Value) -> Result<Scene, SceneError> {
        self.read_text(document.to_string())
    }
}

fn read(document: &Value) -> Result<Scene, SceneError> {
    Folder::new().read(document)
}

/// A document that uses everything that the contract names.
fn full() -> Value {
    json!({
        "format": "rest3d-scene", "version": 1, "name": "study",
        "frame": {"up": "Y", "meters_per_unit": 1.0},
        "room": {"ground": 0.0, "ceiling": 2.6, "walls": [{"name": "back", "point": [0, 0, -2.2], "normal": [0, 0, 2]}]},
        "objects": [
            {"name": "mug", "category": "mug", "mesh": "meshes/mug.glb",
             "position": [0.1, 0.75, -0.3], "rotation_xyzw": [0, 0, 0, 1], "scale": 1.0,
             "parent": "desk", "relation": "on", "movable": true,
             "mass": 0.3, "convex_parts": ["meshes/mug_0.obj"]},
            {"name": "desk", "mesh": "meshes/desk.glb"}
        ]
    })
}

fn minimal(objects: Value) -> Value {
    json!({"format": "rest3d-scene", "version": 1, "objects": objects})
}

/// `full` with one value replaced, by JSON pointer; a missing last field is added.
fn with(pointer: &str, value: Value) -> Value {
    let mut document = full();
    let (parent, field) = pointer.rsplit_once('/').unwrap();
    let parent = document.pointer_mut(parent).unwrap();
    match field.parse::<usize>() {
        Ok(index) => parent[index] = value,
        Err(_) => parent[field] = value,
    }
    document
}

fn without(pointer: &str) -> Value {
    let mut document = full();
    let (parent, field) = pointer.rsplit_once('/').unwrap();
    document.pointer_mut(parent).unwrap().as_object_mut().unwrap().remove(field).unwrap();
    document
}

#[test]
fn everything_that_the_contract_names_is_read() {
    let folder = Folder::new();
    let scene = folder.read(&full()).unwrap();
    assert_eq!((scene.name.as_str(), scene.objects.len()), ("study", 2));
    assert_eq!(scene.file, folder.path("scene.json"));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let mug = &scene.objects[0];
    assert_eq!(mug.mesh, folder.path("meshes/mug.glb"));
    assert_eq!(mug.convex_parts, [folder.path("meshes/mug_0.obj")]);
    assert_eq!(mug.pose, Pose { rotation: DQuat::IDENTITY, translation: DVec3::new(0.1, 0.75, -0.3) });
    assert_eq!((mug.parent, mug.relation, mug.mass), (Parent::Object(1), Relation::On, Some(0.3)));
    let desk = &scene.objects[1];
    assert_eq!((desk.parent, desk.relation, desk.movable), (Parent::Root(Root::Ground), Relation::On, true));
    assert_eq!((desk.pose, desk.scale, desk.mass), (Pose::IDENTITY, DVec3::ONE, None));
    assert!(desk.category.is_empty() && desk.convex_parts.is_empty());
    assert_eq!(scene.room.ceiling, Some(2.6));
    assert_eq!((scene.room.walls[0].name.as_str(), scene.room.walls[0].normal), ("back", DVec3::Z));
}

#[test]
fn a_folder_stands_for_its_scene_and_gives_it_a_name() {
    let folder = Folder::new();
    let scene = folder.read(&without("/name")).unwrap();
    assert_eq!(scene.name, folder.0.path().file_name().unwrap().to_str().unwrap());
    assert_eq!(Scene::read(folder.0.path()).unwrap().objects, scene.objects);
}

#[test]
fn null_stands_for_absent_and_a_byte_order_mark_for_nothing() {
    let document = minimal(json!([{"name": "desk", "mesh": "meshes/desk.glb", "mass": null, "convex_parts": null}]));
    let scene = Folder::new().read_text(format!("\u{feff}{document}")).unwrap();
    assert_eq!(scene.objects[0].mass, None);
}

#[test]
fn names_of_the_released_pipeline_are_read_and_kept() {
    let relations = [
        ("hang", Relation::Hanging),
        ("attach", Relation::Attached),
        ("on-attach", Relation::Attached),
        ("hanging", Relation::Hanging),
        ("attached", Relation::Attached),
        ("inside", Relation::Inside),
    ];
    for (name, relation) in relations {
        let scene = read(&with("/objects/0/relation", json!(name))).unwrap();
        assert_eq!(scene.objects[0].relation, relation);
        assert!(scene.to_json(Path::new(".")).contains(&format!("\"relation\": \"{name}\"")));
    }
    let roots = [
        ("floor", Root::Ground),
        ("floor-wall", Root::GroundWall),
        ("ground-wall", Root::GroundWall),
        ("wall", Root::Wall),
        ("ceiling", Root::Ceiling),
    ];
    for (name, root) in roots {
        let scene = read(&with("/objects/0/parent", json!(name))).unwrap();
        assert_eq!(scene.objects[0].parent, Parent::Root(root));
        assert!(scene.to_json(Path::new(".")).contains(&format!("\"parent\": \"{name}\"")));
    }
}

#[test]
fn the_tree_is_walked_children_first() {
    let object = |name: &str, parent: &str| json!({"name": name, "mesh": "meshes/mug.glb", "parent": parent});
    let scene = read(&minimal(json!([
        object("cup", "tray"),
        object("lamp", "ground"),
        object("tray", "desk"),
        object("desk", "ground-wall"),
        object("book", "desk"),
    ])))
    .unwrap();
    assert_eq!(scene.children(3).collect::<Vec<_>>(), [2, 4]);
    assert_eq!(scene.children(0).count(), 0);
    assert_eq!(scene.post_order(), [1, 0, 2, 4, 3]);
}

#[test]
fn what_is_static() {
    for (field, value, expected) in [
        ("parent", "ground", false),
        ("parent", "ground-wall", false),
        ("parent", "wall", true),
        ("parent", "ceiling", true),
        ("relation", "hang", true),
        ("relation", "attached", false),
    ] {
        let scene = read(&with(&format!("/objects/0/{field}"), json!(value))).unwrap();
        assert_eq!(scene.is_static(0), expected, "{field} {value}");
    }
    assert!(read(&with("/objects/0/movable", json!(false))).unwrap().is_static(0));
}

/// The uniform message: `FILE: object "x", field "y": problem; remedy`.
fn assert_error(result: Result<Scene, SceneError>, object: Option<&str>, field: Option<&str>, problem: &str) {
    let error = result.expect_err(problem);
    let message = error.to_string();
    let object = object.map_or(String::new(), |object| format!(" object \"{object}\""));
    let comma = if object.is_empty() { " " } else { ", " };
    let field = field.map_or(String::new(), |field| format!("{comma}field \"{field}\""));
    let colon = if object.is_empty() && field.is_empty() { "" } else { ":" };
    assert!(message.starts_with(&format!("{}:{object}{field}{colon} ", error.file.display())), "{message}");
    assert!(error.problem.contains(problem), "{message}");
    assert!(!error.remedy.is_empty() && message.ends_with(&format!("; {}", error.remedy)), "{message}");
    assert!(!message.contains('\n'), "{message}");
}

#[test]
fn every_error_of_the_contract_names_object_field_and_remedy() {
    let mug = |field: &'static str, value: Value, problem: &'static str| {
        (with(&format!("/objects/0/{field}"), value), Some("mug"), Some(field), problem)
    };
    let document = |pointer: &'static str, value: Value, field: &'static str, problem: &'static str| {
        (with(pointer, value), None, Some(field), problem)
    };
    let cases = [
        // The tree.
        mug("parent", json!("dsk"), "no \"dsk\""),
        mug("parent", json!("mug"), "its own parent"),
        mug("parent", json!(7), "7 is not a text"),
        (with("/objects/1/parent", json!("mug")), Some("mug"), Some("parent"), "mug → desk → mug"),
        (with("/objects/1/name", json!("mug")), Some("mug"), Some("name"), "objects[0] and objects[1]"),
        (with("/objects/0/name", json!(" ")), Some("objects[0]"), Some("name"), "empty"),
        (with("/objects/0/name", json!(3)), Some("objects[0]"), Some("name"), "3 is not a text"),
        (without("/objects/0/name"), Some("objects[0]"), Some("name"), "missing"),
        (with("/objects/0", json!([1])), Some("objects[0]"), None, "[1] is not a JSON object"),
        mug("relation", json!("under"), "\"under\" is not \"on\""),
        mug("movable", json!("yes"), "\"yes\" is not true or false"),
        mug("category", json!([]), "not a text"),
        // Files.
        mug("mesh", json!("meshes/cup.glb"), "meshes/cup.glb cannot be found"),
        mug("mesh", json!("meshes"), "meshes is not a file"),
        mug("mesh", json!(""), "not a file"),
        mug("mesh", json!("meshes/desk.glb/x"), "cannot be found"),
        (without("/objects/0/mesh"), Some("mug"), Some("mesh"), "missing"),
        mug("convex_parts", json!("meshes/mug_0.obj"), "not a list"),
        (
            with("/objects/0/convex_parts", json!(["meshes/mug_0.obj", "x.obj"])),
            Some("mug"),
            Some("convex_parts[1]"),
            "x.obj cannot be found",
        ),
        (with("/objects/0/convex_parts", json!([5])), Some("mug"), Some("convex_parts[0]"), "5 is not a text"),
        // Numbers.
        mug("position", json!([0, 1]), "not a list of 3"),
        mug("position", json!([0, 1, "2"]), "not a list of 3"),
        mug("position", json!({"x": 0}), "not a list of 3"),
        mug("position", json!([0, 1e9, 0]), "from the origin"),
        mug("rotation_xyzw", json!([0, 0, 0, 0]), "zeros"),
        mug("rotation_xyzw", json!([0, 0, 1]), "not a list of 4"),
        mug("scale", json!(0), "0 is not a number or a list of 3"),
        mug("scale", json!(-0.5), "-0.5 is not"),
        mug("scale", json!([1, 0, 1]), "[1,0,1] is not"),
        mug("scale", json!([1, 1]), "[1,1] is not"),
        mug("scale", json!("1"), "\"1\" is not"),
        mug("scale", json!(1e300), "out of range"),
        mug("scale", json!(1e-300), "out of range"),
        mug("mass", json!(0), "0 is not a finite number above 0"),
        mug("mass", json!(-1.5), "-1.5 is not"),
        mug("mass", json!("heavy"), "\"heavy\" is not"),
        mug("mass", json!(1e60), "out of range"),
        // The document.
        (json!([]), None, None, "[] is not a JSON object"),
        (json!({}), None, Some("format"), "missing"),
        document("/format", json!("gltf"), "format", "\"gltf\" is not \"rest3d-scene\""),
        document("/version", json!(2), "version", "2 is not 1"),
        document("/version", json!("1"), "version", "\"1\" is not 1"),
        (without("/version"), None, Some("version"), "missing"),
        (without("/objects"), None, Some("objects"), "missing"),
        document("/objects", json!({}), "objects", "not a list"),
        document("/name", json!(1), "name", "1 is not a text"),
        document("/frame", json!("Y"), "frame", "not a JSON object"),
        document("/frame/up", json!("X"), "frame.up", "\"X\" is not \"Y\" or \"Z\""),
        document("/frame/meters_per_unit", json!(0), "frame.meters_per_unit", "0 is not"),
        document("/frame/meters_per_unit", json!("cm"), "frame.meters_per_unit", "\"cm\" is not"),
        document("/room", json!([]), "room", "not a JSON object"),
        document("/room/ground", json!(true), "room.ground", "true is not a finite number"),
        document("/room/ceiling", json!("high"), "room.ceiling", "\"high\" is not"),
        document("/room/ground", json!(1e300), "room.ground", "from the origin"),
        document("/room/ceiling", json!(1e300), "room.ceiling", "from the origin"),
        document("/room/walls/0/point", json!([0, 1e300, 0]), "room.walls[0].point", "from the origin"),
        document("/room/walls", json!({}), "room.walls", "not a list"),
        document("/room/walls/0", json!(1), "room.walls[0]", "1 is not a JSON object"),
        document("/room/walls/0/normal", json!([0, 0, 0]), "room.walls[0].normal", "no direction"),
        document("/room/walls/0/point", json!([0]), "room.walls[0].point", "not a list of 3"),
        (without("/room/walls/0/normal"), None, Some("room.walls[0].normal"), "missing"),
    ];
    for (document, object, field, problem) in cases {
        assert_error(read(&document), object, field, problem);
    }
}

#[test]
fn the_nearest_name_is_suggested() {
    let remedy = |parent: &str| read(&with("/objects/0/parent", json!(parent))).unwrap_err().remedy;
    assert_eq!(remedy("dsk"), "did you mean \"desk\"?");
    assert_eq!(remedy("gruond"), "did you mean \"ground\"?");
    assert_eq!(remedy("refrigerator"), "name an object or one of ground, wall, ceiling, ground-wall");
    assert!(remedy(&"x".repeat(1_000_000)).starts_with("name an object"));
}

/// JSON has neither, but NaN is what Python writes and 1e999 overflows: the message still says where it stands.
#[test]
fn numbers_that_are_not_finite_are_errors_with_a_place() {
    for number in ["NaN", "Infinity", "-Infinity", "nan", "1e999", "-1e999"] {
        let folder = Folder::new();
        let text = full().to_string();
        let position = folder.read_text(text.replace("0.75", number));
        assert_error(position, Some("mug"), Some("position"), number);
        let mass = folder.read_text(text.replace("\"mass\":0.3", &format!("\"mass\":{number}")));
        assert_error(mass, Some("mug"), Some("mass"), number);
        // In a field that nobody reads, the line and column must do.
        let unknown = text.replace("\"mass\":0.3", &format!("\"note\": \"NaN \\\" 1e999\", \"x\":{number}"));
        assert_error(folder.read_text(unknown), None, None, "not valid JSON");
    }
}

#[test]
fn files_that_are_no_scene() {
    let folder = Folder::new();
    let text = full().to_string();
    assert_error(folder.read_text(""), None, None, "breaks off");
    assert_error(folder.read_text(&text[..300]), None, None, "breaks off");
    assert_error(folder.read_text("a scene"), None, None, "not valid JSON: expected value at line 1 column 1");
    assert_error(folder.read_text([b"{\"".as_slice(), &[0xff, 0xfe]].concat()), None, None, "UTF-8");
    assert_error(folder.read_text("[".repeat(100_000)), None, None, "not valid JSON");
    assert_error(Scene::read(&folder.path("absent.json")), None, None, "cannot be read");
    assert_error(Scene::read(&folder.path("meshes")), None, None, "neither a scene.json nor");
    fs::remove_file(folder.path("scene.json")).unwrap();
    fs::create_dir(folder.path("scene.json")).unwrap();
    assert_error(Scene::read(&folder.path("scene.json")), None, None, "neither a scene.json nor");
}

#[test]
fn a_size_is_checked_once_the_mesh_is_known() {
    let scene = read(&full()).unwrap();
    for good in [1e-3, 0.3, 100.0] {
        scene.check_size(0, good).unwrap();
    }
    for bad in [0.0, 9.9e-4, 100.1, f64::NAN, f64::INFINITY] {
        let error = scene.check_size(0, bad).unwrap_err();
        assert!(error.to_string().contains("scene.json: object \"mug\", field \"scale\": "));
        assert!(error.remedy.contains("meters_per_unit"));
    }
}

fn many(count: usize, parent: impl Fn(usize) -> String) -> Value {
    let object = |i| json!({"name": format!("object {i}"), "mesh": "meshes/mug.glb", "parent": parent(i)});
    minimal((0..count).map(object).collect())
}

#[test]
fn long_chains_and_many_objects_are_no_danger() {
    let chain = |i: usize| format!("object {}", i + 1);
    let folder = Folder::new();
    let count = 10_000;
    let document = many(count, |i| if i + 1 < count { chain(i) } else { "ground".to_owned() }).to_string();
    fs::write(folder.path("scene.json"), document).unwrap();
    let start = Instant::now();
    let scene = Scene::read(folder.0.path()).unwrap();
    // Linear time takes 50 ms here, quadratic time ten seconds.
    assert!(start.elapsed() < Duration::from_secs(1), "{:?}", start.elapsed());
    assert_eq!(scene.post_order(), (0..count).collect::<Vec<_>>());
    assert_eq!(scene.children(count - 1).next(), Some(count - 2));
    let ring = folder.read(&many(count, |i| format!("object {}", (i + 1) % count)));
    assert_error(ring, Some("object 0"), Some("parent"), "object 9999 → object 0");
    let typo = folder.read(&many(count, |_| "grund".to_owned()));
    assert_error(typo, Some("object 0"), Some("parent"), "no \"grund\"");
}

#[test]
fn a_tail_that_leads_into_a_cycle_is_not_part_of_it() {
    let object = |name: &str, parent: &str| json!({"name": name, "mesh": "meshes/mug.glb", "parent": parent});
    let objects = json!([object("t", "a"), object("a", "b"), object("b", "c"), object("c", "a")]);
    assert_error(read(&minimal(objects)), Some("a"), Some("parent"), "cycle: a → b → c → a");
}

#[test]
fn odd_but_valid_scenes_are_warned_about() {
    let warnings = |document: &Value| read(document).unwrap().warnings.join("\n");
    let quaternion = warnings(&with("/objects/0/rotation_xyzw", json!([0, 2, 0, 2])));
    assert!(quaternion.contains("object \"mug\", field \"rotation_xyzw\"") && quaternion.contains("2.8284"));
    assert!(warnings(&with("/objects/0/rotation_xyzw", json!([0, 0, 0, 1.0009]))).is_empty());
    assert!(warnings(&with("/room/ceiling", json!(-1))).contains("room.ceiling"));
    let mut document = full();
    for i in 0..2 {
        document["objects"][i]["colour"] = json!("red");
    }
    document["author"] = json!({"name": "x"});
    document["frame"]["hand"] = json!("right");
    document["room"]["walls"][0]["paint"] = json!(1);
    let lines = read(&document).unwrap().warnings;
    let fields = ["author", "frame.hand", "objects[].colour", "room.walls[].paint"];
    assert_eq!(lines.len(), 4, "{lines:?}");
    for (line, field) in lines.iter().zip(fields) {
        assert!(line.contains(&format!("field \"{field}\"")), "{line}");
    }
}

#[test]
fn tiny_and_huge_quaternions_keep_their_direction() {
    for size in [1e-300, 1e300] {
        let scene = read(&with("/objects/0/rotation_xyzw", json!([0.0, size, 0.0, size]))).unwrap();
        // Both components round to the double next to √½.
        let expected = DQuat::from_xyzw(0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2);
        assert!(scene.objects[0].pose.rotation.abs_diff_eq(expected, 1e-15));
    }
}

/// A Z-up scene in centimetres whose ground is at 10.
fn tilted() -> Value {
    let mut document = full();
    document["frame"] = json!({"up": "Z", "meters_per_unit": 0.01});
    document["room"] = json!({"ground": 10, "ceiling": 270, "walls": [{"point": [0, 220, 10], "normal": [0, -1, 0]}]});
    document["objects"][0]["position"] = json!([1, 2, 13]);
    document["objects"][0]["scale"] = json!([1, 2, 3]);
    document
}

#[test]
fn z_up_units_and_ground_are_converted() {
    let scene = read(&tilted()).unwrap();
    let near = |a: DVec3, b: DVec3| assert!(a.abs_diff_eq(b, 1e-15), "{a} {b}");
    let mug = &scene.objects[0];
    near(mug.pose.translation, DVec3::new(0.01, 0.03, -0.02));
    near(mug.scale, DVec3::new(0.01, 0.02, 0.03));
    // The mesh's own Z stays its Z and now points up.
    near(mug.pose.rotation * DVec3::Z, DVec3::Y);
    near(mug.pose.rotation * DVec3::Y, -DVec3::Z);
    near(scene.room.walls[0].point, DVec3::new(0.0, 0.0, -2.2));
    near(scene.room.walls[0].normal, DVec3::Z);
    assert!((scene.room.ceiling.unwrap() - 2.6).abs() < 1e-15);
}

#[test]
fn what_did_not_change_is_written_as_it_came() {
    let folder = Folder::new();
    let text = tilted()
        .to_string()
        .replace("[1,2,13]", "[0.1,1e-7,12345678901234567890]")
        .replace("[0,0,0,1]", "[0,0,0,1.0005]");
    let text = text
        .replace("12345678901234567890", "0.30000000000000004")
        .replace("\"name\":\"study\"", "\"name\":\"study\",\"seed\":18446744073709551615");
    let scene = folder.read_text(&text).unwrap();
    let written = scene.to_json(folder.0.path());
    assert_eq!(serde_json::from_str::<Value>(&written).unwrap(), serde_json::from_str::<Value>(&text).unwrap());
    assert_eq!(written, scene.to_json(folder.0.path()));
    assert!(written.ends_with("}\n") && written.contains("\n  \"version\": 1,\n"));
    // The order of the fields too.
    let order =
        ["\"format\"", "\"version\"", "\"seed\"", "\"frame\"", "\"objects\""].map(|field| written.find(field).unwrap());
    assert!(order.is_sorted());
}

#[test]
fn only_what_moved_is_written_anew() {
    let folder = Folder::new();
    let mut scene = folder.read(&tilted()).unwrap();
    scene.objects[0].pose.translation.y += 0.5;
    let written: Value = serde_json::from_str(&scene.to_json(folder.0.path())).unwrap();
    let numbers: Vec<f64> = serde_json::from_value(written["objects"][0]["position"].clone()).unwrap();
    assert!(DVec3::from_slice(&numbers).abs_diff_eq(DVec3::new(1.0, 2.0, 63.0), 1e-12));
    assert_eq!(written["objects"][0]["rotation_xyzw"], json!([0, 0, 0, 1]));
    scene.objects[1].pose.rotation *= DQuat::from_rotation_z(1.0);
    let written: Value = serde_json::from_str(&scene.to_json(folder.0.path())).unwrap();
    assert_eq!(written["objects"][1].get("position"), None);
    let turned: Vec<f64> = serde_json::from_value(written["objects"][1]["rotation_xyzw"].clone()).unwrap();
    assert!(DQuat::from_slice(&turned).abs_diff_eq(DQuat::from_rotation_z(1.0), 1e-15));
}

#[test]
fn paths_are_valid_from_the_new_folder() {
    let folder = Folder::new();
    let absolute = folder.path("meshes/desk.glb");
    let document = with("/objects/1/mesh", json!(absolute));
    let mut scene = folder.read(&document).unwrap();
    let out = folder.path("results/one");
    let written: Value = serde_json::from_str(&scene.to_json(&out)).unwrap();
    assert_eq!(written["objects"][0]["mesh"], "../../meshes/mug.glb");
    assert_eq!(written["objects"][0]["convex_parts"], json!(["../../meshes/mug_0.obj"]));
    assert_eq!(written["objects"][1]["mesh"], json!(absolute));
    scene.objects[0].convex_parts = vec![out.join("parts/mug_0.obj"), out.join("parts/mug_1.obj")];
    scene.objects[1].convex_parts = vec![folder.path("meshes/mug_1.obj")];
    let written: Value = serde_json::from_str(&scene.to_json(&out)).unwrap();
    assert_eq!(written["objects"][0]["convex_parts"], json!(["parts/mug_0.obj", "parts/mug_1.obj"]));
    assert_eq!(written["objects"][1]["convex_parts"], json!(["../../meshes/mug_1.obj"]));
    scene.objects[0].convex_parts.clear();
    let written: Value = serde_json::from_str(&scene.to_json(&out)).unwrap();
    assert_eq!(written["objects"][0].get("convex_parts"), None);
}

/// `..` from a folder that is reached through a link leads elsewhere than the path reads.
#[cfg(unix)]
#[test]
fn paths_are_valid_across_links() {
    let folder = Folder::new();
    let scene = folder.read(&full()).unwrap();
    let elsewhere = tempfile::tempdir().unwrap();
    fs::create_dir(elsewhere.path().join("deep")).unwrap();
    std::os::unix::fs::symlink(elsewhere.path().join("deep"), folder.path("out")).unwrap();
    let out = folder.path("out");
    fs::write(out.join("scene.json"), scene.to_json(&out)).unwrap();
    assert_eq!(Scene::read(&out).unwrap().objects.len(), 2);
}

#[test]
fn a_written_scene_is_read_again() {
    let folder = Folder::new();
    let mut scene = folder.read(&tilted()).unwrap();
    scene.objects[0].pose.translation.x = -1.25;
    let out = folder.path("out");
    fs::create_dir(&out).unwrap();
    fs::write(out.join("scene.json"), scene.to_json(&out)).unwrap();
    let again = Scene::read(&out).unwrap();
    assert!(again.objects[0].pose.translation.abs_diff_eq(scene.objects[0].pose.translation, 1e-15));
    assert_eq!(fs::canonicalize(&again.objects[0].mesh).unwrap(), fs::canonicalize(&scene.objects[0].mesh).unwrap());
    // And written again to the same bytes.
    assert_eq!(again.to_json(&out), scene.to_json(&out));
}

#[test]
#[cfg_attr(not(shared_files), ignore = "needs ../shared")]
fn shared_scenes_are_read_and_written() {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let mut count = 0;
    for kind in ["scenes", "scenes-rest3d"] {
        for folder in fs::read_dir(shared.join(kind))
            .unwrap()
            .map(|folder| folder.unwrap().path())
            .filter(|folder| folder.is_dir())
        {
            for file in ["scene.json", "raw.json", "truth.json", "rest3d.json"].map(|file| folder.join(file)) {
                if !file.is_file() {
                    continue;
                }
                let scene = Scene::read(&file).unwrap();
                let out = tempfile::tempdir().unwrap();
                fs::write(out.path().join("scene.json"), scene.to_json(out.path())).unwrap();
                let again = Scene::read(out.path()).unwrap();
                assert_eq!(again.objects.len(), scene.objects.len());
                assert!(again.objects.iter().zip(&scene.objects).all(|(a, b)| a.pose == b.pose), "{}", file.display());
                count += 1;
            }
        }
    }
    // 9 scenes of ours with raw input and truth, 5 of REST3D with its result, and the throughput scene.
    assert!(count >= 9 * 3 + 5 * 2, "{count}");
}

fn stage2(tree: &Value, meshes: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let objects = folder.path().join("stage2/scene_canon/obj_files");
    fs::create_dir_all(&objects).unwrap();
    for mesh in meshes {
        fs::write(objects.join(format!("scene_canon_{mesh}.obj")), "").unwrap();
    }
    fs::write(folder.path().join("stage2/scene_tree.json"), tree.to_string()).unwrap();
    folder
}

#[test]
fn a_stage2_folder_is_a_scene() {
    let tree = json!({
        "roots": ["floor", "wall"],
        "nodes": ["floor", "desk_000", {"name": "mug_001", "movable": true}, {"id": "shelf", "type": "fixed"}, "lamp"],
        "edges": [
            {"child": "desk_000", "parent": "floor", "relation": "on", "type": "movable"},
            {"child": "mug_001", "parent": "desk_000", "relation": "on", "type": "movable"},
            {"child": "mug_001", "parent": "shelf", "relation": "inside"},
            {"child": "shelf", "parent": "wall", "relation": "on-attach", "type": "fixed"},
            {"child": "red_ball_002", "parent": "floor-wall", "relation": "on", "type": "fixed"}
        ]
    });
    let folder = stage2(&tree, &["desk_000", "mug_001", "shelf", "lamp", "red_ball_002"]);
    let stage2 = folder.path().join("stage2");
    for path in [folder.path().to_path_buf(), stage2.clone(), stage2.join("scene_tree.json")] {
        let scene = Scene::read(&path).unwrap();
        let names: Vec<&str> = scene.objects.iter().map(|object| object.name.as_str()).collect();
        assert_eq!(names, ["desk_000", "mug_001", "shelf", "lamp", "red_ball_002"]);
        assert_eq!(scene.name, "stage2");
        assert!(scene.objects.iter().all(|object| object.pose == Pose::IDENTITY && object.scale == DVec3::ONE));
        assert_eq!(scene.objects[1].parent, Parent::Object(0));
        assert_eq!(
            (scene.objects[2].parent, scene.objects[2].relation),
            (Parent::Root(Root::Wall), Relation::Attached)
        );
        assert_eq!((scene.objects[2].movable, scene.objects[0].movable), (false, true));
        assert_eq!((scene.objects[4].parent, scene.objects[4].movable), (Parent::Root(Root::GroundWall), false));
        assert_eq!(scene.objects[4].category, "red ball");
        assert_eq!(scene.objects[0].mesh, path_of(&scene, "scene_canon/obj_files/scene_canon_desk_000.obj"));
        // The second parent of the mug, and the lamp that stands on nothing.
        assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
        assert!(scene.warnings[0].contains("object \"mug_001\", field \"edges[2]\""), "{}", scene.warnings[0]);
        assert!(scene.warnings[1].contains("object \"lamp\""), "{}", scene.warnings[1]);
        let written = scene.to_json(&stage2);
        assert!(written.contains("\"parent\": \"ground\"") && written.contains("\"relation\": \"attached\""));
    }
}

fn path_of(scene: &Scene, path: &str) -> PathBuf {
    scene.file.parent().unwrap().join(path)
}

#[test]
fn a_damaged_stage2_folder_is_an_error() {
    let object = json!({"name": "desk"});
    for (tree, object, field, problem) in [
        (json!({}), None, Some("nodes"), "missing"),
        (json!({"nodes": {}}), None, Some("nodes"), "not a list"),
        (json!({"nodes": [7]}), None, Some("nodes[0]"), "no name"),
        (json!({"nodes": [""]}), None, Some("nodes[0]"), "no name"),
        (json!({"nodes": [object], "edges": 1}), None, Some("edges"), "not a list"),
        (json!({"nodes": [object], "edges": [{"child": "desk"}]}), None, Some("edges[0].parent"), "missing"),
        (json!({"nodes": ["mug"]}), Some("mug"), Some("mesh"), "scene_canon_mug.obj cannot be found"),
        (
            json!({"nodes": [object], "edges": [{"child": "desk", "parent": "moon"}]}),
            Some("desk"),
            Some("parent"),
            "no \"moon\"",
        ),
        (
            json!({"nodes": [object], "edges": [{"child": "desk", "parent": "floor", "relation": "near"}]}),
            Some("desk"),
            Some("relation"),
            "near",
        ),
    ] {
        let folder = stage2(&tree, &["desk"]);
        assert_error(Scene::read(folder.path()), object, field, problem);
    }
}

/// Every place in a document, as JSON pointers.
fn pointers(value: &Value, at: &str, all: &mut Vec<String>) {
    all.push(at.to_owned());
    match value {
        Value::Array(list) => list.iter().enumerate().for_each(|(i, v)| pointers(v, &format!("{at}/{i}"), all)),
        Value::Object(map) => map.iter().for_each(|(key, v)| pointers(v, &format!("{at}/{key}"), all)),
        _ => {}
    }
}

fn any_value() -> impl Strategy<Value = Value> {
    prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        any::<i64>().prop_map(Value::from),
        any::<f64>().prop_map(Value::from),
        prop::sample::select(vec![
            "",
            "mug",
            "desk",
            "ground",
            "floor-wall",
            "hang",
            "meshes/mug_1.obj",
            "..",
            "\0",
            "Z"
        ])
        .prop_map(Value::from),
        prop::collection::vec(-2.0..2.0, 0..5).prop_map(Value::from),
        Just(json!({})),
        Just(json!([{}])),
    ]
}

/// Either an error in the uniform shape, or a scene that is written and read again.
fn survives(folder: &Folder, text: &[u8]) {
    match folder.read_text(text) {
        Err(error) => assert!(error.to_string().starts_with(&format!("{}:", error.file.display()))),
        Ok(scene) => {
            assert_eq!(scene.post_order().len(), scene.objects.len());
            let written = scene.to_json(folder.0.path());
            assert_eq!(folder.read_text(written).unwrap().objects, scene.objects);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn poses_survive_the_way_out_and_back(
        up in prop::sample::select(vec!["Y", "Z"]),
        unit in 1e-3..1e3f64,
        ground in -10.0..10.0f64,
        place in prop::array::uniform3(-10.0..10.0f64),
        quaternion in prop::array::uniform4(-1.0..1.0f64),
        shift in prop::array::uniform3(-1.0..1.0f64),
        turn in prop::array::uniform3(-1.0..1.0f64),
    ) {
        prop_assume!(DQuat::from_array(quaternion).length() > 0.1);
        let mut document = full();
        document["frame"] = json!({"up": up, "meters_per_unit": unit});
        document["room"] = json!({"ground": ground});
        document["objects"][0]["position"] = json!(place);
        document["objects"][0]["rotation_xyzw"] = json!(quaternion);
        let folder = Folder::new();
        let mut scene = folder.read(&document).unwrap();
        let unmoved: Value = serde_json::from_str(&scene.to_json(folder.0.path())).unwrap();
        prop_assert_eq!(&unmoved, &document);
        let pose = &mut scene.objects[0].pose;
        pose.translation += DVec3::from(shift);
        pose.rotation = (DQuat::from_scaled_axis(turn.into()) * pose.rotation).normalize();
        let again = folder.read_text(scene.to_json(folder.0.path())).unwrap();
        // Rounding of a handful of operations on numbers of this size.
        let tolerance = 1e-12 * (unit * 10.0).max(1.0);
        prop_assert!(again.objects[0].pose.translation.abs_diff_eq(scene.objects[0].pose.translation, tolerance));
        prop_assert!(again.objects[0].pose.rotation.abs_diff_eq(scene.objects[0].pose.rotation, 1e-12));
    }

    #[test]
    fn changed_values_are_survived(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any_value()), 1..4),
    ) {
        let mut document = full();
        for (at, value) in changes {
            let mut all = Vec::new();
            pointers(&document, "", &mut all);
            *document.pointer_mut(&all[at.index(all.len())]).unwrap() = value;
        }
        survives(&Folder::new(), document.to_string().as_bytes());
    }

    #[test]
    fn changed_bytes_are_survived(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        length in any::<prop::sample::Index>(),
        cut in any::<bool>(),
    ) {
        let mut bytes = full().to_string().into_bytes();
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if cut {
            bytes.truncate(length.index(bytes.len()));
        }
        survives(&Folder::new(), &bytes);
    }

    #[test]
    fn changed_trees_are_survived(
        at in any::<prop::sample::Index>(),
        value in any_value(),
    ) {
        let mut tree = json!({"roots": ["floor"], "nodes": ["desk", {"name": "mug", "movable": true}], "edges": [
            {"child": "desk", "parent": "floor", "relation": "on", "type": "movable"},
            {"child": "mug", "parent": "desk", "relation": "on", "type": "movable"}
        ]});
        let mut all = Vec::new();
        pointers(&tree, "", &mut all);
        *tree.pointer_mut(&all[at.index(all.len())]).unwrap() = value;
        let folder = stage2(&tree, &["desk", "mug"]);
        if let Err(error) = Scene::read(folder.path()) {
            prop_assert!(error.to_string().contains("scene_tree.json"));
        }
    }
}
