//! Bad input and bad usage are refused, and nothing is written.

use crate::common::meshes::CUBE;
use crate::common::program::{cache, program};
use crate::fixture::*;
use serde_json::{Value, json};
use std::fs;
use std::process::Command;
use std::time::{Duration, SystemTime};

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

    refuses(&case, program().arg("optimize").arg(case.path("nowhere")), &["nowhere"]);
}

#[test]
fn bad_usage_is_refused_and_nothing_is_written() {
    let case = Case::new(&table());
    let out = case.path("out");
    for (arguments, words) in [
        (&["--candidates", "0"][..], &["--candidates"][..]),
        (&["--candidates", "4000000000"], &["candidates"]),
        (&["--iterations", "0"], &["--iterations"]),
        (&["--iterations", "-3"], &["--iterations", "-3 is not in 1"]),
        (&["--seed", "-1"], &["--seed"]),
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
    refuses(&case, case.command("simulate").arg("-o").arg(case.path("no such/")), &["no such/", "folder", "-o"]);
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

/// As root, a device would be lost to the whole machine.
#[cfg(unix)]
#[test]
fn links_and_devices_are_not_replaced() {
    use std::os::unix::fs::FileTypeExt;

    let case = Case::new(&table());
    let elsewhere = tempfile::tempdir().unwrap();
    let (link, socket) = (elsewhere.path().join("link.json"), elsewhere.path().join("socket"));
    fs::write(elsewhere.path().join("target.json"), "old").unwrap();
    std::os::unix::fs::symlink("target.json", &link).unwrap();
    let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    refuses(&case, case.command("simulate").arg("-o").arg(&link), &["link.json", "is a link", "-o"]);
    refuses(&case, case.command("simulate").arg("-o").arg(&socket), &["socket", "device or pipe", "-o"]);
    refuses(&case, case.command("render").arg("-o").arg(&link), &["link.json", "is a link", "-o"]);
    assert!(link.is_symlink() && fs::symlink_metadata(&socket).unwrap().file_type().is_socket());
    fs::create_dir(case.path("linked")).unwrap();
    std::os::unix::fs::symlink(elsewhere.path().join("target.json"), case.path("linked/scene.json")).unwrap();
    refuses(&case, case.command("optimize").arg("-o").arg(case.path("linked")), &["scene.json", "is a link"]);
    let hollow = elsewhere.path().join("hollow");
    fs::create_dir(&hollow).unwrap();
    std::os::unix::fs::symlink(elsewhere.path().join("nothing"), hollow.join("parts")).unwrap();
    refuses(&case, case.command("optimize").arg("-o").arg(&hollow), &["parts", "is a link to nothing"]);
    assert_eq!(fs::read_to_string(elsewhere.path().join("target.json")).unwrap(), "old");
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

/// What a run left that was killed as it wrote: it goes once it is nobody's any more.
#[test]
fn what_killed_runs_left_goes() {
    let case = Case::new(&table());
    let left = |name: &str| case.path("out").join(name);
    fs::create_dir_all(left(".rest3d-gpu-old/parts")).unwrap();
    fs::create_dir_all(left(".rest3d-gpu-new")).unwrap();
    fs::create_dir_all(left(".mine")).unwrap();
    fs::write(left(".rest3d-gpu-file"), "").unwrap();
    let long_ago = SystemTime::now() - Duration::from_secs(7200);
    for name in [".rest3d-gpu-old", ".mine", ".rest3d-gpu-file"] {
        fs::File::open(left(name)).unwrap().set_modified(long_ago).unwrap();
    }
    assert!(case.optimize("out", &TINY).status.success());
    let there = [".rest3d-gpu-old", ".rest3d-gpu-file", ".rest3d-gpu-new", ".mine"].map(|name| left(name).exists());
    assert_eq!(there, [false, false, true, true]);
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
