//! The folder that a run leaves its files in: all of them, or none.

use super::Failure;
use rest3d_gpu::scene::Scene;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Finds out before the long work whether files could be written into `dir`, which may not exist yet. Nothing is left.
pub fn check_writable(dir: &Path) -> Result<(), Failure> {
    let existing = dir.ancestors().map(here).find(|path| path.exists()).unwrap_or(Path::new("."));
    tempfile::Builder::new().prefix(".rest3d-gpu-").tempfile_in(existing).map(drop).map_err(|error| {
        Failure::Input(format!("{}: cannot be written to: {error}; choose another folder with -o", dir.display()))
    })
}

/// The input is not ours to replace, and a resumed run needs it.
pub fn refuse_to_overwrite(scene: &Scene, file: &Path) -> Result<(), Failure> {
    match (scene.file.canonicalize(), file.canonicalize()) {
        (Ok(input), Ok(output)) if input == output => Err(Failure::Input(format!(
            "{}: the result would replace its input; choose another place with -o",
            scene.file.display()
        ))),
        _ => Ok(()),
    }
}

/// Writes the files, given as paths inside `dir` with their bytes, in order. They are first written whole into a folder
/// beside their places, so that a full disk is met before the first old file is replaced, and then renamed; the last
/// file is the one that refers to the others.
pub fn write_all(dir: &Path, files: &[(PathBuf, Vec<u8>)]) -> Result<(), Failure> {
    fs::create_dir_all(dir).map_err(|error| Failure::writing(dir, error))?;
    let staging =
        tempfile::Builder::new().prefix(".rest3d-gpu-").tempdir_in(dir).map_err(|e| Failure::writing(dir, e))?;
    for (name, bytes) in files {
        let path = staging.path().join(name);
        let written = fs::create_dir_all(parent(&path)).and_then(|()| fs::write(&path, bytes));
        written.map_err(|error| Failure::writing(&dir.join(name), error))?;
    }
    for (name, _) in files {
        let path = dir.join(name);
        let moved = fs::create_dir_all(parent(&path)).and_then(|()| fs::rename(staging.path().join(name), &path));
        moved.map_err(|error| Failure::writing(&path, error))?;
    }
    Ok(())
}

/// The folder that holds `path`.
pub fn parent(path: &Path) -> &Path {
    here(path.parent().unwrap_or(path))
}

/// An empty path is the current folder.
fn here(path: &Path) -> &Path {
    if path.as_os_str().is_empty() { Path::new(".") } else { path }
}

/// A name that is one component of a path whatever the user's name for the scene is.
pub fn folder_name(name: &str) -> String {
    let mut components = Path::new(name).components();
    match (components.next(), components.next()) {
        (Some(Component::Normal(only)), None) if only.to_str() == Some(name) => name.into(),
        _ => "scene".into(),
    }
}
