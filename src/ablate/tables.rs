//! The variants and the paper's numbers of them (REST3D, ablation tables; means of its three data sets).

use crate::optimize::{Config, Scope};

/// One of the paper's tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    /// Canonicalization, scene tree, global-only.
    Structure,
    /// Energy terms.
    Energy,
    /// Elite fraction.
    Elites,
}

/// What is done with a scene before it is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Variant {
    /// Nothing: the reconstruction as it is, or canonicalized.
    Standing {
        /// Upright, on the ground, at the heights of the supports.
        canonical: bool,
        /// False: nothing is known of supports, so that what hangs on a wall falls.
        tree: bool,
    },
    /// It is canonicalized and searched, with a change to the configuration.
    Searched(Change),
    /// It is canonicalized and projected onto what does not overlap, then simulated to rest.
    Projected(Scope),
}

/// How a variant's configuration differs from the one that is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// Not at all.
    None,
    /// No local groups.
    GlobalOnly,
    /// One term of the energy weighs nothing.
    Without(Term),
    /// The share ρ of a population that are elites, of local groups and of the whole.
    EliteFraction(f32),
}

/// A term of the energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Term {
    /// E_stab.
    Stability,
    /// E_vel.
    Velocity,
    /// E_pen.
    Penetration,
    /// E_layout.
    Layout,
}

/// A row: a variant and what the paper has of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Its name in files and on the screen.
    pub label: &'static str,
    /// What is done.
    pub variant: Variant,
    /// The paper's numbers.
    pub paper: Paper,
}

/// The paper's numbers of a variant; none where its table has no such column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paper {
    /// Share of scenes without a valid result, %.
    pub failure_rate_pct: Option<f64>,
    /// Share of objects whose mesh meets another's, %.
    pub collision_rate_pct: Option<f64>,
    /// Share of objects that stay, %.
    pub stable_rate_pct: f64,
    /// m.
    pub drift_m: f64,
    /// Peak, m/s.
    pub linear_mps: f64,
    /// Peak, rad/s.
    pub angular_radps: f64,
    /// m.
    pub chamfer_m: Option<f64>,
    /// 0 to 1.
    pub f_score: Option<f64>,
}

impl Table {
    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Structure => "structure",
            Self::Energy => "energy",
            Self::Elites => "elites",
        }
    }

    /// What it shows.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Structure => "Canonicalization, scene tree, and what replaces the search",
            Self::Energy => "Energy terms",
            Self::Elites => "Elite fraction",
        }
    }

    /// Its rows, the whole method last or among its like.
    pub fn rows(self) -> Vec<Row> {
        match self {
            Self::Structure => vec![
                standing("raw", (false, false), paper(45.1, [12.0, 1.111, 1.939, 10.246])),
                standing("raw + tree", (false, true), paper(45.1, [36.6, 0.714, 1.195, 6.916])),
                standing("canonicalized", (true, false), paper(26.3, [45.8, 0.767, 1.227, 9.724])),
                standing("canonicalized + tree", (true, true), paper(26.3, [70.6, 0.334, 0.488, 2.902])),
                Row {
                    paper: paper(4.3, [89.4, 0.116, 0.281, 1.903]).failing(10.0),
                    ..searched("global-only", Change::GlobalOnly)
                },
                projected(
                    "projection, global-only",
                    Scope::Objects,
                    paper(3.5, [75.3, 0.238, 0.328, 2.609]).failing(15.0),
                ),
                projected(
                    "projection, global-local",
                    Scope::Groups,
                    paper(3.0, [70.4, 0.275, 0.377, 2.890]).failing(12.5),
                ),
                searched("whole method", Change::None),
            ],
            Self::Energy => vec![
                without(
                    "w/o E_stab",
                    Term::Stability,
                    paper(4.4, [90.8, 0.136, 0.260, 1.423]).failing(5.0),
                    [0.018, 0.820],
                ),
                without("w/o E_vel", Term::Velocity, paper(5.5, [92.8, 0.109, 0.168, 0.798]), [0.017, 0.823]),
                without("w/o E_pen", Term::Penetration, paper(9.6, [92.2, 0.103, 0.179, 1.320]), [0.016, 0.828]),
                without("w/o E_layout", Term::Layout, paper(2.2, [91.8, 0.075, 0.144, 0.778]), [0.024, 0.726]),
                searched("whole method", Change::None),
            ],
            Self::Elites => vec![
                elites("ρ = 0.01", 0.01, [92.0, 0.081, 0.204, 1.047]),
                elites("ρ = 0.025", 0.025, [94.9, 0.072, 0.138, 0.880]),
                elites("ρ = 0.05", 0.05, [92.9, 0.107, 0.199, 0.911]),
                elites("ρ = 0.1", 0.1, [91.2, 0.060, 0.192, 1.087]),
                elites("ρ = 0.2", 0.2, [90.2, 0.109, 0.231, 1.223]),
                elites("ρ = 0.5", 0.5, [83.0, 0.124, 0.276, 1.535]),
            ],
        }
    }
}

impl Change {
    /// The configuration of the variant.
    pub fn apply(self, config: &Config) -> Config {
        let mut config = config.clone();
        match self {
            Self::None => {}
            Self::GlobalOnly => config.global_only = true,
            Self::Without(Term::Stability) => config.energy.stability = 0.0,
            Self::Without(Term::Velocity) => config.energy.velocity = 0.0,
            Self::Without(Term::Penetration) => config.energy.penetration = 0.0,
            Self::Without(Term::Layout) => config.energy.layout = 0.0,
            Self::EliteFraction(share) => {
                config.local.elite_fraction = share;
                config.global.elite_fraction = share;
            }
        }
        config
    }
}

impl Paper {
    fn failing(self, failure_rate_pct: f64) -> Self {
        Self { failure_rate_pct: Some(failure_rate_pct), ..self }
    }
}

/// Collision rate, then stable rate, drift, linear and angular velocity; no failures.
fn paper(collision_rate_pct: f64, motion: [f64; 4]) -> Paper {
    Paper { failure_rate_pct: Some(0.0), collision_rate_pct: Some(collision_rate_pct), ..moving(motion) }
}

fn moving([stable_rate_pct, drift_m, linear_mps, angular_radps]: [f64; 4]) -> Paper {
    Paper {
        failure_rate_pct: None,
        collision_rate_pct: None,
        stable_rate_pct,
        drift_m,
        linear_mps,
        angular_radps,
        chamfer_m: None,
        f_score: None,
    }
}

fn standing(label: &'static str, (canonical, tree): (bool, bool), paper: Paper) -> Row {
    Row { label, variant: Variant::Standing { canonical, tree }, paper }
}

/// With the numbers of the whole method.
fn searched(label: &'static str, change: Change) -> Row {
    let whole = Paper { chamfer_m: Some(0.017), f_score: Some(0.824), ..paper(2.7, [94.9, 0.072, 0.138, 0.880]) };
    Row { label, variant: Variant::Searched(change), paper: whole }
}

fn projected(label: &'static str, scope: Scope, paper: Paper) -> Row {
    Row { label, variant: Variant::Projected(scope), paper }
}

fn without(label: &'static str, term: Term, paper: Paper, [chamfer_m, f_score]: [f64; 2]) -> Row {
    let paper = Paper { chamfer_m: Some(chamfer_m), f_score: Some(f_score), ..paper };
    Row { paper, ..searched(label, Change::Without(term)) }
}

fn elites(label: &'static str, share: f32, motion: [f64; 4]) -> Row {
    Row { paper: moving(motion), ..searched(label, Change::EliteFraction(share)) }
}
