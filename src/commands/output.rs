//! The folder that a run leaves its files in: all of them, or none.

use super::Failure;
use rest3d_gpu::files::TEMPORARY;
use rest3d_gpu::scene::Scene;
use serde_json::Value;
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::time::Duration;

/// A temporary file that is older is nobody's any more.
const LEFT_AFTER: Duration = Duration::from_secs(3600);

/// Finds out before the long work whether files could be written into `dir`, which may not exist yet. Nothing is left.
pub fn check_writable(dir: &Path) -> Result<(), Failure> {
    let missing: Vec<&Path> = dir.ancestors().map(here).take_while(|path| !path.exists()).collect();
    let tried = fs::create_dir_all(dir)
        .and_then(|()| tempfile::Builder::new().prefix(TEMPORARY).tempfile_in(here(dir)).map(drop));
    // Those that were not there go again, the innermost first; what someone else has put there meanwhile stays.
    for path in missing {
        let _ = fs::remove_dir(path);
    }
    tried.map_err(|error| {
        Failure::Input(format!("{}: cannot be written to: {error}; choose another folder with -o", dir.display()))
    })
}

/// Finds out before the long work whether the result's files have room: what is in the place of `files` must be files,
/// `parts` a folder. A link, device or pipe would not be written into but replaced.
pub fn check_places(files: &[PathBuf], parts: &Path) -> Result<(), Failure> {
    let refuse = |path: &Path, found: &str, wanted: &str| {
        let path = path.display();
        Err(Failure::Input(format!(
            "{path}: it is a {found}, but the result needs a {wanted} there; remove it or choose another place with -o"
        )))
    };
    let ends_in_separator = |file: &&PathBuf| file.to_string_lossy().ends_with(std::path::is_separator);
    if let Some(file) = files.iter().find(ends_in_separator) {
        return refuse(file, "folder", "file");
    }
    let is_other = |file: &&PathBuf| file.symlink_metadata().is_ok_and(|found| !found.is_file());
    match files.iter().find(is_other) {
        Some(file) if file.is_symlink() => refuse(file, "link", "file"),
        Some(file) if file.is_dir() => refuse(file, "folder", "file"),
        Some(file) => refuse(file, "device or pipe", "file"),
        None if parts.is_symlink() && !parts.exists() => refuse(parts, "link to nothing", "folder"),
        None if parts.exists() && !parts.is_dir() => refuse(parts, "file", "folder"),
        None => Ok(()),
    }
}

/// The input is not ours to replace, and a resumed run needs it. `outputs` are files, or folders that are written into.
pub fn refuse_to_overwrite(scene: &Scene, outputs: &[PathBuf]) -> Result<(), Failure> {
    let outputs: Vec<PathBuf> = outputs.iter().filter_map(|output| output.canonicalize().ok()).collect();
    let of_objects = scene.objects.iter().flat_map(|object| object.convex_parts.iter().chain([&object.mesh]));
    for input in of_objects.chain([&scene.file]) {
        if input.canonicalize().is_ok_and(|input| outputs.iter().any(|output| input.starts_with(output))) {
            return Err(Failure::Input(format!(
                "{}: the result would replace this file of its input; choose another place with -o",
                input.display()
            )));
        }
    }
    Ok(())
}

/// The parts, pictures and page that an earlier run left in `dir`, as its own files tell: nothing else there is ours.
pub fn earlier_files(dir: &Path) -> Vec<PathBuf> {
    let read = |name: &str| -> Option<Value> { serde_json::from_slice(&fs::read(dir.join(name)).ok()?).ok() };
    let ours = read("report.json").is_some_and(|report| report["tool"] == env!("CARGO_PKG_NAME"));
    let Some(scene) = read("scene.json").filter(|_| ours) else { return Vec::new() };
    let lists =
        scene["objects"].as_array().into_iter().flatten().filter_map(|object| object["convex_parts"].as_array());
    let parts = lists.flatten().filter_map(|part| part.as_str()).map(PathBuf::from);
    let parts = parts.filter(|part| part.parent() == Some(Path::new("parts")));
    parts.chain(["before.png", "after.png", "report.html"].map(PathBuf::from)).collect()
}

/// Removes the earlier files that the new result does not have. One that stays does no harm.
pub fn remove_stale(dir: &Path, earlier: &[PathBuf], files: &[(PathBuf, Vec<u8>)]) {
    for part in earlier.iter().filter(|part| files.iter().all(|(name, _)| name != *part)) {
        let _ = fs::remove_file(dir.join(part));
    }
}

/// Removes what killed runs left in `dir`: temporary files and folders that nobody has touched for an hour.
fn remove_leftovers(dir: &Path) {
    let is_old = |entry: &fs::DirEntry| {
        let age = entry.metadata().and_then(|found| found.modified()).map(|time| time.elapsed().unwrap_or_default());
        entry.file_name().to_string_lossy().starts_with(TEMPORARY) && age.is_ok_and(|age| age > LEFT_AFTER)
    };
    for entry in fs::read_dir(dir).into_iter().flatten().flatten().filter(is_old) {
        let path = entry.path();
        let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    }
}

/// Writes the files, given as paths inside `dir` with their bytes, in order. They are first written whole into a folder
/// beside their places, so that a full disk is met before the first old file is replaced, and then renamed; the last
/// file is the one that refers to the others.
pub fn write_all(dir: &Path, files: &[(PathBuf, Vec<u8>)]) -> Result<(), Failure> {
    fs::create_dir_all(dir).map_err(|error| Failure::writing(dir, error))?;
    remove_leftovers(dir);
    let staging = tempfile::Builder::new().prefix(TEMPORARY).tempdir_in(dir).map_err(|e| Failure::writing(dir, e))?;
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
