//! `bench` and its sweeps.

use crate::common::program::program;
use crate::fixture::*;
use serde_json::{Value, json};
use std::fs;

#[test]
fn bench_measures_speed_and_quality() {
    let case = Case::new(&table());
    let quick = ["--candidates", "8", "--seconds", "0"];
    let output = case.command("bench").args(quick).arg("--json").output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let measured: Value = serde_json::from_slice(&output.stdout).unwrap();
    let keys: Vec<&str> = measured.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(
        keys,
        [
            "backend",
            "adapter",
            "candidates",
            "bodies",
            "hulls",
            "contacts_per_substep",
            "candidates_per_s",
            "env_substeps_per_s",
            "body_substeps_per_s",
            "kernels_ms",
            "bytes_resident",
            "mean_drift_m",
            "flagged_candidates"
        ]
    );
    assert_eq!((&measured["backend"], &measured["candidates"]), (&json!("cpu"), &json!(8)));
    assert_eq!(
        (&measured["bodies"], &measured["hulls"], &measured["flagged_candidates"]),
        (&json!(3), &json!(3), &json!(0))
    );
    let number = |key: &str| measured[key].as_f64().unwrap();
    let drift = number("mean_drift_m");
    assert!((0.001..0.2).contains(&drift), "the table falls by 2 cm: {drift}");
    assert!(number("contacts_per_substep") > 4.0 && number("bytes_resident") > 0.0);
    assert!((number("env_substeps_per_s") / number("candidates_per_s") - 120.0).abs() < 1e-6);
    assert!(measured["kernels_ms"]["solve"].as_f64().unwrap() > 0.0);

    let output = case.command("bench").args(quick).output().unwrap();
    let table = text(&output.stdout);
    for word in ["backend", "candidates/s", "env-substeps/s", "ms in solve", "mean drift", "flagged"] {
        assert!(table.contains(word), "no {word:?} in {table}");
    }
}

#[test]
fn bench_sweeps_draw_curves() {
    let case = Case::new(&table());
    let curves = case.path("curves.svg");
    let mut command = case.command("bench");
    command.args(["--sweep", "--candidates", "2", "--seconds", "0", "--json", "-o"]).arg(&curves);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let sweep: Value = serde_json::from_slice(&output.stdout).unwrap();
    let sizes = |curve: &str, key: &str| -> Vec<u64> {
        sweep[curve].as_array().unwrap().iter().map(|measured| measured[key].as_u64().unwrap()).collect()
    };
    assert_eq!(sizes("candidates", "candidates"), [2]);
    assert_eq!(sizes("bodies", "bodies"), [4, 8, 12, 20, 30]);
    assert_eq!(sizes("hulls", "hulls"), [3, 6, 12, 24]);
    let svg = fs::read_to_string(&curves).unwrap();
    let document = roxmltree::Document::parse(&svg).unwrap();
    let circles = document.descendants().filter(|node| node.has_tag_name("circle")).count();
    assert_eq!(circles, 10, "a dot a measurement");
}

#[test]
fn bench_refuses_what_it_cannot_measure() {
    let case = Case::new(&table());
    for (arguments, words) in [
        (&["--candidates", "0"][..], &["--candidates"][..]),
        (&["--candidates", "4000000000"], &["fewer candidates"]),
        (&["--seconds", "5000"], &["3600"]),
        (&["--seconds", "nan"], &["seconds"]),
        (&["-o", "x.svg"], &["--sweep"]),
        (&["--backend", "cpu", "--adapter", "0"], &["--adapter"]),
    ] {
        refuses(&case, case.command("bench").args(arguments), words);
    }
    refuses(&case, case.command("bench").args(["--sweep", "-o"]).arg(case.path("cube.obj/x.svg")), &["cube.obj"]);
    refuses(&case, case.command("bench").args(["--sweep", "-o"]).arg(case.path("cube.obj")), &["cube.obj", "input"]);
    let mut still = table();
    for object in still["objects"].as_array_mut().unwrap() {
        object["movable"] = json!(false);
    }
    let still = Case::new(&still);
    refuses(&still, &mut still.command("bench"), &["movable"]);
    refuses(&case, program().arg("bench").current_dir(case.folder.path()), &["scenes/study", "name a scene"]);
}
