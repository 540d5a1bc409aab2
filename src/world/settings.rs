//! Parameters of the simulation, the energy and the search, as the configuration files name them.

use super::Distribution;
use serde::{Deserialize, Serialize};

/// How a candidate is simulated. Defaults are the paper's (Isaac Gym's PhysX settings), but for `contact_offset`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SimSettings {
    /// Length of one step, s.
    pub dt: f32,
    /// Number of steps L.
    pub steps: u32,
    /// Collision detections per step.
    pub substeps: u32,
    /// Solver iterations per substep; each advances the bodies by `dt / (substeps · iterations)` (temporal
    /// Gauss–Seidel).
    pub position_iterations: u32,
    /// Sweeps without push-out at the end of a substep. Those that end every small step count as the first: 0 and 1 add
    /// none.
    pub velocity_iterations: u32,
    /// Vertical acceleration, m/s².
    pub gravity: f32,
    /// Distance below which contacts are made, m. What moves looks farther, by as much as it may go in a substep, so that
    /// this need only cover what gravity adds to that: 2.7 mm in a substep of 1/60 s. The paper's is 0.01.
    pub contact_offset: f32,
    /// Distance that resting surfaces keep, m.
    pub rest_offset: f32,
    /// Fastest speed at which overlap is pushed apart, m/s.
    pub max_push_out: f32,
    /// Share of linear velocity lost per second, 1/s.
    pub linear_damping: f32,
    /// Share of angular velocity lost per second, 1/s.
    pub angular_damping: f32,
    /// Coulomb coefficient of every contact.
    pub friction: f32,
    /// Step τ at which velocities enter the energy.
    pub snapshot_step: u32,
    /// Which hull–hull algorithm runs.
    pub narrow_phase: NarrowPhase,
}

impl Default for SimSettings {
    fn default() -> Self {
        Self {
            dt: 1.0 / 60.0,
            steps: 60,
            substeps: 2,
            position_iterations: 6,
            velocity_iterations: 1,
            gravity: -9.8,
            contact_offset: 0.004,
            rest_offset: 0.0,
            max_push_out: 5.0,
            linear_damping: 0.3,
            angular_damping: 0.3,
            friction: 1.0,
            snapshot_step: 15,
            narrow_phase: NarrowPhase::Twin,
        }
    }
}

impl SimSettings {
    /// Length of a substep, s.
    pub fn substep(&self) -> f32 {
        self.dt / self.substeps.max(1) as f32
    }

    /// Length of a small step, of which the solver makes `position_iterations` a substep, s.
    pub fn small_step(&self) -> f32 {
        self.dt / (self.substeps.max(1) * self.position_iterations.max(1)) as f32
    }
}

/// The hull–hull algorithm of the CPU backend.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NarrowPhase {
    /// GJK and EPA of the parry library: the independent geometry that tests compare against.
    Reference,
    /// Separating axes, the algorithm of the shader.
    Twin,
}

/// Weights of the four energy terms (`E = λ_stab E_stab + λ_vel E_vel + λ_pen E_pen + λ_layout E_layout`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EnergyWeights {
    /// λ_stab, per metre and per radian between placed and settled.
    pub stability: f32,
    /// λ_vel, per m/s at step τ.
    pub velocity: f32,
    /// λ_pen, per intersecting object pair.
    pub penetration: f32,
    /// λ_layout, on the whole layout term.
    pub layout: f32,
    /// λ_pos, per metre inside the layout term (its rotation part weighs 1 per radian).
    pub position: f32,
    /// What a penetrating object pair costs.
    pub penetration_mode: PenetrationMode,
    /// Metres of depth that cost as much as one pair in `count` mode; used in `depth` mode.
    pub penetration_depth_unit: f32,
}

impl Default for EnergyWeights {
    fn default() -> Self {
        Self {
            stability: 1.0,
            velocity: 1.0,
            penetration: 0.5,
            layout: 1.0,
            position: 6.0,
            penetration_mode: PenetrationMode::Count,
            penetration_depth_unit: 0.02,
        }
    }
}

/// How penetration of an object pair is measured, at placement and again after settlement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PenetrationMode {
    /// 1 for a pair whose parts overlap by more than the touching tolerance, else 0 (the paper).
    Count,
    /// Depth beyond the touching tolerance, in units of `penetration_depth_unit`: guides the search where a count is
    /// flat.
    Depth,
}

