//! A folder with a scene made of boxes, and the program run on it.

use crate::common::meshes::CUBE;
use crate::common::program::program;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// A small search: enough to see all stages.
pub const TINY: [&str; 4] = ["--candidates", "16", "--iterations", "3"];

/// A folder with a mesh and a scene, removed at the end.
pub struct Case {
    pub folder: TempDir,
}

impl Case {
    pub fn new(scene: &Value) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("cube.obj"), CUBE).unwrap();
        fs::write(folder.path().join("scene.json"), scene.to_string()).unwrap();
        Self { folder }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn command(&self, name: &str) -> Command {
        let mut command = program();
        command.arg(name).arg(self.folder.path());
        command
    }

    /// Without pictures: those are drawn in tests of their own.
    pub fn optimize(&self, out: &str, more: &[&str]) -> Output {
        self.command("optimize").arg("--no-pictures").arg("-o").arg(self.path(out)).args(more).output().unwrap()
    }

    /// Optimizes and returns the report.
    pub fn report(&self, more: &[&str]) -> Value {
        let output = self.optimize("out", &[&["--json"], more].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    }
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

pub fn cuboid(name: &str, parent: &str, position: [f64; 3], size: [f64; 3]) -> Value {
    json!({"name": name, "mesh": "cube.obj", "position": position, "scale": size, "parent": parent})
}

pub fn scene(objects: Vec<Value>) -> Value {
    json!({"format": "rest3d-scene", "version": 1, "name": "boxes", "objects": objects})
}

/// A table that hangs in the air with two boxes that overlap it and each other.
pub fn table() -> Value {
    scene(vec![
        cuboid("table", "ground", [0.0, 0.27, 0.0], [1.0, 0.5, 0.6]),
        cuboid("left box", "table", [-0.05, 0.6, 0.0], [0.2, 0.2, 0.2]),
        cuboid("right/box", "table", [0.1, 0.63, 0.02], [0.2, 0.2, 0.2]),
    ])
}

/// Everything below a folder, with its bytes.
pub fn tree(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
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
pub fn refuses(case: &Case, command: &mut Command, words: &[&str]) {
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
