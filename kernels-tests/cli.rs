//! The command line as a user meets it: exit codes, what stands on stdout, what is left on disk.
//!
//! Scenes are made of boxes in temporary folders, so that a run takes seconds.
#![allow(clippy::unwrap_used)]

use rest3d_gpu::shape::PADDING;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

/// Unit cube around the origin.
const CUBE: &str = "\
v -0.5 -0.5 -0.5\nv 0.5 -0.5 -0.5\nv 0.5 0.5 -0.5\nv -0.5 0.5 -0.5
v -0.5 -0.5 0.5\nv 0.5 -0.5 0.5\nv 0.5 0.5 0.5\nv -0.5 0.5 0.5
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 5 8 4\nf 2 3 7 6\n";

/// A small search: enough to see all stages.
const TINY: [&str; 4] = ["--candidates", "16", "--iterations", "3"];

/// A folder with a mesh and a scene, removed at the end.
struct Case {
    folder: TempDir,
}

impl Case {
    fn new(scene: &Value) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("cube.obj"), CUBE).unwrap();
        fs::write(folder.path().join("scene.json"), scene.to_string()).unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, name: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rest3d-gpu"));
        command.arg(name).arg(self.folder.path()).env("REST3D_GPU_CACHE", cache());
        command
    }

    /// Without pictures: those are drawn in tests of their own.
    fn optimize(&self, out: &str, more: &[&str]) -> Output {
        self.command("optimize").arg("--no-pictures").arg("-o").arg(self.path(out)).args(more).output().unwrap()
    }

    /// Optimizes and returns the report.
    fn report(&self, more: &[&str]) -> Value {
        let output = self.optimize("out", &[&["--json"], more].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    }
}

/// Shared by all tests: entries are found by their content and written in one step.
fn cache() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("shapes")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn cuboid(name: &str, parent: &str, position: [f64; 3], size: [f64; 3]) -> Value {
    json!({"name": name, "mesh": "cube.obj", "position": position, "scale": size, "parent": parent})
}

fn scene(objects: Vec<Value>) -> Value {
    json!({"format": "rest3d-scene", "version": 1, "name": "boxes", "objects": objects})
}

/// A table that hangs in the air with two boxes that overlap it and each other.
fn table() -> Value {
    scene(vec![
        cuboid("table", "ground", [0.0, 0.27, 0.0], [1.0, 0.5, 0.6]),
        cuboid("left box", "table", [-0.05, 0.6, 0.0], [0.2, 0.2, 0.2]),
        cuboid("right/box", "table", [0.1, 0.63, 0.02], [0.2, 0.2, 0.2]),
    ])
}

/// Everything below a folder, with its bytes.
fn tree(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path.clone());
                files.push((path, Vec::new()));
            } else {
                let bytes = fs::read(&path).unwrap();
                files.push((path, bytes));
            }
        }
    }
    files.sort();
    files
}

/// Refused with exit code 2 and a message that holds all of `words`; nothing written, nothing on stdout.
fn refuses(case: &Case, command: &mut Command, words: &[&str]) {
    let before = tree(case.folder.path());
    let output = command.output().unwrap();
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{command:?}: {message}");
    assert!(output.stdout.is_empty(), "{command:?}: {}", text(&output.stdout));
    for word in words {
        assert!(message.contains(word), "{command:?}: no {word:?} in: {message}");
    }
    assert!(!message.contains("panicked") && !message.contains("Error {"), "{message}");
    assert!(tree(case.folder.path()) == before, "{command:?} wrote something");
}

