//! Kernels `place`, `energy`, `elites`, `moments` by hand-made numbers, and the search that joins them.
#![allow(missing_docs, clippy::unwrap_used)]

mod by_hand;
#[path = "../common/mod.rs"]
mod common;
mod fixture;
mod iterations;
mod rounds;
