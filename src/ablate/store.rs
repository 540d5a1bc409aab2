//! Finished runs on disk, one file each, named by what the run depends on: a command that was ended goes on from them,
//! and rows of two tables that are the same run share it.

use super::run::Run;
use crate::files::write_whole;
use std::io;
use std::path::{Path, PathBuf};

/// A folder of finished runs.
#[derive(Clone, Debug)]
pub struct Store {
    folder: PathBuf,
}

impl Store {
    /// In `folder`, which is made with the first run.
    pub fn new(folder: &Path) -> Self {
        Self { folder: folder.to_owned() }
    }

    /// The run of that identity; none if it is not there, or not a whole run of this version.
    pub fn load(&self, identity: &str) -> Option<Run> {
        serde_json::from_slice(&std::fs::read(self.path(identity)).ok()?).ok()
    }

    /// Keeps a run: it is there whole or not at all.
    ///
    /// # Errors
    /// What the file system reports.
    pub fn keep(&self, identity: &str, run: &Run) -> io::Result<()> {
        write_whole(&self.path(identity), format!("{}\n", serde_json::to_string_pretty(run)?).as_bytes())
    }

    /// The file of a run.
    pub fn path(&self, identity: &str) -> PathBuf {
        self.folder.join(format!("{identity}.json"))
    }
}