#[test]
fn bad_scenes_are_refused_and_nothing_is_written() {
    let good = table();
    let with = |pointer: &str, value: Value| {
        let mut scene = good.clone();
        *scene.pointer_mut(pointer).unwrap() = value;
        scene
    };
    let first = |field: &str, value: Value| {
        let mut scene = good.clone();
        scene["objects"][0][field] = value;
        scene
    };
    for (scene, words) in [
        (with("/format", json!("other")), &["format"][..]),
        (with("/version", json!(7)), &["version"]),
        (first("parent", json!("cupboard")), &["table", "parent", "cupboard"]),
        (first("parent", json!("left box")), &["parent"]),
        (first("name", json!("left box")), &["left box", "name"]),
        (first("mesh", json!("absent.obj")), &["table", "mesh", "absent.obj"]),
        (first("scale", json!(0.0)), &["table", "scale"]),
        (first("scale", json!(1e6)), &["table", "scale"]),
        (first("scale", json!(1e-5)), &["table", "scale"]),
        (first("rotation_xyzw", json!([0, 0, 0, 0])), &["table", "rotation_xyzw"]),
        (first("position", json!([0, "NaN", 0])), &["table", "position"]),
        (first("mass", json!(-1.0)), &["table", "mass"]),
    ] {
        let case = Case::new(&scene);
        let out = case.path("out");
        refuses(&case, case.command("optimize").arg("-o").arg(&out), &[&["scene.json"], words].concat());
        refuses(&case, case.command("simulate").arg("-o").arg(&out), words);
    }
}

#[test]
fn files_that_are_not_what_they_should_be_are_refused() {
    let case = Case::new(&table());
    fs::write(case.path("scene.json"), &table().to_string()[..120]).unwrap();
    refuses(&case, &mut case.command("optimize"), &["scene.json"]);
    fs::write(case.path("scene.json"), [0xff, 0xfe, 0x00]).unwrap();
    refuses(&case, &mut case.command("optimize"), &["scene.json"]);
    fs::remove_file(case.path("scene.json")).unwrap();
    refuses(&case, &mut case.command("optimize"), &["scene.json"]);

    let mut scene = table();
    scene["objects"][1]["mesh"] = json!("broken.glb");
    let case = Case::new(&scene);
    fs::write(case.path("broken.glb"), "solid nonsense").unwrap();
    refuses(&case, &mut case.command("optimize"), &["scene.json", "left box", "mesh", "broken.glb"]);

    let mut missing = Command::new(env!("CARGO_BIN_EXE_rest3d-gpu"));
    refuses(&case, missing.arg("optimize").arg(case.path("nowhere")), &["nowhere"]);
}

#[test]
fn bad_usage_is_refused_and_nothing_is_written() {
    let case = Case::new(&table());
    let out = case.path("out");
    for (arguments, words) in [
        (&["--candidates", "0"][..], &["--candidates"][..]),
        (&["--candidates", "4000000000"], &["candidates"]),
        (&["--iterations", "0"], &["--iterations"]),
        (&["--iterations", "-3"], &["-3"]),
        (&["--threads", "0"], &["--threads"]),
        (&["--seed", "x"], &["--seed"]),
        (&["--frobnicate"], &["--frobnicate"]),
        (&["--backend", "gpu", "--adapter", "no such card"], &["graphics adapter", "--backend cpu"]),
        (&["--backend", "cpu", "--adapter", "0"], &["--adapter", "--backend cpu"]),
        (&["--backend", "tpu"], &["tpu"]),
        (&["--adapter", "no such card"], &["graphics adapter"]),
        (&["--config", "nowhere.toml"], &["nowhere.toml", "default, paper, quick"]),
    ] {
        refuses(&case, case.command("optimize").arg("-o").arg(&out).args(arguments), words);
    }
    refuses(&case, case.command("simulate").args(["--steps", "0"]), &["--steps"]);
    refuses(&case, case.command("simulate").args(["--substeps", "0"]), &["--substeps"]);
}

