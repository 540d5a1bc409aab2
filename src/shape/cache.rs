//! Decompositions on disk, found by their content.
//!
//! An entry is named by the hash of everything that decides the result and starts with the hash of its own bytes, so
//! that a truncated or damaged entry is as good as none. Entries are written beside and then renamed: two runs at once
//! do no harm. A directory that cannot be used costs time, never the run.

use glam::Vec3;
use serde::{Serialize, de::DeserializeOwned};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Environment variable that names the directory.
pub const CACHE_VARIABLE: &str = "REST3D_GPU_CACHE";

/// A directory of finished shapes.
#[derive(Clone, Debug)]
pub struct Cache {
    directory: PathBuf,
}

impl Cache {
    /// A cache in `directory`, which is made when the first entry is stored.
    pub fn new(directory: impl Into<PathBuf>) -> Self {
        Self { directory: directory.into() }
    }

    /// The directory that `REST3D_GPU_CACHE` names, else the user's cache directory; `None` if there is neither.
    pub fn default_location() -> Option<Self> {
        match std::env::var_os(CACHE_VARIABLE) {
            Some(named) if !named.is_empty() => Some(Self::new(named)),
            _ => directories::ProjectDirs::from("", "", "rest3d-gpu").map(|d| Self::new(d.cache_dir().join("shapes"))),
        }
    }

    /// Where entries lie.
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// The entry of that key, if it is there and whole.
    pub(super) fn load<T: DeserializeOwned>(&self, key: &blake3::Hash) -> Option<T> {
        let bytes = std::fs::read(self.path(key)).ok()?;
        let (sum, content) = bytes.split_at_checked(blake3::OUT_LEN)?;
        if blake3::hash(content).as_bytes() != sum {
            return None;
        }
        serde_json::from_slice(content).ok()
    }

    /// Finds out whether entries can be stored.
    ///
    /// # Errors
    /// What keeps it from that, and what to do about it.
    pub fn check(&self) -> Result<(), String> {
        self.file().map(drop).map_err(|e| {
            format!(
                "shape cache {} is not usable ({e}): meshes are cut anew in every run; let {CACHE_VARIABLE} name a \
                 folder that can be written",
                self.directory.display()
            )
        })
    }

    /// Stores an entry.
    pub(super) fn store<T: Serialize>(&self, key: &blake3::Hash, value: &T) -> std::io::Result<()> {
        let content = serde_json::to_vec(value)?;
        let mut file = self.file()?;
        file.write_all(blake3::hash(&content).as_bytes())?;
        file.write_all(&content)?;
        file.persist(self.path(key)).map_err(|e| e.error)?;
        Ok(())
    }

    /// A file beside the entries, which goes unless it is renamed.
    fn file(&self) -> std::io::Result<tempfile::NamedTempFile> {
        std::fs::create_dir_all(&self.directory)?;
        tempfile::NamedTempFile::new_in(&self.directory)
    }

    fn path(&self, key: &blake3::Hash) -> PathBuf {
        self.directory.join(format!("{key}.shape"))
    }
}

/// Collects what decides a shape.
#[derive(Default)]
pub(super) struct Key(blake3::Hasher);

impl Key {
    /// Adds a list of points, with its length so that lists cannot run into each other.
    pub fn points(&mut self, points: &[Vec3]) -> &mut Self {
        self.0.update(&(points.len() as u64).to_le_bytes());
        self.0.update(bytemuck::cast_slice(points));
        self
    }

    /// Adds a list of triangles.
    pub fn triangles(&mut self, triangles: &[[u32; 3]]) -> &mut Self {
        self.0.update(&(triangles.len() as u64).to_le_bytes());
        self.0.update(bytemuck::cast_slice(triangles));
        self
    }

    /// Adds anything that prints itself.
    pub fn text(&mut self, text: &str) -> &mut Self {
        self.0.update(&(text.len() as u64).to_le_bytes());
        self.0.update(text.as_bytes());
        self
    }

    /// The key.
    pub fn finish(&self) -> blake3::Hash {
        self.0.finalize()
    }
}
