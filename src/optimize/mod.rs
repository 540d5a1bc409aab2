//! From a broken layout to one that stands: objects set onto their supports, walls and ceiling, local groups, then the
//! whole scene, then settling, a second opinion, the parting of meshes that touch, and a check.
//!
//! The optimizer sees the world through the `Backend` trait and does not know which processor runs it.

mod astray;
mod baseline;
mod cem;
mod checkpoint;
mod config;
mod directions;
mod exact;
mod finish;
mod footing;
mod groups;
mod opinion;
mod outcome;
mod posture;
mod projection;
mod replay;
mod retry;
mod rig;
mod room;
mod run;
mod seat;
mod settle;
mod support;
mod sweep;
mod tolerances;
mod verify;
mod whole;

pub use baseline::{Baseline, project_and_settle};
pub use checkpoint::{Checkpoint, identity};
pub use config::{Config, ResultFrom, SettleSettings, VerifySettings};
pub use exact::{Clearances, MeshOverlap, part_meshes};
pub use outcome::{Event, GroupRecord, IterationRecord, ObjectOutcome, Observer, Outcome, Timings};
pub use projection::{Projection, Scope, project};
pub use replay::{Candidate, Replay, replay};
pub use retry::run_on;
pub use rig::Rig;
pub use room::{Placement, Room, Side};
pub use run::run;
pub use tolerances::FALLEN;
pub use whole::{shape_requests, standing};

use crate::world::BackendError;
use thiserror::Error;

/// Why a run ended without a result.
#[derive(Debug, Error)]
pub enum OptimizeError {
    /// A number in the configuration makes no sense.
    #[error("configuration: `{key}` is {value}, but must be {wanted}")]
    Config {
        /// Table and key.
        key: String,
        /// What stands there.
        value: String,
        /// What may stand there.
        wanted: String,
    },
    /// The checkpoint cannot be used; the message says why and what to do.
    #[error("checkpoint: {0}")]
    Checkpoint(String),
    /// The run has no such candidate.
    #[error("{0}")]
    Candidate(String),
    /// The simulator could not go on.
    #[error(transparent)]
    Backend(#[from] BackendError),
}
