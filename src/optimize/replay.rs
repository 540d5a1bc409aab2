//! Any candidate of a finished run once more, from the run's seed.
//!
//! Candidates are not stored: the stages before it are searched again, which gives the same bits on the same machine,
//! and its own stage up to its iteration.

use super::{Checkpoint, Config, Observer, OptimizeError, cem, run::Run};
use crate::scene::{self, Scene};
use crate::shape::Shape;
use crate::world::{Backend, Flow, IterationStats, Pose, SimSettings, Stream, World};

/// Names a candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Candidate {
    /// Index of the group in the plan.
    pub stage: usize,
    /// Iteration since the stage began, from 0.
    pub iteration: u32,
    /// Index within the iteration.
    pub index: u32,
}

/// What the candidate was simulated from.
#[derive(Clone, Debug)]
pub struct Replay {
    /// The group's bodies.
    pub world: World,
    /// Object of each body; the bodies after them are walls.
    pub objects: Vec<usize>,
    /// How far the group was raised for its simulation, m.
    pub lift: f32,
    /// Pose of every body at placement.
    pub placed: Vec<Pose>,
    /// Pose of every object when the stage began.
    pub layout: Vec<scene::Pose>,
    /// How it was simulated.
    pub simulation: SimSettings,
    /// The numbers of its iteration, to compare with the report's.
    pub stats: IterationStats,
}

/// Searches again until the candidate is placed. `observer` sees the stages before its own.
///
/// # Errors
/// `OptimizeError::Candidate` if the run has no such candidate, and whatever a run can end with.
pub fn replay(
    scene: &Scene,
    shapes: &[Shape],
    backend: &dyn Backend,
    config: &Config,
    seed: u64,
    candidate: Candidate,
    observer: &mut dyn Observer,
) -> Result<Replay, OptimizeError> {
    let none = |problem: String| Err(OptimizeError::Candidate(problem));
    let run = Run::new(scene, shapes, backend, config, seed, observer)?;
    let Candidate { stage, iteration, index } = candidate;
    let Some(group) = run.groups.get(stage) else {
        return none(format!(
            "there is no stage {stage}: the run has stages 0 to {}",
            run.groups.len().saturating_sub(1)
        ));
    };
    let settings = run.settings(group);
    if index >= settings.cem.drawn() {
        return none(format!("there is no candidate {index}: an iteration has {}", settings.cem.drawn()));
    }
    let mut state = Checkpoint::start(scene, shapes, config, seed);
    state.set_layout(&run.seated);
    let mut flow = run.announce(observer)?;
    while flow == Flow::Continue && state.completed < stage {
        flow = run.search(&mut state, observer)?;
    }
    if flow == Flow::Stop {
        return none("stopped before its turn".into());
    }
    let layout = state.layout();
    let lift = group.lift(&run.rigs, &layout);
    let world = group.world(&run.rigs, &run.walls, &layout, &run.seated);
    let second = run.second_start(group, &layout);
    let (mut found, mut last) = (None, 0);
    cem::search(backend, &world, &settings, Stream { seed, stage: stage as u32 }, second, &mut |stats, search| {
        last = stats.iteration;
        if stats.iteration < iteration {
            return Flow::Continue;
        }
        found = Some((search.placed(index), stats.clone()));
        Flow::Stop
    })?;
    let Some((placed, stats)) = found else {
        return none(format!("there is no iteration {iteration}: stage {stage} ended after iteration {last}"));
    };
    let objects = group.objects.clone();
    Ok(Replay { world, objects, lift, placed: placed?, layout, simulation: settings.simulation, stats })
}
