//! What `optimize` leaves on disk, prints and resumes.

use crate::common::meshes::CUBE;
use crate::common::program::program;
use crate::fixture::*;
use rest3d_gpu::shape::PADDING;
use serde_json::{Value, json};
use std::fs;
use std::process::{Command, Stdio};

/// Once for all objects, with a remedy.
#[test]
fn a_cache_that_cannot_be_used_is_told() {
    let case = Case::new(&table());
    let mut command = case.command("evaluate");
    let output = command.env("REST3D_GPU_CACHE", case.path("cube.obj")).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let told = text(&output.stderr);
    assert_eq!(told.matches("warning: shape cache").count(), 1, "{told}");
    assert!(told.contains("cube.obj is not usable") && told.contains("REST3D_GPU_CACHE"), "{told}");
}

#[test]
fn optimize_leaves_a_whole_result_and_its_input_alone() {
    let mut input = table();
    input["note"] = json!("kept");
    let case = Case::new(&input);
    let before = tree(case.folder.path());
    let output = case.optimize("out", &TINY);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("stable"), "{}", text(&output.stdout));

    let mut names: Vec<String> = fs::read_dir(case.path("out"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["energy.csv", "parts", "report.html", "report.json", "scene.json"]);
    let after = tree(case.folder.path());
    assert!(before.iter().all(|file| after.contains(file)), "the input changed");

    let scene: Value = serde_json::from_slice(&fs::read(case.path("out/scene.json")).unwrap()).unwrap();
    assert_eq!(scene["note"], "kept");
    let report: Value = serde_json::from_slice(&fs::read(case.path("out/report.json")).unwrap()).unwrap();
    let reported = report["objects"].as_array().unwrap().iter().map(|object| object["mass"].as_f64().unwrap() as f32);
    let masses = scene["objects"].as_array().unwrap().iter().map(|object| object["mass"].as_f64().unwrap() as f32);
    assert!(masses.eq(reported), "every mass that was guessed is stated");
    for (object, original) in scene["objects"].as_array().unwrap().iter().zip(input["objects"].as_array().unwrap()) {
        assert_eq!(object["name"], original["name"]);
        assert_ne!(object["position"], original["position"], "everything floated or overlapped");
        let out = case.path("out");
        let mesh = out.join(object["mesh"].as_str().unwrap());
        assert_eq!(mesh.canonicalize().unwrap(), case.path("cube.obj").canonicalize().unwrap());
        for part in object["convex_parts"].as_array().unwrap() {
            let part = part.as_str().unwrap();
            assert!(part.starts_with("parts/") && out.join(part).is_file(), "{part}");
        }
    }
    assert_eq!(scene["objects"][2]["convex_parts"], json!(["parts/right_box_0.obj"]));
    // Parts are in the mesh's frame: that of a unit cube is the unit cube, padded in metres.
    let part = fs::read_to_string(case.path("out/parts/table_0.obj")).unwrap();
    let sides = [1.0, 0.5, 0.6].map(|size| 0.5 + PADDING / size);
    let corner = |line: &str| {
        let coordinates = line.split(' ').skip(1).map(|c| c.parse::<f32>().unwrap().abs());
        coordinates.zip(sides).all(|(c, side)| (c - side).abs() < 1e-6)
    };
    assert_eq!(part.lines().filter(|line| line.starts_with("v ") && corner(line)).count(), 8);

    // The result is a scene like any other.
    let again = program().arg("simulate").arg(case.path("out")).output().unwrap();
    assert!(again.status.success(), "{}", text(&again.stderr));
}

