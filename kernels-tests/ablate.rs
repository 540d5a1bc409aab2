//! `ablate`: rooms of boxes, a tiny search, and what is left when it is ended and called again.
#![allow(clippy::unwrap_used)]

mod common;

use common::meshes::CUBE;
use common::program::program;
use serde_json::{Value, json};
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};
use tempfile::TempDir;

/// A folder with a scene: a table, two boxes in one another on it, and a picture on the wall.
struct Case {
    folder: TempDir,
}

impl Case {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let cube = |name: &str, parent: &str, position: [f64; 3], size: [f64; 3]| {
            json!({
                "name": name, "mesh": "cube.obj", "position": position, "scale": size, "parent": parent
            })
        };
        let objects = [
            cube("table", "ground", [0.0, 0.25, 0.0], [1.0, 0.5, 0.6]),
            cube("left box", "table", [-0.05, 0.6, 0.0], [0.2, 0.2, 0.2]),
            cube("right box", "table", [0.1, 0.6, 0.02], [0.2, 0.2, 0.2]),
            cube("picture", "wall", [0.0, 1.5, -0.5], [0.5, 0.4, 0.02]),
        ];
        let scene = json!({"format": "rest3d-scene", "version": 1, "name": "boxes", "objects": objects});
        fs::write(folder.path().join("cube.obj"), CUBE).unwrap();
        fs::write(folder.path().join("scene.json"), scene.to_string()).unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, out: &str, tables: &str) -> Command {
        let mut command = program();
        command.arg("ablate").arg(self.folder.path()).arg("-o").arg(self.path(out)).args(["--tables", tables]);
        command.args(["--candidates", "8", "--backend", "cpu"]);
        command
    }

    fn run(&self, out: &str, tables: &str, more: &[&str]) -> Output {
        let quick = ["--json", "--config", "quick", "--iterations", "2"];
        self.command(out, tables).args(quick).args(more).output().unwrap()
    }

    /// The document, and what was told on the way.
    fn tables(&self, out: &str, tables: &str) -> (Value, String) {
        let output = self.run(out, tables, &[]);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{told}");
        (serde_json::from_slice(&output.stdout).unwrap(), told)
    }

    /// The files of finished runs, with their content.
    fn runs(&self, out: &str) -> Vec<(PathBuf, Value)> {
        let mut files: Vec<PathBuf> =
            fs::read_dir(self.path(out).join("runs")).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        let read = |path: PathBuf| (path.clone(), serde_json::from_slice(&fs::read(path).unwrap()).unwrap());
        files.into_iter().map(read).collect()
    }
}

/// The row of a table by its label.
fn row<'a>(document: &'a Value, table: usize, label: &str) -> &'a Value {
    let rows = document["tables"][table]["rows"].as_array().unwrap();
    rows.iter().find(|row| row["label"] == label).unwrap_or_else(|| panic!("no row {label}"))
}

