//! One variant on one scene, from its start to its numbers.

use super::subject::{Stage, Subject};
use super::tables::Variant;
use crate::metrics::{self, STEPS};
use crate::optimize::{self, Baseline, Config, Observer, OptimizeError, Rig, Scope, project_and_settle};
use crate::scene::Scene;
use crate::shape::Mesh;
use crate::world::{Backend, BackendError};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// What is stored of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// The name of the scene.
    pub scene: String,
    /// The row of the table for which it was run first.
    pub variant: String,
    /// Wall time without the measuring, s.
    pub seconds: f64,
    /// How it ended.
    pub ended: Ended,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ended {
    /// With a result.
    Result(Measured),
    /// Without a valid one, and why: it counts in the failure rate.
    Failure(String),
}

/// The numbers of one result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Objects in the scene.
    pub objects: usize,
    /// Those that may move: over these are all means of motion.
    pub movable: usize,
    /// Share of all objects whose surface meets another's, %.
    pub collision_rate_pct: f64,
    /// The same, deeper than 1 mm.
    pub collision_rate_1mm_pct: f64,
    /// Share of objects that stay within 0.1 m and 0.1 rad, %.
    pub stable_rate_pct: f64,
    /// Mean distance from placed to settled, m.
    pub drift_m: f64,
    /// Mean of the highest speeds, m/s.
    pub linear_mps: f64,
    /// Mean of the highest spins, rad/s.
    pub angular_radps: f64,
    /// Mean distance of the objects from the canonicalized scene, m; none of scenes with fewer than three objects.
    pub moved_m: Option<f64>,
    /// Objects turned by more than 30° from there: they may lie still, which no stability metric sees.
    pub fallen: Option<usize>,
    /// Chamfer distance from the reference, m.
    pub chamfer_m: Option<f64>,
    /// F-score at 5 cm, 0 to 1.
    pub f_score: Option<f64>,
}

/// Names a run by everything that its result depends on: equal for equal runs, whatever they are called. `program`
/// stands for the program and what it computes on.
pub fn identity(subject: &Subject, variant: Variant, config: &Config, seed: u64, program: &str) -> String {
    let mut hasher = blake3::Hasher::new();
    let (stage, config, what) = match variant {
        Variant::Standing { canonical, tree } => {
            let stage = if canonical { &subject.canonical } else { &subject.raw };
            (stage, Config::default(), format!("standing {tree}"))
        }
        Variant::Searched(change) => (&subject.canonical, change.apply(config), format!("searched {seed}")),
        Variant::Projected(scope) => (&subject.canonical, config.clone(), format!("projected {scope:?}")),
    };
    hasher.update(program.as_bytes());
    hasher.update(what.as_bytes());
    hasher.update(optimize::identity(&stage.scene, &stage.shapes, &config).as_bytes());
    let (reference, meshes) = match &subject.reference {
        Some((scene, meshes)) => (optimize::identity(scene, &[], &Config::default()), &meshes[..]),
        None => (String::new(), &[][..]),
    };
    hasher.update(reference.as_bytes());
    for mesh in subject.meshes.iter().chain(meshes) {
        hasher.update(&(mesh.vertices.len() as u64).to_le_bytes());
        hasher.update(bytemuck::cast_slice(&mesh.vertices));
        hasher.update(bytemuck::cast_slice(&mesh.triangles));
    }
    hasher.finalize().to_hex()[..32].to_owned()
}

/// Carries a variant out and measures its result; none if the observer stopped it.
///
/// # Errors
/// A device that failed. What keeps a single scene from its result is a [`Ended::Failure`] instead.
pub fn run(
    subject: &Subject,
    variant: Variant,
    config: &Config,
    seed: u64,
    backend: &dyn Backend,
    observer: &mut dyn Observer,
) -> Result<Option<(Ended, f64)>, OptimizeError> {
    let clock = Instant::now();
    let (result, stage) = match variant {
        Variant::Standing { canonical, tree } => {
            let stage = if canonical { &subject.canonical } else { &subject.raw };
            let scene = if tree { stage.scene.clone() } else { stage.scene.without_tree() };
            (Ok(scene), stage)
        }
        Variant::Searched(change) => {
            let Some(result) = searched(&subject.canonical, &change.apply(config), seed, backend, observer)? else {
                return Ok(None);
            };
            (result, &subject.canonical)
        }
        Variant::Projected(scope) => (projected(&subject.canonical, config, scope, backend)?, &subject.canonical),
    };
    let seconds = clock.elapsed().as_secs_f64();
    let ended = match result {
        Ok(scene) => measure(subject, stage, &scene, backend)?,
        Err(failure) => Ended::Failure(failure),
    };
    Ok(Some((ended, seconds)))
}