#[test]
fn bad_configurations_are_refused_with_file_and_key() {
    let case = Case::new(&table());
    for (content, key) in [
        ("[local]\ncandidates = 0", "local.candidates"),
        ("[local]\ncandidates = 4000000000", "local.candidates"),
        ("[simulation]\nsubsteps = 4000000000", "simulation.substeps"),
        ("[simulation]\nsteps = 10", "simulation.snapshot_step"),
        ("[verify]\nseconds = 1e30", "verify.seconds"),
        ("[settle]\nmax_seconds = 1e30", "settle.max_seconds"),
        ("[global]\niterations = 0", "global.iterations"),
        ("[global]\nepisodes = 0", "global.episodes"),
        ("[local]\nelite_fraction = nan", "local.elite_fraction"),
        ("[energy]\nvelocity = inf", "energy.velocity"),
        ("[simulation]\ndt = 0.0", "simulation.dt"),
        ("[simulation]\nsubstepz = 4", "substepz"),
        ("[lokal]\ncandidates = 4", "lokal"),
        ("[local]\ncandidates = -4", "candidates"),
        ("[local]\ncandidates = \"many\"", "candidates"),
        ("[local", "local"),
    ] {
        fs::write(case.path("mine.toml"), content).unwrap();
        let mut command = case.command("optimize");
        command.arg("-o").arg(case.path("out")).arg("--config").arg(case.path("mine.toml"));
        refuses(&case, &mut command, &["mine.toml", key]);
    }
}

#[test]
fn a_place_that_cannot_be_written_is_refused_before_the_work() {
    let case = Case::new(&table());
    refuses(&case, case.command("optimize").arg("-o").arg(case.path("cube.obj")), &["cube.obj"]);
    refuses(&case, case.command("optimize").arg("-o").arg(case.path("cube.obj/deep/er")), &["cube.obj"]);
    refuses(&case, case.command("simulate").arg("-o").arg(case.path("cube.obj/states.json")), &["cube.obj"]);
    refuses(&case, case.command("simulate").arg("-o").arg(case.folder.path()), &["folder"]);
    fs::create_dir_all(case.path("full/report.json")).unwrap();
    refuses(&case, case.command("optimize").arg("-o").arg(case.path("full")), &["report.json", "folder"]);
    fs::create_dir(case.path("other")).unwrap();
    fs::write(case.path("other/parts"), "").unwrap();
    refuses(&case, case.command("optimize").arg("-o").arg(case.path("other")), &["parts", "file"]);
    // Not even root may make files here.
    if cfg!(target_os = "linux") {
        refuses(&case, case.command("optimize").arg("-o").arg("/proc/rest3d"), &["/proc/rest3d", "-o"]);
    }
}

/// A limit on the size of a file fails a write as a full disk does: midway.
#[cfg(unix)]
#[test]
fn a_failed_write_leaves_the_earlier_result_as_it_was() {
    let case = Case::new(&table());
    assert!(case.optimize("out", &TINY).status.success());
    let before = tree(&case.path("out"));
    let output = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 1; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_rest3d-gpu"), "optimize"])
        .arg(case.folder.path())
        .arg("-o")
        .arg(case.path("out"))
        .args(TINY)
        .args(["--seed", "9"])
        .env("REST3D_GPU_CACHE", cache())
        .output()
        .unwrap();
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("error: ") && message.contains("cannot be written"), "{message}");
    assert!(output.stdout.is_empty());
    assert!(tree(&case.path("out")) == before, "the earlier result changed");
}

#[test]
fn the_input_is_never_replaced() {
    let case = Case::new(&table());
    refuses(&case, case.command("optimize").arg("-o").arg(case.folder.path()), &["scene.json", "-o"]);
    refuses(&case, case.command("simulate").arg("-o").arg(case.path("scene.json")), &["scene.json", "-o"]);

    let mut input = table();
    input["objects"][0]["mesh"] = json!("out/parts/table_0.obj");
    let case = Case::new(&input);
    fs::create_dir_all(case.path("out/parts")).unwrap();
    fs::write(case.path("out/parts/table_0.obj"), CUBE).unwrap();
    refuses(&case, case.command("optimize").arg("-o").arg(case.path("out")), &["table_0.obj", "-o"]);
    refuses(&case, case.command("simulate").arg("-o").arg(case.path("out/parts/table_0.obj")), &["table_0.obj", "-o"]);
}

