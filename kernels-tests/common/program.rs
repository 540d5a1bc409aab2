//! The program as the tests run it.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The program, with the cache of the tests instead of the user's.
pub fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rest3d-gpu"));
    command.env("REST3D_GPU_CACHE", cache());
    command
}

/// Shared by all tests: entries are found by their content and written in one step.
pub fn cache() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("shapes")
}