/// The scene as a search leaves it, or why it leaves none; none if it was stopped.
fn searched(
    stage: &Stage,
    config: &Config,
    seed: u64,
    backend: &dyn Backend,
    observer: &mut dyn Observer,
) -> Result<Option<Result<Scene, String>>, OptimizeError> {
    let Stage { scene, shapes } = stage;
    let outcome = match optimize::run(scene, shapes, backend, config, seed, None, observer) {
        Ok(outcome) => outcome,
        Err(OptimizeError::Backend(BackendError::Capacity(problem))) => return Ok(Some(Err(problem))),
        Err(error) => return Err(error),
    };
    if !outcome.finished {
        return Ok(None);
    }
    if let Some(group) = outcome.groups.iter().find(|group| group.best.is_none()) {
        return Ok(Some(Err(format!("no candidate of group {} could be simulated", group.name))));
    }
    Ok(Some(Ok(scene.with_poses(outcome.objects.iter().map(|object| object.pose)))))
}

/// The scene as projection and simulation leave it, or why they leave none.
fn projected(
    stage: &Stage,
    config: &Config,
    scope: Scope,
    backend: &dyn Backend,
) -> Result<Result<Scene, String>, OptimizeError> {
    let baseline = match project_and_settle(&stage.scene, &stage.shapes, backend, config, scope) {
        Ok(baseline) => baseline,
        Err(OptimizeError::Backend(BackendError::Capacity(problem))) => return Ok(Err(problem)),
        Err(error) => return Err(error),
    };
    Ok(match baseline {
        Baseline { projection, .. } if !projection.converged => {
            Err(format!("the projection did not converge in {} rounds", projection.rounds))
        }
        Baseline { layout: Some(layout), .. } => Ok(stage.scene.with_poses(layout)),
        Baseline { layout: None, .. } => Err("the projected layout could not be simulated".into()),
    })
}

fn measure(subject: &Subject, stage: &Stage, scene: &Scene, backend: &dyn Backend) -> Result<Ended, BackendError> {
    if let Some(lost) = scene.objects.iter().find(|object| !object.pose.is_finite()) {
        return Ok(Ended::Failure(format!("object \"{}\" has no pose in the result", lost.name)));
    }
    let rigs: Vec<Rig> = stage.shapes.iter().map(Rig::new).collect();
    let stability = metrics::stability(scene, &rigs, backend, STEPS)?;
    if !stability.valid {
        return Ok(Ended::Failure("the simulation of the result did not stay finite".into()));
    }
    let Some(means) = stability.means else {
        return Ok(Ended::Failure("nothing in the scene can move".into()));
    };
    let meshes: &[Mesh] = &subject.meshes;
    let ours = (scene, meshes);
    let collision = metrics::collision(scene, meshes);
    let layout = metrics::layout(ours, (&subject.canonical.scene, meshes));
    let geometry = (subject.reference.as_ref())
        .and_then(|(reference, reference_meshes)| metrics::geometry(ours, (reference, reference_meshes)));
    Ok(Ended::Result(Measured {
        objects: scene.objects.len(),
        movable: stability.movable,
        collision_rate_pct: collision.strict.collision_rate_pct,
        collision_rate_1mm_pct: collision.deeper_than_1mm.collision_rate_pct,
        stable_rate_pct: means.stable_rate_pct,
        drift_m: means.mean_position_drift_m,
        linear_mps: means.mean_peak_linear_velocity_mps,
        angular_radps: means.mean_peak_angular_velocity_radps,
        moved_m: layout.as_ref().map(|layout| layout.mean_translation_m),
        fallen: layout.as_ref().map(|layout| layout.fallen.len()),
        chamfer_m: geometry.as_ref().map(|geometry| geometry.chamfer_distance_m),
        f_score: geometry.as_ref().map(|geometry| geometry.f_score),
    }))
}
