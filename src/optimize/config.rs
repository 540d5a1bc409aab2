//! The configuration file: every number of a run, read from TOML.

use super::OptimizeError;
use crate::world::{CemSettings, EnergyWeights, SimSettings};
use serde::{Deserialize, Serialize};

/// Most substeps of a step and iterations of a substep.
const MAX_REPEATS: u32 = 256;

/// Longest simulation of one layout, s.
const MAX_SECONDS: f32 = 3600.0;

/// One configuration file. Missing keys take the paper's values (`contact_offset` ours); unknown keys are errors.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// How a candidate is simulated.
    pub simulation: SimSettings,
    /// True: objects are set onto their supports before the search. False: they start where the scene says.
    pub seat: bool,
    /// True: what is on walls and ceiling is put there, and walls bear. False: it stays where the scene says.
    pub room: bool,
    /// True: meshes that touch in the result are parted. False: they are only reported.
    pub exact: bool,
    /// True: what does not stand with another decomposition of the meshes or on slopes, or is off its support, is
    /// searched again.
    pub second_opinion: bool,
    /// True: no local groups; every object is searched by itself, all in one search of the whole scene.
    pub global_only: bool,
    /// True: every search also starts from its group's projection onto what does not overlap, and goes on from the
    /// better of the two starts.
    pub project: bool,
    /// What a candidate costs.
    pub energy: EnergyWeights,
    /// The search of a local group.
    pub local: CemSettings,
    /// The search over the whole scene.
    pub global: CemSettings,
    /// The last descent of the winner.
    pub settle: SettleSettings,
    /// The check of the result.
    pub verify: VerifySettings,
}

impl Config {
    /// How many candidates a search simulates at a time, at most.
    pub fn candidates(&self) -> u32 {
        self.local.candidates.max(self.global.candidates)
    }

    /// The simulation that settles and checks the result: the candidates', at no less than the paper's resolution.
    pub(super) fn fine(&self) -> SimSettings {
        let paper = SimSettings::default();
        SimSettings {
            substeps: self.simulation.substeps.max(paper.substeps),
            position_iterations: self.simulation.position_iterations.max(paper.position_iterations),
            ..self.simulation.clone()
        }
    }
}

/// The winner is simulated to rest with damping and a slow push-out; the poses where it rests are the result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SettleSettings {
    /// Longest time, s; 0 leaves the winner as it is (the paper).
    pub max_seconds: f32,
    /// At rest when no object is faster than this, m/s (and rad/s), for half a second.
    pub rest_speed: f32,
    /// Fastest push-out, m/s.
    pub max_push_out: f32,
    /// Linear and angular damping, 1/s.
    pub damping: f32,
    /// Which poses of the global winner the descent starts from.
    pub from: ResultFrom,
}

/// Poses of a winning candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ResultFrom {
    /// Where the search placed its objects (the paper's result).
    Placed,
    /// Where they were at the end of the candidate's simulation.
    Settled,
}

impl Default for SettleSettings {
    fn default() -> Self {
        Self { max_seconds: 0.0, rest_speed: 1e-3, max_push_out: 0.3, damping: 3.0, from: ResultFrom::Placed }
    }
}

/// The result is simulated once more with the settings of a candidate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VerifySettings {
    /// s.
    pub seconds: f32,
    /// An object that moved farther is unstable, m (the paper's metric).
    pub max_drift: f32,
    /// An object that turned farther is unstable, rad.
    pub max_turn: f32,
}

impl Default for VerifySettings {
    fn default() -> Self {
        Self { seconds: 5.0, max_drift: 0.1, max_turn: 0.1 }
    }
}

