//! Canonicalization: synthetic rooms whose right layout is known, what must stay the same, bad input, and the shared
//! rooms.
#![allow(clippy::unwrap_used)]

mod command;
#[path = "../common/mod.rs"]
mod common;
mod fixture;
mod rooms;
mod scenes;
