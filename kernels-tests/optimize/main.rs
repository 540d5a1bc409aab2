//! The optimizer's flow on a backend without physics: groups, resumption, stopping, assessment.

#![allow(missing_docs, clippy::unwrap_used)]

mod checkpoints;
#[path = "../common/mod.rs"]
mod common;
mod fixture;
mod flow;
mod opinion;
mod shared;
mod supports;
