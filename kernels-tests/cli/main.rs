//! The command line as a user meets it: exit codes, what stands on stdout, what is left on disk.
//!
//! Scenes are made of boxes in temporary folders, so that a run takes seconds.
#![allow(clippy::unwrap_used)]

mod adapters;
mod bench;
#[path = "../common/mod.rs"]
mod common;
mod fixture;
mod odd_scenes;
mod refusals;
mod results;
mod simulate;
