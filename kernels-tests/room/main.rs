//! Placement on walls and ceiling, and walls that bear, in rooms of boxes at any angle and in the shared test room.
#![allow(missing_docs, clippy::unwrap_used)]

mod bearing;
#[path = "../common/mod.rs"]
mod common;
mod fixture;
mod hanging;
mod runs;
