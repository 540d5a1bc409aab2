//! `simulate --replay`: a candidate of a finished run, found again from the run's seed.

use super::progress::SearchProgress;
use super::simulate::Motion;
use super::{Failure, interrupt, say};
use rest3d_gpu::optimize::{self, Candidate, Config, Rig};
use rest3d_gpu::scene::Scene;
use rest3d_gpu::shape::Shape;
use rest3d_gpu::world::{Backend, IterationStats};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::fs;
use std::path::{Path, PathBuf};

/// What is read of report.json.
#[derive(Deserialize)]
struct Report {
    seed: u64,
    config: Config,
    objects: Vec<Named>,
    iterations: Vec<Iteration>,
    /// There if the run made its scene canonical first.
    canonicalization: Option<IgnoredAny>,
}

/// A finished run.
pub struct Finished {
    /// The report's file.
    file: PathBuf,
    report: Report,
}

impl Finished {
    /// Reads what `optimize` left in `dir`.
    pub fn read(dir: &Path) -> Result<Self, Failure> {
        let file = dir.join("report.json");
        let refuse = |problem: String| {
            let file = file.display();
            Failure::Input(format!("{file}: {problem}; --run takes the folder that `optimize` left"))
        };
        let text = fs::read_to_string(&file).map_err(|error| refuse(format!("cannot be read: {error}")))?;
        let report = serde_json::from_str(&text).map_err(|error| refuse(error.to_string()))?;
        Ok(Self { file, report })
    }

    /// Refuses a scene with other objects than the run's.
    pub fn check(&self, scene: &Scene) -> Result<(), Failure> {
        let (here, there) = (&scene.objects, &self.report.objects);
        if here.iter().map(|object| &object.name).eq(there.iter().map(|object| &object.name)) {
            return Ok(());
        }
        let (file, scene) = (self.file.display(), scene.file.display());
        Err(Failure::Input(format!(
            "{file}: it is of another scene than {scene}: the objects differ; take the scene that it names"
        )))
    }

    /// True if it was run with `--canonicalize`.
    pub fn was_canonicalized(&self) -> bool {
        self.report.canonicalization.is_some()
    }
}

#[derive(Deserialize)]
struct Named {
    name: String,
}

#[derive(Deserialize)]
struct Iteration {
    group: usize,
    iteration: u32,
    iteration_best: Option<f32>,
}

/// Finds the candidate; the objects of `scene` are put where they were when it was placed.
pub fn motion(
    scene: &mut Scene,
    shapes: &[Shape],
    rigs: &[Rig],
    backend: &dyn Backend,
    candidate: Candidate,
    Finished { file, report }: &Finished,
) -> Result<Motion, Failure> {
    let stop = interrupt::watch()?;
    let mut progress = SearchProgress::new();
    let mut watch = interrupt::Watch::new(&stop, |event| progress.show(event));
    let found = optimize::replay(scene, shapes, backend, &report.config, report.seed, candidate, &mut watch);
    progress.finish();
    let found = found?;
    if !same(&report.iterations, candidate, &found.stats) {
        say(format_args!(
            "warning: {}: this iteration went otherwise there: another scene, machine, backend or version",
            file.display()
        ));
    }
    for (object, pose) in scene.objects.iter_mut().zip(&found.layout) {
        object.pose = *pose;
    }
    for (&object, pose) in found.objects.iter().zip(&found.placed) {
        scene.objects[object].pose = rigs[object].object(&pose.raised(-found.lift));
    }
    Ok(Motion {
        world: found.world,
        objects: found.objects,
        placed: found.placed,
        lift: found.lift,
        settings: found.simulation,
    })
}

/// Whether the iteration that was found again is the one of the report.
fn same(iterations: &[Iteration], candidate: Candidate, stats: &IterationStats) -> bool {
    let there =
        iterations.iter().find(|there| (there.group, there.iteration) == (candidate.stage, candidate.iteration));
    there.is_some_and(|there| there.iteration_best.unwrap_or(f32::INFINITY) == stats.iteration_best)
}
