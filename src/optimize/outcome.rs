//! What a run tells while it goes and what it leaves.

use super::{Clearances, Placement, Room};
use crate::scene::Pose;
use crate::shape::Part;
use crate::world::{Energy, Flow, IterationStats, KernelTime, Status};
use serde::{Deserialize, Serialize};
use std::sync::{Arc, atomic::AtomicBool};

/// Told to the observer during a run.
#[derive(Clone, Debug)]
pub enum Event<'a> {
    /// The objects are set onto their supports.
    Seating,
    /// What is on walls and ceiling is put there.
    Placing,
    /// The run's shape, before the first group.
    Plan {
        /// Names of the groups in the order in which they are searched; the last is the global stage.
        groups: &'a [String],
        /// Candidate simulations if nothing stops early, by group.
        candidates: &'a [u64],
        /// One-line memory plan.
        memory: &'a str,
    },
    /// After every iteration.
    Iteration {
        /// Index of the group in the plan.
        group: usize,
        /// Iterations of this group if nothing stops early.
        iterations: u32,
        /// Its numbers.
        stats: &'a IterationStats,
    },
    /// A group is done.
    GroupDone {
        /// Index of the group in the plan.
        group: usize,
        /// Everything needed to go on from here.
        checkpoint: &'a super::Checkpoint,
    },
    /// The winner settles to rest.
    Settling,
    /// What rolls or has fallen over is set down anew, one object after the other.
    SettingAnew {
        /// How many objects that are.
        objects: usize,
    },
    /// What does not stand with other parts or on slopes is searched again.
    Reconsidering {
        /// How many objects that are.
        failing: usize,
        /// Which round that is, from 1, and how many there are at most.
        round: [u32; 2],
        /// Everything needed to go on from here.
        checkpoint: &'a super::Checkpoint,
    },
    /// Meshes that touch are parted.
    Parting,
    /// The result is checked.
    Verifying,
}

impl Event<'_> {
    /// What may be written now to go on from here later.
    pub fn checkpoint(&self) -> Option<&super::Checkpoint> {
        match self {
            Self::GroupDone { checkpoint, .. } | Self::Reconsidering { checkpoint, .. } => Some(checkpoint),
            _ => None,
        }
    }
}

/// Watches a run; `Flow::Stop` ends it after the current iteration with the best layout so far.
pub trait Observer {
    /// Called for every event.
    fn event(&mut self, event: Event<'_>) -> Flow;

    /// Becomes true when the run is to end: long work between two events looks at it. Never by default.
    fn stop(&self) -> Arc<AtomicBool> {
        Arc::default()
    }
}

/// One line of `energy.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct IterationRecord {
    /// Index of the group.
    pub group: usize,
    /// Its numbers.
    pub stats: IterationStats,
}

/// One searched group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GroupRecord {
    /// Its name: the root object's, or `global`.
    pub name: String,
    /// Names of the unit roots that were adjusted.
    pub units: Vec<String>,
    /// Best energy; `None` if every candidate failed.
    pub best: Option<Energy>,
    /// Iteration and index of the best candidate, for a replay.
    pub winner: Option<(u32, u32)>,
    /// Candidates with each status bit, summed over the iterations.
    pub flagged: [u64; Status::FAULTS.len()],
    /// Steps that candidates were simulated for, and those of all that might have been (`CemSettings::prune`).
    pub steps: [u64; 2],
    /// s.
    pub seconds: f64,
    /// What each kernel took, ms; empty where the backend does not tell.
    #[serde(default)]
    pub kernels: Vec<KernelTime>,
}

/// What became of one object.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectOutcome {
    /// Final pose, Y up, m.
    pub pose: Pose,
    /// False for what was held: walls, ceilings, unmovable objects and their kin.
    pub simulated: bool,
    /// Distance of the centre of mass from its input place, m.
    pub moved: f64,
    /// Angle from its input rotation, rad.
    pub turned: f64,
    /// Turned by more than 30° from its input.
    pub fallen: bool,
    /// True if its declared support no longer bears it at the end.
    pub lost_support: bool,
    /// Deepest overlap of its parts with another object's in the result, m.
    pub overlap: f64,
    /// Distance moved during the check, m.
    pub drift: f64,
    /// Angle turned during the check, rad.
    pub drift_turn: f64,
    /// Peak speed during the check, m/s.
    pub peak_speed: f64,
    /// Peak angular speed during the check, rad/s.
    pub peak_spin: f64,
    /// Drift and turn within the limits of `VerifySettings`, and no more than 2 mm deep in another object.
    pub stable: bool,
    /// False if it leaves those limits with another decomposition of the meshes (`shape::Alternative`).
    pub stable_otherwise: bool,
}

/// Wall time by stage, s.
#[derive(Clone, Copy, Debug, Default)]
pub struct Timings {
    /// Setting the objects onto their supports.
    pub seat: f64,
    /// Local groups.
    pub local: f64,
    /// Global stage.
    pub global: f64,
    /// Settling, and the second opinion.
    pub settle: f64,
    /// Parting of the meshes.
    pub exact: f64,
    /// Check.
    pub verify: f64,
}

/// The result of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// In the scene's order.
    pub objects: Vec<ObjectOutcome>,
    /// The convex parts with which the result was checked, of every object.
    pub parts: Vec<Vec<Part>>,
    /// Searched groups in order.
    pub groups: Vec<GroupRecord>,
    /// All iterations in order.
    pub iterations: Vec<IterationRecord>,
    /// False if it was stopped before the end: the best layout so far.
    pub finished: bool,
    /// Wall time.
    pub timings: Timings,
    /// Time that settling took in the simulation, s.
    pub settled_after: f64,
    /// True if everything came to rest while settling.
    pub at_rest: bool,
    /// Walls and ceiling, given or fitted.
    pub room: Room,
    /// For every object in the scene's order: what was done to put it onto its wall or ceiling; none for what has
    /// neither.
    pub placements: Vec<Option<Placement>>,
    /// How the meshes themselves lie.
    pub clearances: Clearances,
    /// What the user should know, in whole sentences.
    pub notes: Vec<String>,
}
