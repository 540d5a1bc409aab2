//! Every error of the contract, and odd scenes that are none.

use crate::fixture::*;
use glam::DQuat;
use rest3d_gpu::import;
use rest3d_gpu::scene::Scene;
use serde_json::{Value, json};
use std::f64::consts::FRAC_1_SQRT_2;
use std::fs;
use std::time::{Duration, Instant};

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
        mug("mass", json!(1e-30), "out of range (1e-12 to 1e10 kg)"),
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
    assert_error(import::read(&folder.path("absent.json")), None, None, "cannot be read");
    assert_error(import::read(&folder.path("meshes")), None, None, "neither a scene.json nor");
    fs::remove_file(folder.path("scene.json")).unwrap();
    fs::create_dir(folder.path("scene.json")).unwrap();
    assert_error(import::read(&folder.path("scene.json")), None, None, "neither a scene.json nor");
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