#[test]
fn parts_of_an_earlier_result_do_not_stay_but_other_files_do() {
    let case = Case::new(&table());
    assert!(case.optimize("out", &TINY).status.success());
    fs::write(case.path("out/parts/mine.obj"), CUBE).unwrap();
    let mut renamed = table();
    renamed["objects"][2]["name"] = json!("crate");
    fs::write(case.path("scene.json"), renamed.to_string()).unwrap();
    assert!(case.optimize("out", &TINY).status.success());
    let mut names: Vec<String> =
        tree(&case.path("out/parts")).iter().map(|(path, _)| path.file_name().unwrap().display().to_string()).collect();
    names.sort();
    assert_eq!(names, ["crate_0.obj", "left box_0.obj", "mine.obj", "table_0.obj"].map(|n| n.replace(' ', "_")));
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
    let again = Command::new(env!("CARGO_BIN_EXE_rest3d-gpu"))
        .arg("simulate")
        .arg(case.path("out"))
        .env("REST3D_GPU_CACHE", cache())
        .output()
        .unwrap();
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
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
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
    let mut command = case.command("optimize");
    refuses(&case, command.arg("-o").arg(case.path("out")).arg("--resume"), &["checkpoint.json"]);
}

#[test]
fn a_scene_without_movable_objects_is_done_at_once() {
    let mut input = scene(vec![
        cuboid("shelf", "wall", [0.0, 1.0, 0.0], [0.5, 0.1, 0.2]),
        cuboid("stove", "ground", [1.0, 0.4, 0.0], [0.5, 0.8, 0.5]),
    ]);
    input["objects"][1]["movable"] = json!(false);
    let case = Case::new(&input);
    let report = case.report(&[]);
    assert_eq!(report["summary"]["simulated"], 0);
    assert!(report["notes"].to_string().contains("movable"), "{}", report["notes"]);
    let scene: Value = serde_json::from_slice(&fs::read(case.path("out/scene.json")).unwrap()).unwrap();
    for i in 0..2 {
        assert_eq!(scene["objects"][i]["position"], input["objects"][i]["position"]);
    }
}

#[test]
fn a_single_object_is_put_on_the_ground() {
    let case = Case::new(&scene(vec![cuboid("box", "ground", [0.3, 0.12, 0.0], [0.2, 0.2, 0.2])]));
    let report = case.report(&TINY);
    assert_eq!(report["summary"]["stable"], 1);
    let scene: Value = serde_json::from_slice(&fs::read(case.path("out/scene.json")).unwrap()).unwrap();
    let height = scene["objects"][0]["position"][1].as_f64().unwrap();
    // Half its height, to within the simulator's slop of 0.1 mm and the compliance of a contact.
    assert!((height - 0.1).abs() < 5e-4, "{height}");
}

#[test]
fn objects_at_the_same_place_give_a_result() {
    let objects = (0..8).map(|i| cuboid(&format!("box {i}"), "ground", [0.0, 0.1, 0.0], [0.2, 0.2, 0.2])).collect();
    let report = Case::new(&scene(objects)).report(&TINY);
    assert_eq!(report["summary"]["simulated"], 8);
}

#[test]
fn objects_far_below_the_ground_give_a_result() {
    let objects = (0..3)
        .map(|i| cuboid(&format!("box {i}"), "ground", [f64::from(i), -40.0 - f64::from(i), 0.0], [0.2, 0.2, 0.2]));
    let report = Case::new(&scene(objects.collect())).report(&TINY);
    assert_eq!(report["summary"]["simulated"], 3);
}

#[test]
fn a_mesh_of_one_triangle_gives_a_result() {
    let case = Case::new(&scene(vec![json!({"name": "flake", "mesh": "flake.obj", "position": [0, 0.05, 0]})]));
    fs::write(case.path("flake.obj"), "v 0 0 0\nv 0.3 0 0\nv 0 0 0.2\nf 1 2 3\n").unwrap();
    let report = case.report(&TINY);
    assert!(report["objects"][0]["notes"].to_string().contains("thick"), "{}", report["objects"][0]);
}