/// The Cross-Entropy search of one group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CemSettings {
    /// Samples per iteration, K.
    pub candidates: u32,
    /// Iterations per episode, T.
    pub iterations: u32,
    /// Episodes; each starts from the distribution that the previous one left.
    pub episodes: u32,
    /// ρ: the elites are the best ⌈ρK⌉.
    pub elite_fraction: f32,
    /// Initial standard deviation of the shifts (x, y, z), m.
    pub translation_std: [f32; 3],
    /// Initial standard deviation of the axis-angle turns (x, y, z), rad.
    pub rotation_std: [f32; 3],
    /// Added to every updated standard deviation, m and rad.
    pub std_epsilon: f32,
    /// No standard deviation falls below this share of its initial value.
    pub std_floor: f32,
    /// At the start of an episode after the first, no standard deviation is below this share of its initial value.
    pub restart_std: f32,
    /// A group is done when its best energy falls below this …
    pub stop_energy: f32,
    /// … or that without the layout term does, and this term is below this for each of its objects on average.
    pub stop_layout_each: f32,
    /// An episode is done when the mean energy of the elites has not fallen by 1 % in so many iterations; 0: never.
    pub patience: u32,
    /// Candidate 0 of every iteration is the mean itself, at first the layout as it stands, instead of a sample; it
    /// goes on from round to round as any other.
    pub sample_mean: bool,
    /// Candidates 2i and 2i + 1 mirror each other about the mean (Hammersley and Morton's antithetic variates): half as
    /// many random numbers, with no bias of the elites to one side.
    pub antithetic: bool,
    /// So many times K samples are drawn, of which those K are simulated that cost least as they are placed; 1: all.
    pub draws: u32,
    /// The K are simulated for so many steps, and only the best of them to the end; 0: all.
    pub short_steps: u32,
    /// Share of the K that then go on, no fewer than the elites.
    pub finalists: f32,
    /// The CPU backend gives up candidates that are sure to cost more than the elites, with the same result.
    pub prune: bool,
}

impl Default for CemSettings {
    fn default() -> Self {
        Self {
            candidates: 2048,
            iterations: 15,
            episodes: 2,
            elite_fraction: 0.025,
            translation_std: [0.05, 0.005, 0.05],
            rotation_std: [0.005, 0.05, 0.005],
            std_epsilon: 1e-5,
            std_floor: 0.0,
            restart_std: 0.0,
            stop_energy: 0.01,
            stop_layout_each: 0.0,
            patience: 0,
            sample_mean: false,
            antithetic: false,
            draws: 1,
            short_steps: 0,
            finalists: 0.25,
            prune: true,
        }
    }
}

/// Some candidates of an iteration are simulated from placement; the best of them go on to the next round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Round {
    /// How many.
    pub candidates: u32,
    /// For how many steps; 0 measures them as they are placed.
    pub steps: u32,
}

impl CemSettings {
    /// ⌈ρK⌉, at least 1 and at most K. ρ is read as the decimal that the user wrote: 0.025 · 2048 gives 52, 0.1 · 10
    /// gives 1.
    pub fn elite_count(&self) -> u32 {
        self.share(self.elite_fraction)
    }

    /// ⌈`fraction` · K⌉, at least 1 and at most K.
    fn share(&self, fraction: f32) -> u32 {
        let share = f64::from(fraction) * f64::from(self.candidates);
        ((share - 1e-4).ceil().max(1.0) as u32).min(self.candidates)
    }

    /// Samples per iteration.
    pub fn drawn(&self) -> u32 {
        self.candidates.saturating_mul(self.draws.max(1))
    }

    /// What is simulated in an iteration, first all that is drawn; the last round is the one that counts.
    pub fn rounds(&self, steps: u32) -> Vec<Round> {
        let screening = Round { candidates: self.drawn(), steps: 0 };
        let short = Round { candidates: self.candidates, steps: self.short_steps };
        let is_short = (1..steps).contains(&self.short_steps);
        let last = if is_short { self.share(self.finalists).max(self.elite_count()) } else { self.candidates };
        let screening = (self.drawn() > self.candidates).then_some(screening);
        screening.into_iter().chain(is_short.then_some(short)).chain([Round { candidates: last, steps }]).collect()
    }

    /// The distribution that a search of so many units starts from: zero mean, the same deviations for every unit.
    pub fn initial(&self, units: usize) -> Distribution {
        let [[x, y, z], [a, b, c]] = [self.translation_std, self.rotation_std];
        Distribution { mean: vec![0.0; 6 * units], std: [x, y, z, a, b, c].repeat(units) }
    }
}
