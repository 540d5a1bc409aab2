//! The scenes that a command names, and what they are compared with.

use super::{Failure, say};
use rest3d_gpu::import;
use rest3d_gpu::scene::Scene;
use std::path::{Path, PathBuf};

/// Reads a scene and tells what the user should know of it.
pub fn read(path: &Path) -> Result<Scene, Failure> {
    let scene = import::read(path)?;
    for warning in &scene.warnings {
        say(format_args!("warning: {warning}"));
    }
    Ok(scene)
}

/// The reference of each of so many scenes: one is for all, several are for each in their order.
pub fn references(given: &[PathBuf], scenes: usize) -> Result<Vec<Option<&Path>>, Failure> {
    match given {
        [] => Ok(vec![None; scenes]),
        [all] => Ok(vec![Some(all); scenes]),
        each if each.len() == scenes => Ok(each.iter().map(|path| Some(path.as_path())).collect()),
        _ => Err(Failure::Input(format!(
            "--reference: {} of them for {scenes} scenes; give one for all, or one for each",
            given.len()
        ))),
    }
}
