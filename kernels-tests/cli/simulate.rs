//! `simulate` and its replay.

use crate::fixture::*;
use serde_json::{Value, json};

#[test]
fn simulate_writes_all_states_in_the_frame_of_the_file() {
    // Z up, centimetres: a box falls freely from 1 m, another is held.
    let input = json!({
        "format": "rest3d-scene", "version": 1, "frame": {"up": "Z", "meters_per_unit": 0.01},
        "objects": [
            {"name": "ball", "mesh": "cube.obj", "position": [3, 5, 100], "scale": 20},
            {"name": "nail", "mesh": "cube.obj", "position": [70, 5, 100], "scale": 20, "movable": false},
        ]
    });
    let case = Case::new(&input);
    let output = case.command("simulate").args(["--steps", "12"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let states: Value = serde_json::from_slice(&output.stdout).unwrap();
    let dt = states["dt"].as_f64().unwrap();
    assert!((dt - 1.0 / 60.0).abs() < 1e-8);
    let (ball, nail) = (&states["objects"][0], &states["objects"][1]);
    assert_eq!(ball["poses"].as_array().unwrap().len(), 13);
    assert_eq!(ball["velocities"].as_array().unwrap().len(), 13);
    for (start, expected) in ball["poses"][0].as_array().unwrap().iter().zip([3.0, 5.0, 100.0, 0.0, 0.0, 0.0, 1.0]) {
        // Z up and back turns by a quaternion and its inverse: rounding of f64.
        assert!((start.as_f64().unwrap() - expected).abs() < 1e-12, "{start}");
    }
    assert_eq!(nail["poses"][12], nail["poses"][0]);
    assert_eq!(nail["velocities"][12], json!([0.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
    // 0.2 s of fall: 980 cm/s² · 0.2 s; 3 % for the damping of 0.3 per second.
    let speed = ball["velocities"][12][2].as_f64().unwrap();
    assert!((speed + 196.0).abs() < 0.03 * 196.0, "{speed}");
    let height = ball["poses"][12][2].as_f64().unwrap();
    // 19.6 cm; 10 % for steps of finite length and damping.
    assert!((100.0 - height - 19.6).abs() < 2.0, "{height}");
    assert!((ball["poses"][12][0].as_f64().unwrap() - 3.0).abs() < 1e-4);
}

#[test]
fn a_candidate_of_a_finished_run_is_replayed() {
    let input = table();
    let case = Case::new(&input);
    let report = case.report(&TINY);
    let winner = &report["groups"][0]["winner"];
    let replay = |candidate: &str| {
        let mut command = case.command("simulate");
        command.args(["--replay", candidate]).arg("--run").arg(case.path("out"));
        command
    };
    let winner = format!("0,{},{}", winner[0], winner[1]);
    let output = replay(&winner).output().unwrap();
    let messages = text(&output.stderr);
    assert!(output.status.success() && !messages.contains("otherwise"), "{messages}");
    let states: Value = serde_json::from_slice(&output.stdout).unwrap();
    let table = states["objects"][0]["poses"].as_array().unwrap();
    assert_eq!(table.len(), 61);
    assert!(table.iter().all(|pose| pose == &table[0]), "the table is held while its boxes are searched");
    assert_ne!(states["objects"][1]["poses"][0], states["objects"][1]["poses"][60]);
    assert_eq!(replay(&winner).args(["--steps", "3"]).output().unwrap().status.code(), Some(0));
    for (candidate, words) in [
        ("9,0,0", &["stage 9"][..]),
        ("0,99,0", &["iteration 99"]),
        ("0,0,256", &["candidate 256", "has 256"]),
        ("0,0", &["three numbers"]),
        ("0,0,x", &["three numbers"]),
        ("-1,0,0", &["three numbers"]),
    ] {
        refuses(&case, &mut replay(candidate), words);
    }
    refuses(&case, case.command("simulate").args(["--replay", "0,0,0"]), &["--run"]);
    let mut elsewhere = case.command("simulate");
    refuses(
        &case,
        elsewhere.args(["--replay", "0,0,0", "--run"]).arg(case.path("nowhere")),
        &["report.json", "optimize"],
    );
    let mut renamed = input.clone();
    renamed["objects"][2]["name"] = json!("somebody else's");
    let other = Case::new(&renamed);
    let mut of_another = other.command("simulate");
    refuses(
        &other,
        of_another.args(["--replay", &winner, "--run"]).arg(case.path("out")),
        &["report.json", "another scene"],
    );
}
