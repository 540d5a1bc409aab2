//! What the optimizer may ask of a simulator, whichever processor it runs on.

use super::{
    CemSettings, EnergyWeights, KernelTime, MemoryPlan, NarrowPhase, Pose, Rollouts, Round, SimSettings, Status,
    Velocity, World,
};
use serde::{Deserialize, Deserializer, Serialize};
use thiserror::Error;

/// Why a backend could not do its work.
#[derive(Debug, Error)]
pub enum BackendError {
    /// The scene does not fit; the message says what and how to shrink it.
    #[error("{0}")]
    Capacity(String),
    /// The settings ask for what it does not have; the message says what to ask for instead.
    #[error("{0}")]
    Unsupported(String),
    /// The device failed.
    #[error("{0}")]
    Device(String),
}

/// Sees the step's number and all candidates' poses and velocities after it, candidate-major.
pub type OnStep<'a> = dyn FnMut(u32, &[Pose], &[Velocity]) -> Flow + 'a;

/// Sees a candidate's number, and its poses and velocities after a step.
pub type OnCandidate<'a> = dyn FnMut(usize, &[Pose], &[Velocity]) -> Flow + 'a;

/// Simulates many copies of one small world.
///
/// # Errors
/// What gives a `Result` here and in `Search` fails with `Capacity` where the world or the candidates do not fit onto the
/// device, with `Unsupported` where the settings ask for a narrow phase that it does not have, and with `Device` where the
/// device itself failed. What goes wrong in a candidate is no error but its `Status`.
pub trait Backend: Send + Sync {
    /// One line for the report: name and processor.
    fn describe(&self) -> String;

    /// Equal for backends that give the same bits.
    fn arithmetic(&self) -> String {
        self.describe()
    }

    /// Hull–hull algorithms that it can be asked for.
    fn narrow_phases(&self) -> &'static [NarrowPhase] {
        &[NarrowPhase::Twin]
    }

    /// Candidates that keep all of it busy: simulations of fewer may as well run beside one another, from several
    /// threads. A backend that does one thing at a time says 1.
    fn busy_with(&self) -> usize {
        1
    }

    /// Steps every candidate of `starts` (candidate-major: `starts[candidate * bodies + body]`), at rest at first.
    /// `on_step` is called after every step. Gives each candidate's status.
    fn simulate(
        &self,
        world: &World,
        settings: &SimSettings,
        starts: &[Pose],
        on_step: &mut OnStep<'_>,
    ) -> Result<Vec<Status>, BackendError>;

    /// The same, but `on_candidate` is asked after every step of each candidate by itself, until it has enough of that
    /// one. What a backend can leave out then costs nothing more.
    fn simulate_each(
        &self,
        world: &World,
        settings: &SimSettings,
        starts: &[Pose],
        on_candidate: &mut OnCandidate<'_>,
    ) -> Result<Vec<Status>, BackendError> {
        let bodies = world.bodies.len().max(1);
        let mut going: Vec<usize> = (0..starts.len() / bodies).collect();
        self.simulate(world, settings, starts, &mut |_, poses, velocities| {
            going.retain(|&candidate| {
                let own = candidate * bodies..(candidate + 1) * bodies;
                on_candidate(candidate, &poses[own.clone()], &velocities[own]) == Flow::Continue
            });
            if going.is_empty() { Flow::Stop } else { Flow::Continue }
        })
    }

    /// What a search holds, told to the user before it starts.
    fn memory(&self, world: &World, settings: &SearchSettings) -> MemoryPlan {
        let cem = &settings.cem;
        MemoryPlan { bytes: u64::from(cem.drawn()) * world.slot_bytes(), at_once: cem.candidates }
    }

    /// Bytes that a search may hold; none if that is not known.
    fn free_bytes(&self) -> Option<u64> {
        None
    }

    /// How deep the two bodies of each of `World::pairs` overlap at `poses` (one for each body), m: the deepest of their hull
    /// pairs, 0 where none overlap.
    fn overlaps(&self, world: &World, settings: &SimSettings, poses: &[Pose]) -> Result<Vec<f32>, BackendError>;

    /// Simulates every candidate of `starts` from rest to its end, as fast as this backend can: what `bench` measures.
    fn rollouts(&self, world: &World, settings: &SimSettings, starts: &[Pose]) -> Result<Rollouts, BackendError> {
        let mut settled = starts.to_vec();
        let statuses = self.simulate(world, settings, starts, &mut |_, poses, _| {
            settled.copy_from_slice(poses);
            Flow::Continue
        })?;
        Ok(Rollouts { settled, statuses, contacts_per_substep: None })
    }

    /// How long each kernel works for such rollouts, in the order of a substep; empty where that is not known. Takes no
    /// longer than the rollouts themselves, and costs nothing otherwise.
    fn kernel_times(
        &self,
        _world: &World,
        _settings: &SimSettings,
        _starts: &[Pose],
    ) -> Result<Vec<KernelTime>, BackendError> {
        Ok(Vec::new())
    }

    /// Prepares a search over the world's units: all tables of its candidates are made here, none while it runs.
    fn search<'a>(
        &'a self,
        world: &'a World,
        settings: &'a SearchSettings,
        stream: Stream,
    ) -> Result<Box<dyn Search + 'a>, BackendError>;
}

