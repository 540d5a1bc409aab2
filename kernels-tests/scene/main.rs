//! The scene document: reading, every error of the contract, frames, writing back, and the import of stage2 folders.
#![allow(clippy::unwrap_used)]

mod errors;
mod fixture;
mod fuzz;
mod reading;
mod stage2;
mod writing;
