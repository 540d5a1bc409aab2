//! From a scene to the text of a `scene.json`.

use super::{Object, Pose, Scene};
use glam::DVec3;
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

impl Scene {
    /// The document as it came, with the poses, room, masses and convex parts that changed, and paths that are valid
    /// from `dir`.
    ///
    /// Frame, unknown fields, order of fields and the numbers of whatever did not change are kept. The same scene and
    /// folder give the same bytes. `dir` need not exist yet; poses have to be finite.
    pub fn to_json(&self, dir: &Path) -> String {
        let paths = Rebase { same: real(dir) == real(self.folder()), dir: real(dir) };
        let mut document = self.document.clone();
        let entries = document.get_mut("objects").and_then(Value::as_array_mut);
        let entries = entries.into_iter().flatten().filter_map(Value::as_object_mut);
        for ((entry, object), (pose, parts)) in entries.zip(&self.objects).zip(&self.originals) {
            self.write_pose(entry, object, pose);
            paths.write(entry, object, parts);
            if let Some(mass) = object.mass.filter(|mass| entry.get("mass").and_then(Value::as_f64) != Some(*mass)) {
                entry.insert("mass".to_owned(), mass.into());
            }
        }
        if let Some(room) = document.get_mut("room").and_then(Value::as_object_mut) {
            self.write_room(room);
        }
        format!("{document:#}\n")
    }

    /// A pose as the file states it: position in its unit, then rotation xyzw, its axis up.
    pub fn pose_in_file(&self, pose: &Pose) -> [f64; 7] {
        let [x, y, z] = self.frame.point_back(pose.translation).to_array();
        let [i, j, k, w] = self.frame.rotation_back(pose.rotation).to_array();
        [x, y, z, i, j, k, w]
    }

    /// A position that the user gives in the file's frame and unit, in ours.
    pub fn point_of_file(&self, point: DVec3) -> DVec3 {
        self.frame.point(point)
    }

    /// A velocity (m/s) in the file's frame, units/s.
    pub fn velocity_in_file(&self, velocity: DVec3) -> DVec3 {
        self.frame.direction_back(velocity) / self.frame.meters_per_unit
    }

    /// A direction or angular velocity in the file's frame.
    pub fn direction_in_file(&self, direction: DVec3) -> DVec3 {
        self.frame.direction_back(direction)
    }

    fn write_pose(&self, entry: &mut Map<String, Value>, object: &Object, original: &Pose) {
        if object.pose.translation != original.translation {
            let position = self.frame.point_back(object.pose.translation);
            entry.insert("position".to_owned(), position.to_array().to_vec().into());
        }
        if object.pose.rotation != original.rotation {
            let rotation = self.frame.rotation_back(object.pose.rotation);
            entry.insert("rotation_xyzw".to_owned(), rotation.to_array().to_vec().into());
        }
    }

    fn write_room(&self, room: &mut Map<String, Value>) {
        if let Some(ceiling) = self.room.ceiling.filter(|_| self.room.ceiling != self.original_room.ceiling) {
            room.insert("ceiling".to_owned(), self.frame.height_back(ceiling).into());
        }
        let entries = room.get_mut("walls").and_then(Value::as_array_mut);
        let entries = entries.into_iter().flatten().filter_map(Value::as_object_mut);
        for ((entry, wall), original) in entries.zip(&self.room.walls).zip(&self.original_room.walls) {
            if wall.point != original.point {
                entry.insert("point".to_owned(), self.frame.point_back(wall.point).to_array().to_vec().into());
            }
            if wall.normal != original.normal {
                entry.insert("normal".to_owned(), self.frame.direction_back(wall.normal).to_array().to_vec().into());
            }
        }
    }

    fn folder(&self) -> &Path {
        self.file.parent().unwrap_or(Path::new(""))
    }
}

/// Turns resolved paths into paths relative to a folder.
struct Rebase {
    /// Where the paths start.
    dir: PathBuf,
    /// True if that is where they started when the scene was read.
    same: bool,
}

impl Rebase {
    fn write(&self, entry: &mut Map<String, Value>, object: &Object, original_parts: &[PathBuf]) {
        if let Some(mesh) = entry.get_mut("mesh").filter(|mesh| !self.stays(mesh)) {
            *mesh = self.relative(&object.mesh);
        }
        let changed = object.convex_parts != original_parts;
        let stay = |parts: &Value| parts.as_array().is_some_and(|parts| parts.iter().all(|part| self.stays(part)));
        if object.convex_parts.is_empty() {
            if changed {
                entry.shift_remove("convex_parts");
            }
        } else if changed || !entry.get("convex_parts").is_some_and(stay) {
            let parts = object.convex_parts.iter().map(|part| self.relative(part)).collect();
            entry.insert("convex_parts".to_owned(), parts);
        }
    }

    /// True for a path that means the same file from the new folder.
    fn stays(&self, path: &Value) -> bool {
        self.same || path.as_str().is_some_and(|path| Path::new(path).is_absolute())
    }

    fn relative(&self, path: &Path) -> Value {
        let path = real(path);
        let path = pathdiff::diff_paths(&path, &self.dir).unwrap_or(path);
        // Forward slashes are understood everywhere.
        path.to_string_lossy().replace(std::path::MAIN_SEPARATOR, "/").into()
    }
}

/// The absolute path without links and dots, as far as it exists; `..` across a link would else lead astray.
fn real(path: &Path) -> PathBuf {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    for existing in path.ancestors() {
        if let (Ok(real), Ok(rest)) = (existing.canonicalize(), path.strip_prefix(existing)) {
            // Joining nothing would add a slash.
            return if rest.as_os_str().is_empty() { real } else { real.join(rest) };
        }
    }
    path
}
