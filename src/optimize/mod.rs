//! From a broken layout to one that stands: local groups, then the whole scene, then settling and a check.
//!
//! The optimizer sees the world through the `Backend` trait and does not know which processor runs it.

mod config;
mod outcome;

pub use config::Config;
pub use outcome::{Event, GroupRecord, IterationRecord, ObjectOutcome, Observer, Outcome, Timings};
