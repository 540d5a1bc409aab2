//! Pictures by the processor: that they show what they should, and what becomes of bad input. That an adapter draws the
//! same, `kernels-tests/gpu/pictures.rs` looks at.
#![allow(clippy::unwrap_used)]

mod cameras;
mod colours;
#[path = "../common/mod.rs"]
mod common;
mod fixture;
mod pictures;
