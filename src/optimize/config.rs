//! The configuration file: every number of a run, read from TOML.

use crate::world::{CemSettings, EnergyWeights, SimSettings};
use serde::{Deserialize, Serialize};

/// One configuration file. Missing keys take the paper's values; unknown keys are errors.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// How a candidate is simulated.
    pub simulation: SimSettings,
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

/// The winner is simulated to rest with damping and a slow push-out; the poses where it rests are the result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SettleSettings {
    /// Longest time, s.
    pub max_seconds: f32,
    /// At rest when no object is faster than this, m/s (and rad/s), for half a second.
    pub rest_speed: f32,
    /// Fastest push-out, m/s.
    pub max_push_out: f32,
    /// Linear and angular damping, 1/s.
    pub damping: f32,
}

impl Default for SettleSettings {
    fn default() -> Self {
        Self { max_seconds: 5.0, rest_speed: 1e-3, max_push_out: 0.3, damping: 3.0 }
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
