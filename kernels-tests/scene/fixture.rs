//! Folders with a scene, and documents to begin with.

use rest3d_gpu::scene::{Scene, SceneError};
use serde_json::{Value, json};
use std::fs;
use std::path::PathBuf;

/// A folder with two (empty) meshes; reading a scene only looks whether they are there.
pub struct Folder(pub tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("meshes")).unwrap();
        for mesh in ["desk.glb", "mug.glb", "mug_0.obj", "mug_1.obj"] {
            fs::write(folder.path().join("meshes").join(mesh), "").unwrap();
        }
        Self(folder)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn read_text(&self, text: impl AsRef<[u8]>) -> Result<Scene, SceneError> {
        fs::write(self.path("scene.json"), text).unwrap();
        Scene::read(&self.path("scene.json"))
    }

    pub fn read(&self, document: &Value) -> Result<Scene, SceneError> {
        self.read_text(document.to_string())
    }
}

pub fn read(document: &Value) -> Result<Scene, SceneError> {
    Folder::new().read(document)
}

/// A document that uses everything that the contract names.
pub fn full() -> Value {
    json!({
        "format": "rest3d-scene", "version": 1, "name": "study",
        "frame": {"up": "Y", "meters_per_unit": 1.0},
        "room": {
            "ground": 0.0, "ceiling": 2.6, "walls": [{"name": "back", "point": [0, 0, -2.2], "normal": [0, 0, 2]}]
        },
        "objects": [
            {"name": "mug", "category": "mug", "mesh": "meshes/mug.glb",
             "position": [0.1, 0.75, -0.3], "rotation_xyzw": [0, 0, 0, 1], "scale": 1.0,
             "parent": "desk", "relation": "on", "movable": true,
             "mass": 0.3, "convex_parts": ["meshes/mug_0.obj"]},
            {"name": "desk", "mesh": "meshes/desk.glb"}
        ]
    })
}

pub fn minimal(objects: Value) -> Value {
    json!({"format": "rest3d-scene", "version": 1, "objects": objects})
}

/// `full` with one value replaced, by JSON pointer; a missing last field is added.
pub fn with(pointer: &str, value: Value) -> Value {
    let mut document = full();
    let (parent, field) = pointer.rsplit_once('/').unwrap();
    let parent = document.pointer_mut(parent).unwrap();
    match field.parse::<usize>() {
        Ok(index) => parent[index] = value,
        Err(_) => parent[field] = value,
    }
    document
}

pub fn without(pointer: &str) -> Value {
    let mut document = full();
    let (parent, field) = pointer.rsplit_once('/').unwrap();
    document.pointer_mut(parent).unwrap().as_object_mut().unwrap().remove(field).unwrap();
    document
}

/// The uniform message: `FILE: object "x", field "y": problem; remedy`.
pub fn assert_error(result: Result<Scene, SceneError>, object: Option<&str>, field: Option<&str>, problem: &str) {
    let error = result.expect_err(problem);
    let message = error.to_string();
    let object = object.map_or(String::new(), |object| format!(" object \"{object}\""));
    let comma = if object.is_empty() { " " } else { ", " };
    let field = field.map_or(String::new(), |field| format!("{comma}field \"{field}\""));
    let colon = if object.is_empty() && field.is_empty() { "" } else { ":" };
    assert!(message.starts_with(&format!("{}:{object}{field}{colon} ", error.file.display())), "{message}");
    assert!(error.problem.contains(problem), "{message}");
    assert!(!error.remedy.is_empty() && message.ends_with(&format!("; {}", error.remedy)), "{message}");
    assert!(!message.contains('\n'), "{message}");
}

pub fn stage2(tree: &Value, meshes: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let objects = folder.path().join("stage2/scene_canon/obj_files");
    fs::create_dir_all(&objects).unwrap();
    for mesh in meshes {
        fs::write(objects.join(format!("scene_canon_{mesh}.obj")), "").unwrap();
    }
    fs::write(folder.path().join("stage2/scene_tree.json"), tree.to_string()).unwrap();
    folder
}