/// Whether a simulation goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Next step.
    Continue,
    /// Enough.
    Stop,
}

/// Everything that a search needs besides the world.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct SearchSettings {
    /// Simulation of a candidate.
    pub simulation: SimSettings,
    /// Energy of a candidate.
    pub energy: EnergyWeights,
    /// Sampling and update.
    pub cem: CemSettings,
}

impl SearchSettings {
    /// What is simulated in an iteration.
    pub fn rounds(&self) -> Vec<Round> {
        self.cem.rounds(self.simulation.steps)
    }

    /// Steps of candidates in an iteration if none is given up.
    pub fn steps(&self) -> u64 {
        self.rounds().iter().map(|round| u64::from(round.candidates) * u64::from(round.steps)).sum()
    }
}

/// Names the random numbers of one search: same stream, same samples, whatever K or the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stream {
    /// The user's seed.
    pub seed: u64,
    /// Number of the group in the run.
    pub stage: u32,
}

/// The Gaussian that candidates are drawn from: six dimensions a unit (shift x y z in m, axis-angle x y z in rad).
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    /// Mean, `6 · units`.
    pub mean: Vec<f32>,
    /// Standard deviation, `6 · units`.
    pub std: Vec<f32>,
}

/// The four terms of the energy and their weighted sum.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable, Serialize, Deserialize)]
pub struct Energy {
    /// Weighted sum; +∞ for a candidate whose simulation failed or was given up.
    #[serde(deserialize_with = "null_is_infinite")]
    pub total: f32,
    /// E_stab: placed to settled, m + rad.
    pub stability: f32,
    /// E_vel: speed at step τ, m/s.
    pub velocity: f32,
    /// E_pen: pairs, or depth in units of `penetration_depth_unit`.
    pub penetration: f32,
    /// E_layout: settled to reference, λ_pos m + rad.
    pub layout: f32,
}

/// The best candidate so far, without its adjustment and poses.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Winner {
    /// Its energy; a total of +∞ says that no candidate was usable yet.
    pub energy: Energy,
    /// Iteration in which it was drawn.
    pub iteration: u32,
    /// Its index in that iteration.
    pub candidate: u32,
}

impl Winner {
    /// Before the first usable candidate.
    pub const NONE: Self = Self {
        energy: Energy { total: f32::INFINITY, stability: 0.0, velocity: 0.0, penetration: 0.0, layout: 0.0 },
        iteration: 0,
        candidate: 0,
    };

    /// True once a candidate was usable.
    pub fn is_known(&self) -> bool {
        self.energy.total.is_finite()
    }
}

/// What one iteration reports.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct IterationStats {
    /// Iteration since the search began, from 0.
    pub iteration: u32,
    /// Best energy ever seen; its total is +∞ before the first usable candidate.
    pub best: Energy,
    /// Best energy of this iteration; +∞ if no candidate was usable.
    #[serde(deserialize_with = "null_is_infinite")]
    pub iteration_best: f32,
    /// Mean total of this iteration's elites.
    #[serde(deserialize_with = "null_is_infinite")]
    pub elite_mean: f32,
    /// Candidates whose status has each bit of `Status::FAULTS`; of those that were given up (`CemSettings::prune`),
    /// until then.
    pub flagged: [u32; Status::FAULTS.len()],
    /// Steps that candidates were simulated for, all together.
    pub steps: u64,
}

/// JSON has no infinity: it is written as null.
fn null_is_infinite<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f32, D::Error> {
    Ok(Option::<f32>::deserialize(deserializer)?.unwrap_or(f32::INFINITY))
}

/// The best candidate ever seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Best {
    /// Its energy.
    pub energy: Energy,
    /// Iteration and index that name it for a replay.
    pub iteration: u32,
    /// Index within the iteration.
    pub candidate: u32,
    /// Its adjustment, `6 · units`.
    pub delta: Vec<f32>,
    /// Pose of every body at placement.
    pub placed: Vec<Pose>,
    /// Pose of every body at the end.
    pub settled: Vec<Pose>,
}

/// A running Cross-Entropy search.
pub trait Search {
    /// Samples, simulates, ranks and updates once.
    fn iterate(&mut self) -> Result<IterationStats, BackendError>;
    /// What each kernel took since the search began, all iterations together; empty where that is not known.
    fn kernel_times(&self) -> Vec<KernelTime> {
        Vec::new()
    }
    /// Energies of the last iteration, by candidate.
    fn energies(&self) -> Result<Vec<Energy>, BackendError>;
    /// The distribution that the next iteration samples from.
    fn distribution(&self) -> Distribution;
    /// Replaces it (start of an episode, resumed run).
    fn set_distribution(&mut self, distribution: &Distribution);
    /// Poses at placement of a candidate of the last iteration.
    fn placed(&self, candidate: u32) -> Result<Vec<Pose>, BackendError>;
    /// The best candidate so far; none before the first usable one.
    fn best(&mut self) -> Result<Option<Best>, BackendError>;
}
