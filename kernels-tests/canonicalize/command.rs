//! The command, and `optimize --canonicalize`.

use crate::common::program::program;
use crate::fixture::*;
use glam::DVec3;
use rest3d_gpu::scene::{Pose, Scene};
use serde_json::{Value, json};
use std::fs;
use std::process::Output;

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
    let mut replay = program();
    replay.arg("simulate").arg(case.folder.path()).arg("--run").arg(case.folder.path().join("out"));
    replay.arg("--replay").arg(format!("{stage},{},{}", winner[0], winner[1]));
    let output = replay.output().unwrap();
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
    let output = program().arg("canonicalize").arg(case.folder.path()).arg("-o").arg(case.folder.path()).output();
    assert_eq!(output.unwrap().status.code(), Some(2), "the input is not replaced");
}
