//! Foreign formats, turned into documents of our own. Conversions of axes, units and names happen here and only here.

pub mod rest3d;

use crate::scene::{FILE, Scene, SceneError};
use std::path::Path;

/// Reads a scene of any format: a `scene.json`, a folder that holds one, or a REST3D `stage2` folder.
///
/// # Errors
/// The first thing that the format does not allow.
pub fn read(path: &Path) -> Result<Scene, SceneError> {
    if path.file_name().is_some_and(|name| name == rest3d::TREE) {
        return rest3d::read(path);
    }
    if !path.is_dir() || path.join(FILE).is_file() {
        return Scene::read(path);
    }
    let tree = rest3d::find(path).ok_or_else(|| {
        SceneError::new(
            path,
            "the folder holds neither a scene.json nor a scene_tree.json",
            "name a scene.json, a folder that holds one, or a REST3D stage2 folder",
        )
    })?;
    rest3d::read(&tree)
}