#[test]
fn two_hundred_objects_give_a_result_and_the_memory_is_told() {
    let objects = (0..200).map(|i| {
        let place = [f64::from(i % 20) * 0.5, 0.12, f64::from(i / 20) * 0.5];
        cuboid(&format!("box {i}"), "ground", place, [0.2, 0.2, 0.2])
    });
    let case = Case::new(&scene(objects.collect()));
    let output = case.optimize("out", &["--candidates", "4", "--iterations", "1", "--json"]);
    let messages = text(&output.stderr);
    assert!(output.status.success(), "{messages}");
    assert!(messages.contains("200 bodies") && messages.contains("MB"), "{messages}");
}

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
    let case = Case::new(&table());
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
        ("0,0,16", &["candidate 16", "16"]),
        ("0,0", &["three numbers"]),
        ("0,0,x", &["three numbers"]),
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
}

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
    let mut elsewhere = Command::new(env!("CARGO_BIN_EXE_rest3d-gpu"));
    refuses(&case, elsewhere.arg("bench").current_dir(case.folder.path()), &["scenes/study", "name a scene"]);
}

#[test]
fn adapters_are_listed_or_it_says_what_to_install() {
    let command = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rest3d-gpu"));
        command.arg("adapters");
        command
    };
    let output = command().arg("--json").output().unwrap();
    assert!(output.status.success());
    let list: Value = serde_json::from_slice(&output.stdout).unwrap();
    for (i, adapter) in list["adapters"].as_array().unwrap().iter().enumerate() {
        assert_eq!(adapter["index"], i);
        assert!(adapter["name"].is_string() && adapter["missing"].is_array());
    }
    if cfg!(target_os = "linux") {
        let output = command().envs(NOWHERE).output().unwrap();
        assert!(output.status.success());
        assert!(text(&output.stdout).contains("libvulkan1"), "{}", text(&output.stdout));
    }
}

/// Variables under which no graphics driver is found.
const NOWHERE: [(&str, &str); 2] = [("VK_DRIVER_FILES", "/nonexistent"), ("VK_ICD_FILENAMES", "/nonexistent")];

#[test]
fn without_a_usable_driver_the_processor_simulates_and_it_says_why() {
    let case = Case::new(&table());
    let garbage = case.path("driver.json");
    fs::write(
        &garbage,
        r#"{"file_format_version": "1.0.0", "ICD": {"library_path": "/etc/passwd", "api_version": 7}}"#,
    )
    .unwrap();
    let garbage = garbage.to_str().unwrap();
    let faults: [(&[(&str, &str)], &str); 4] = [
        (&NOWHERE, "no graphics adapter"),
        (&[("VK_DRIVER_FILES", garbage), ("VK_ICD_FILENAMES", garbage)], "no graphics adapter"),
        (&[("REST3D_GPU_PROBE_FAULT", "crash")], "the graphics driver crashed"),
        (&[("REST3D_GPU_PROBE_FAULT", "hang"), ("REST3D_GPU_PROBE_SECONDS", "1")], "did not answer within 1 s"),
    ];
    for (variables, words) in faults {
        if !cfg!(target_os = "linux") && words.contains("adapter") {
            continue;
        }
        let output = case.command("simulate").args(["--steps", "2"]).envs(variables.iter().copied()).output().unwrap();
        let said = text(&output.stderr);
        let line = said.lines().find(|line| line.starts_with("backend: ")).unwrap_or_default();
        assert!(output.status.success() && line.contains("backend: CPU") && line.contains(words), "{said}");
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_rest3d-gpu"));
    let output = command.arg("adapters").env("REST3D_GPU_PROBE_FAULT", "crash").output().unwrap();
    let said = text(&output.stdout);
    assert!(output.status.success() && said.contains("crashed") && said.contains("install"), "{said}");
}

#[test]
fn help_lists_only_what_exists() {
    let help = Command::new(env!("CARGO_BIN_EXE_rest3d-gpu")).arg("--help").output().unwrap();
    let help = text(&help.stdout);
    let commands = ["optimize", "simulate", "evaluate", "bench", "render", "adapters"];
    assert!(commands.iter().all(|command| help.contains(command)));
    assert!(!help.contains("probe"));
}