#[test]
fn every_stage_has_its_row_beside_the_papers() {
    let case = Case::new();
    let (document, _) = case.tables("out", "structure");
    let rows = document["tables"][0]["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 8);
    let ours = |label: &str, key: &str| row(&document, 0, label)["ours"][key].as_f64().unwrap();
    // Without the tree the picture falls from the wall: one of four, where with it there are three that may move.
    assert_eq!(row(&document, 0, "raw")["runs"][0]["ended"]["result"]["movable"], 4);
    assert_eq!(row(&document, 0, "raw + tree")["runs"][0]["ended"]["result"]["movable"], 3);
    assert!(ours("raw", "drift_m") > ours("raw + tree", "drift_m") + 0.2);
    // Both boxes are in one another, until they are parted.
    assert_eq!(ours("canonicalized + tree", "collision_rate_1mm_pct"), 50.0);
    for label in ["projection, global-only", "projection, global-local", "whole method"] {
        assert_eq!(ours(label, "stable_rate_pct"), 100.0, "{label}");
        assert_eq!(ours(label, "collision_rate_1mm_pct"), 0.0, "{label}");
    }
    assert_eq!(row(&document, 0, "global-only")["paper"]["failure_rate_pct"], 10.0);
    assert_eq!(row(&document, 0, "whole method")["paper"]["stable_rate_pct"], 94.9);

    let markdown = fs::read_to_string(case.path("out").join("ablation.md")).unwrap();
    assert!(markdown.contains("| raw | ours |") && markdown.contains("| whole method | ours |"), "{markdown}");
    let stored: Value = serde_json::from_slice(&fs::read(case.path("out").join("ablation.json")).unwrap()).unwrap();
    assert_eq!(stored, document);
}

#[test]
fn an_ended_command_goes_on_where_it_was() {
    let case = Case::new();
    let (whole, told) = case.tables("out", "energy");
    assert!(told.contains("runs: 5 to do, 0 done before"), "{told}");
    let runs = case.runs("out");
    assert_eq!(runs.len(), 5);
    // One is missing, one is cut off, and one bears a mark that running it again would remove.
    fs::remove_file(&runs[0].0).unwrap();
    fs::write(&runs[1].0, "{\"scene\": \"boxes\"").unwrap();
    let (marked, mut content) = runs[2].clone();
    content["ended"]["result"]["stable_rate_pct"] = json!(12.5);
    fs::write(&marked, content.to_string()).unwrap();
    let (again, told) = case.tables("out", "energy");
    assert!(told.contains("runs: 2 to do, 3 done before"), "{told}");
    for (path, before) in &runs[..2] {
        let after: Value = serde_json::from_slice(&fs::read(path).unwrap()).unwrap();
        assert_eq!(after["ended"], before["ended"], "the same run has the same numbers");
    }
    let rates = |document: &Value| -> Vec<f64> {
        let rows = document["tables"][0]["rows"].as_array().unwrap();
        rows.iter().map(|row| row["ours"]["stable_rate_pct"].as_f64().unwrap()).collect()
    };
    let changed = rates(&whole).iter().zip(rates(&again)).filter(|(before, after)| **before != *after).count();
    assert_eq!(changed, 1, "only the marked run differs");
}

#[test]
fn tables_share_the_runs_that_are_the_same() {
    let case = Case::new();
    let config = case.path("tenth.toml");
    fs::write(&config, "[local]\nelite_fraction = 0.1\n[global]\nelite_fraction = 0.1\n").unwrap();
    let output = case.run("out", "energy,elites", &[]);
    assert!(output.status.success());
    // Elite fractions of the quick configuration differ between local and global: nothing is shared.
    assert_eq!(case.runs("out").len(), 11);
    let mut command = case.command("shared", "energy,elites");
    assert!(command.arg("--config").arg(&config).args(["--iterations", "1"]).output().unwrap().status.success());
    assert_eq!(case.runs("shared").len(), 10);
}

#[test]
fn bad_usage_is_told_and_leaves_nothing() {
    let case = Case::new();
    let scene = case.path("scene.json").display().to_string();
    let gone = case.path("gone.json").display().to_string();
    let held = case.path("held.json").display().to_string();
    let mut document: Value = serde_json::from_slice(&fs::read(&scene).unwrap()).unwrap();
    document["objects"].as_array_mut().unwrap().iter_mut().for_each(|object| object["movable"] = json!(false));
    fs::write(&held, document.to_string()).unwrap();
    let cases: [(&str, &[&str], &str); 5] = [
        ("energy", &[&held], "held.json: nothing in it can move"),
        ("energy", &[&gone], "gone.json"),
        ("energie", &[], "energie"),
        ("energy", &["--reference", &scene, "--reference", &scene, &scene, &scene], "one for each"),
        ("energy", &["--reference", &gone], "gone.json"),
    ];
    for (tables, more, wanted) in cases {
        let output = case.run("out", tables, more);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(wanted) && output.stdout.is_empty(), "{message}");
        assert!(!case.path("out").exists());
    }
}