impl Config {
    /// Refuses numbers that make no sense.
    ///
    /// # Errors
    /// `OptimizeError::Config` naming the first such key, its value and what it should be.
    pub fn validate(&self) -> Result<(), OptimizeError> {
        let sim = &self.simulation;
        within("simulation.dt", sim.dt, 1e-5, 1.0)?;
        count("simulation.steps", sim.steps, 1, 1_000_000)?;
        count("simulation.substeps", sim.substeps, 1, MAX_REPEATS)?;
        count("simulation.position_iterations", sim.position_iterations, 1, MAX_REPEATS)?;
        count("simulation.velocity_iterations", sim.velocity_iterations, 0, MAX_REPEATS)?;
        within("simulation.gravity", sim.gravity, -1000.0, 0.0)?;
        within("simulation.contact_offset", sim.contact_offset, 0.0, 1.0)?;
        within("simulation.rest_offset", sim.rest_offset, 0.0, sim.contact_offset)?;
        not_negative("simulation.max_push_out", sim.max_push_out)?;
        not_negative("simulation.linear_damping", sim.linear_damping)?;
        not_negative("simulation.angular_damping", sim.angular_damping)?;
        not_negative("simulation.friction", sim.friction)?;
        if sim.snapshot_step == 0 || sim.snapshot_step > sim.steps {
            return refuse(
                "simulation.snapshot_step",
                sim.snapshot_step,
                "a step from 1 to `simulation.steps` (15 where it is not given)",
            );
        }
        let energy = &self.energy;
        not_negative("energy.stability", energy.stability)?;
        not_negative("energy.velocity", energy.velocity)?;
        not_negative("energy.penetration", energy.penetration)?;
        not_negative("energy.layout", energy.layout)?;
        not_negative("energy.position", energy.position)?;
        positive("energy.penetration_depth_unit", energy.penetration_depth_unit)?;
        validate_cem("local", &self.local, sim.snapshot_step)?;
        validate_cem("global", &self.global, sim.snapshot_step)?;
        within("settle.max_seconds", self.settle.max_seconds, 0.0, MAX_SECONDS)?;
        not_negative("settle.rest_speed", self.settle.rest_speed)?;
        not_negative("settle.max_push_out", self.settle.max_push_out)?;
        not_negative("settle.damping", self.settle.damping)?;
        within("verify.seconds", self.verify.seconds, sim.dt, MAX_SECONDS)?;
        not_negative("verify.max_drift", self.verify.max_drift)?;
        not_negative("verify.max_turn", self.verify.max_turn)
    }
}

fn validate_cem(table: &str, cem: &CemSettings, snapshot_step: u32) -> Result<(), OptimizeError> {
    let key = |name: &str| format!("{table}.{name}");
    count(&key("candidates"), cem.candidates, 1, 1 << 24)?;
    count(&key("iterations"), cem.iterations, 1, 1_000_000)?;
    count(&key("episodes"), cem.episodes, 1, 1000)?;
    if !(cem.elite_fraction > 0.0 && cem.elite_fraction <= 1.0) {
        return refuse(&key("elite_fraction"), cem.elite_fraction, "above 0 and at most 1");
    }
    count(&key("draws"), cem.draws, 1, 1024)?;
    if cem.drawn() > 1 << 24 {
        let drawn = format!("{} for each of {} candidates", cem.draws, cem.candidates);
        return refuse(&key("draws"), drawn, format!("no more than {} in all", 1 << 24));
    }
    if cem.short_steps > 0 && cem.short_steps < snapshot_step {
        return refuse(&key("short_steps"), cem.short_steps, "0, or at least `simulation.snapshot_step`");
    }
    if !(cem.finalists > 0.0 && cem.finalists <= 1.0) {
        return refuse(&key("finalists"), cem.finalists, "above 0 and at most 1");
    }
    for std in cem.translation_std {
        within(&key("translation_std"), std, 0.0, 100.0)?;
    }
    for std in cem.rotation_std {
        within(&key("rotation_std"), std, 0.0, std::f32::consts::TAU)?;
    }
    not_negative(&key("std_epsilon"), cem.std_epsilon)?;
    not_negative(&key("std_floor"), cem.std_floor)?;
    not_negative(&key("restart_std"), cem.restart_std)?;
    not_negative(&key("stop_energy"), cem.stop_energy)?;
    not_negative(&key("stop_layout_each"), cem.stop_layout_each)
}

fn count(key: &str, value: u32, least: u32, most: u32) -> Result<(), OptimizeError> {
    if (least..=most).contains(&value) { Ok(()) } else { refuse(key, value, format!("from {least} to {most}")) }
}

fn within(key: &str, value: f32, least: f32, most: f32) -> Result<(), OptimizeError> {
    if (least..=most).contains(&value) { Ok(()) } else { refuse(key, value, format!("from {least} to {most}")) }
}

fn positive(key: &str, value: f32) -> Result<(), OptimizeError> {
    if value.is_finite() && value > 0.0 { Ok(()) } else { refuse(key, value, "a number above 0") }
}

fn not_negative(key: &str, value: f32) -> Result<(), OptimizeError> {
    if value.is_finite() && value >= 0.0 { Ok(()) } else { refuse(key, value, "a number from 0 up") }
}

fn refuse(key: &str, value: impl ToString, wanted: impl Into<String>) -> Result<(), OptimizeError> {
    Err(OptimizeError::Config { key: key.into(), value: value.to_string(), wanted: wanted.into() })
}