#[test]
fn the_report_says_what_happened() {
    let case = Case::new(&table());
    let report = case.report(&TINY);
    let on_disk: Value = serde_json::from_slice(&fs::read(case.path("out/report.json")).unwrap()).unwrap();
    assert_eq!(report, on_disk);
    assert_eq!(report["finished"], true);
    assert_eq!(report["seed"], 0);
    assert_eq!(report["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(report["config"]["local"]["candidates"], 16);
    assert_eq!(report["config"]["global"]["iterations"], 3);
    assert_eq!(report["objects"][0]["shape"]["parts"], 1);
    // The table hung 20 mm above the ground. It may end a little higher or lower by the search's shifts, not stay.
    assert!(report["objects"][0]["moved"].as_f64().unwrap() > 0.01, "{}", report["objects"][0]);
    for object in report["objects"].as_array().unwrap() {
        for term in ["stability", "velocity", "penetration", "layout"] {
            assert!(object["check"]["terms"][term].as_f64().unwrap() >= 0.0, "{object}");
        }
        assert!(object["check"]["terms"]["penetration"].as_f64().unwrap() < 1e-3, "{object}");
    }
    assert_eq!(report["iterations"][0]["status"]["contacts over capacity"], 0, "{}", report["iterations"][0]);
    let groups: Vec<&str> =
        report["groups"].as_array().unwrap().iter().map(|group| group["name"].as_str().unwrap()).collect();
    assert_eq!(groups, ["table", "global"]);

    let csv = fs::read_to_string(case.path("out/energy.csv")).unwrap();
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().all(|line| line.split(',').count() == columns), "{csv}");
    assert_eq!(csv.lines().count(), 1 + report["iterations"].as_array().unwrap().len());
}

/// A box whose given part reaches 2 cm below its mesh.
#[test]
fn what_floats_on_its_parts_is_named() {
    let mut floating = cuboid("crate", "ground", [0.0, 0.12, 0.0], [0.2, 0.2, 0.2]);
    floating["convex_parts"] = json!(["long.obj"]);
    let case = Case::new(&scene(vec![floating, cuboid("box", "ground", [0.5, 0.1, 0.0], [0.2, 0.2, 0.2])]));
    fs::write(case.path("long.obj"), CUBE.replace("-0.5 ", "-0.6 ")).unwrap();
    let notes = case.report(&TINY)["notes"].to_string();
    assert!(notes.contains("\\\"crate\\\" rests 20 mm above the meshes under it"), "{notes}");
    assert!(!notes.contains("\\\"box\\\" rests"), "{notes}");
}

#[test]
fn with_json_stdout_holds_one_object_and_nothing_else() {
    let case = Case::new(&table());
    let optimized = case.optimize("out", &[&TINY[..], &["--json"]].concat());
    let to_stdout = case.command("simulate").arg("--json").output().unwrap();
    let to_file = case.command("simulate").arg("--json").arg("-o").arg(case.path("states.json")).output().unwrap();
    for output in [&optimized, &to_stdout, &to_file] {
        assert!(output.status.success(), "{}", text(&output.stderr));
        let value: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(value.is_object());
    }
    assert_eq!(
        serde_json::from_slice::<Value>(&to_stdout.stdout).unwrap(),
        serde_json::from_slice::<Value>(&fs::read(case.path("states.json")).unwrap()).unwrap()
    );
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let case = Case::new(&table());
    for (out, more) in [("a", ["--threads", "1"]), ("b", ["--threads", "2"]), ("c", ["--seed", "1"])] {
        assert!(case.optimize(out, &[&TINY[..], &more].concat()).status.success());
    }
    let result = |out: &str| fs::read(case.path(out).join("scene.json")).unwrap();
    assert!(result("a") == result("b"));
    assert!(result("a") != result("c"), "the seed has no effect");
}

/// Both the interruption and the checkpoint are seen: the run is stopped in the global stage, after the table's group.
#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_its_best_and_resumes_to_the_same_bytes() {
    use std::io::{BufRead, BufReader};

    let case = Case::new(&table());
    // A search that nothing stops early, and long enough for the signal to arrive: seconds on one thread.
    let config = "[local]\ncandidates = 32\niterations = 4\nstop_energy = 0.0\n\
                  [global]\ncandidates = 32\niterations = 100\nstop_energy = 0.0\n[settle]\nmax_seconds = 1.0\n";
    fs::write(case.path("long.toml"), config).unwrap();
    let command = |out: &str| {
        let mut command = case.command("optimize");
        command.arg("-o").arg(case.path(out)).arg("--config").arg(case.path("long.toml")).args(["--threads", "1"]);
        command
    };
    assert!(command("whole").output().unwrap().status.success());

    let mut child = command("parts").stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    let mut messages = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    assert!(messages.any(|line| line.contains("table") && line.contains("energy")), "no group was reported");
    // Two at once are one: a program that sends them to a process and to its group means a clean end.
    let signals = format!("kill -INT {0} && kill -TERM {0}", child.id());
    assert!(Command::new("sh").args(["-c", &signals]).status().unwrap().success());
    let rest: Vec<String> = messages.collect();
    assert_eq!(child.wait().unwrap().code(), Some(1), "{rest:?}");
    assert!(rest.iter().any(|line| line.contains("--resume")), "{rest:?}");
    let report: Value = serde_json::from_slice(&fs::read(case.path("parts/report.json")).unwrap()).unwrap();
    assert_eq!(report["finished"], false);
    assert!(case.path("parts/scene.json").is_file() && case.path("parts/checkpoint.json").is_file());

    // Another seed is another run: the checkpoint does not fit it.
    refuses(&case, command("parts").args(["--resume", "--seed", "5"]), &["checkpoint", "seed"]);

    assert!(command("parts").arg("--resume").output().unwrap().status.success());
    assert!(!case.path("parts/checkpoint.json").exists());
    let result = |out: &str| fs::read(case.path(out).join("scene.json")).unwrap();
    assert!(result("whole") == result("parts"), "the resumed run ended elsewhere");
}

#[test]
fn resuming_without_a_checkpoint_starts_anew_and_a_broken_one_is_refused() {
    let case = Case::new(&table());
    let output = case.optimize("out", &[&TINY[..], &["--resume"]].concat());
    assert!(output.status.success() && text(&output.stderr).contains("no checkpoint"), "{}", text(&output.stderr));
    fs::write(case.path("out/checkpoint.json"), "{\"version\": ").unwrap();
    let told = text(&case.command("optimize").arg("-o").arg(case.path("out")).args(TINY).output().unwrap().stderr);
    assert!(told.contains("checkpoint.json: a run that was stopped could go on with --resume"), "{told}");
    fs::write(case.path("out/checkpoint.json"), "{\"version\": ").unwrap();
    let mut command = case.command("optimize");
    refuses(&case, command.arg("-o").arg(case.path("out")).arg("--resume"), &["checkpoint.json"]);
}
