//! What is measured of a simulator: a population simulated to its end, and where the time went.

use super::{Pose, Status};
use serde::{Deserialize, Serialize, Serializer};

/// A population after its last step.
#[derive(Clone, Debug, PartialEq)]
pub struct Rollouts {
    /// Pose of every body, candidate-major as the starts.
    pub settled: Vec<Pose>,
    /// What went wrong, one entry a candidate.
    pub statuses: Vec<Status>,
    /// Mean number of contact points of a candidate in the last substep of each step; none where nobody counts them.
    pub contacts_per_substep: Option<f64>,
}

/// The time of one kernel in the rollouts of a population.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KernelTime {
    /// Its name, that of its file.
    pub name: String,
    /// All its calls together, ms of wall time: on a processor, its threads' time divided by their number, on a device
    /// its own clock's.
    pub milliseconds: f64,
}

impl KernelTime {
    /// A list of times as one object: milliseconds by name, in their order.
    ///
    /// # Errors
    /// The serializer's.
    pub fn by_name<S: Serializer>(times: &[Self], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(times.iter().map(|time| (&time.name, time.milliseconds)))
    }
}
