//! Frames, and what is written back.

use crate::fixture::*;
use glam::{DQuat, DVec3};
use rest3d_gpu::scene::Scene;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

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
    assert_eq!((&written["objects"][0]["mass"], written["objects"][1].get("mass")), (&json!(0.3), None));
    scene.objects[1].mass = Some(2.5);
    scene.objects[0].convex_parts.clear();
    let written: Value = serde_json::from_str(&scene.to_json(&out)).unwrap();
    assert_eq!(written["objects"][0].get("convex_parts"), None);
    assert_eq!(written["objects"][1]["mass"], 2.5);
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
