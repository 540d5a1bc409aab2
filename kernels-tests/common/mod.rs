//! What several test targets share: each compiles all of it and uses some.

#![allow(dead_code, clippy::unwrap_used)]

pub mod hulls;
pub mod meshes;
pub mod program;
pub mod scenario;
pub mod scenes;
