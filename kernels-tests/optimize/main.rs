//! The optimizer's flow on a backend without physics: groups, resumption, stopping, assessment.

#![allow(missing_docs, clippy::unwrap_used)]

mod checkpoints;
mod fixture;
mod flow;
mod shared;
mod supports;
