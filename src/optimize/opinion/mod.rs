//! A second opinion: what stands only on the facets of one decomposition, or on a point, does not stand in another
//! engine.
//!
//! The settled layout is let go with all decompositions of its meshes, level and on slippery slopes that fall four
//! ways. On slopes with the parts of the search, and everywhere with V-HACD's, objects without a stated mass
//! weigh as much as their parts are large: the mass of a category is a guess, and a lamp that only a heavy bowl holds
//! falls elsewhere. What moves in any of these runs is searched once more, with a wider spread, and so is what leans or
//! has lost its support. Copies of the layout have those objects shifted and turned at random, about where they are and
//! about where they come to rest in one of the runs, or where there is room for them near the place at which they were
//! set onto it. Each copy settles and is let go in the same way, and so are mixtures in which every object is as in the
//! copy in which it costs least. What costs is what has lost its support, moves or has fallen over, and the way from
//! the reconstruction. Copies and mixtures are looked at with what does not concern them held; the best of them are
//! looked at as a whole, and the cheapest goes on.

mod anew;
mod copies;
mod focus;
mod runs;
mod tolerances;
mod trial;

use super::settle::{GO_ON, flow};
use super::{Checkpoint, Event, Observer, checkpoint::Progress, groups::Group, projection, run::Run, verify::verify};
use crate::scene;
use crate::world::{BackendError, Flow};
use runs::{LEVEL_OTHERWISE, Model};
use std::sync::{Arc, atomic::AtomicBool};
use tolerances::{FINALISTS, PATIENCE, PATIENCE_WHILE_MISPLACED, ROUNDS, TIMES_ANEW, WORTH};
use trial::{Release, Trial};

/// Poses of all objects.
type Layout = Vec<scene::Pose>;

/// The movable objects as they are in each run: with the parts of the search, with their alternative ones, and
/// with either on slopes.
pub(super) struct Opinions<'a> {
    run: &'a Run<'a>,
    /// Which objects move.
    group: Group,
    models: Vec<Model<'a>>,
    /// Objects whose other parts fill what is in them.
    pub filled: Vec<usize>,
    /// How copies settle: with the parts of the search, and all walls.
    settling: Model<'a>,
    /// What came of the objects that are held, in runs in which they were not.
    known: Vec<Release>,
    /// True when the run is to end.
    stop: Arc<AtomicBool>,
}

impl<'a> Opinions<'a> {
    /// For the objects of `group`, on slopes as they lie in `layout`.
    pub fn new(
        run: &'a Run<'a>,
        group: &'a Group,
        layout: &Layout,
        stop: Arc<AtomicBool>,
    ) -> Result<Self, BackendError> {
        let ((models, filled), settling) = (Model::runs(run, group, layout)?, Model::settling(run, group, layout));
        Ok(Self {
            run,
            group: group.clone(),
            models,
            filled,
            settling,
            known: vec![Release::default(); layout.len()],
            stop,
        })
    }

    /// Searches what does not stand in all runs once more, from where `state` has it. The layout stays as it is unless
    /// a better one is found. `Stop` if the observer ended it early.
    pub fn improve(
        &self,
        layout: &mut Layout,
        state: &mut Checkpoint,
        observer: &mut dyn Observer,
    ) -> Result<Flow, BackendError> {
        let (mut progress, mut best, mut nothing_to_set_anew) = match state.opinion() {
            Some((progress, layout)) => (progress, self.judge(vec![layout])?.swap_remove(0), false),
            None => {
                let (found, nothing_to_set_anew) = self.start(layout, observer)?;
                (Progress::default(), found, nothing_to_set_anew)
            }
        };
        let mut flow = self.flow();
        if flow == Flow::Stop {
            state.opinion().into_iter().for_each(|(_, known)| *layout = known);
            return Ok(flow);
        }
        while progress.rounds < ROUNDS && progress.idle < patience(&best) && !best.failing.is_empty() {
            state.set_opinion(progress, &best.layout);
            let (failing, round) = (best.failing.len(), [progress.rounds + 1, ROUNDS]);
            flow = observer.event(Event::Reconsidering { failing, round, checkpoint: state });
            if flow == Flow::Stop {
                break;
            }
            if progress.idle == 1 && !nothing_to_set_anew {
                let cost = best.cost;
                (best, nothing_to_set_anew) = self.each_anew(best, 1, observer)?;
                flow = self.flow();
                if flow == Flow::Stop {
                    break;
                }
                if best.cost < cost {
                    progress = Progress { rounds: progress.rounds + 1, idle: 0 };
                    continue;
                }
            }
            let finalists =
                finalists(self.focused(&best, &best.failing).round(&best, progress.rounds)?, &best, FINALISTS);
            let trials = self.judge_copies(self.settled(&self.settling, &finalists)?, &best)?;
            flow = self.flow();
            if flow == Flow::Stop {
                break;
            }
            progress = Progress { rounds: progress.rounds + 1, idle: progress.idle + 1 };
            if let Some(cheapest) = cheaper(trials, &best) {
                (best, progress.idle, nothing_to_set_anew) = (cheapest, 0, false);
            }
        }
        if flow == Flow::Continue {
            best = self.far_anew(best, observer)?;
            flow = self.flow();
        }
        *layout = best.layout;
        Ok(flow)
    }

    /// Whether to go on: if not, what was simulated last means nothing.
    fn flow(&self) -> Flow {
        flow(&self.stop)
    }

    /// What the rounds start from: the layout with some room; or as everything comes to rest where it was set onto its
    /// support before the search, which may have pushed something off that stood there; or with what rolls or has
    /// fallen set down anew; or a mixture of these. What was thrown far is then brought back, and each of what rolls or
    /// has fallen is set down anew, some times at most. And whether nothing more would come of that.
    fn start(&self, layout: &Layout, observer: &mut dyn Observer) -> Result<(Trial, bool), BackendError> {
        let found = self.roomy(layout)?;

        if found.failing.is_empty() {
            return Ok((self.brought_back(found)?, true));
        }
        let rest = |layout: &Layout| self.judge(self.settled(&self.settling, std::slice::from_ref(layout))?);
        let mut others = rest(&self.run.seated)?;
        if let Some(anew) = self.all_anew(&found)? {
            others.extend(rest(&anew)?);
        }
        others.extend(rest(&mixed(&found, &others, &found.failing))?);
        let best = self.brought_back(cheaper(others, &found).unwrap_or(found))?;
        self.each_anew(best, TIMES_ANEW, observer)
    }

    /// The same with what was thrown far nearer to its place, one thing after the other, if that costs less and no more
    /// fails.
    fn brought_back(&self, found: Trial) -> Result<Trial, BackendError> {
        let mut best = found;
        for object in 0..best.layout.len() {
            if let Some(nearer) = self.run.nearer(object, &best.layout) {
                let nearer = self.settled(&self.settling, &[nearer])?.swap_remove(0);
                let back = cheaper(vec![self.roomy(&nearer)?], &best);
                best = back.filter(|back| back.failing.len() <= best.failing.len()).unwrap_or(best);
            }
        }
        Ok(best)
    }

    /// The layout, or the same with room between what stands side by side if that costs no support: other engines'
    /// parts reach farther sideways. What then moves is searched like everything that does.
    fn roomy(&self, layout: &Layout) -> Result<Trial, BackendError> {
        let here = self.judge(vec![layout.clone()])?.swap_remove(0);
        let Some(spread) = projection::spread(self.run.scene, &self.run.rigs, layout, &self.group) else {
            return Ok(here);
        };
        let roomy = self.judge(self.settled(&self.settling, &[spread])?)?.swap_remove(0);
        Ok(if roomy.lost.len() <= here.lost.len() { roomy } else { here })
    }

    /// Copies and mixtures of the best layout, judged.
    fn round(&self, best: &Trial, round: u32) -> Result<Vec<Trial>, BackendError> {
        let copies = self.copies(best, round)?;
        let mut trials = self.judge_copies(self.settled(&self.settling, &copies)?, best)?;
        // What stands here and there in different trials may stand together; what does not may still stand one at a
        // time.
        let one_by_one = best.failing.chunks(1).map(|object| mixed(best, &trials, object));
        let mixtures: Vec<Layout> = one_by_one.chain([mixed(best, &trials, &best.failing)]).collect();
        trials.extend(self.judge(self.settled(&self.settling, &mixtures)?)?);
        let again = [mixed(best, &trials, &best.failing)];
        trials.extend(self.judge(self.settled(&self.settling, &again)?)?);
        Ok(trials)
    }

    /// Whether each object of a layout stays where it is with both of its other decompositions.
    pub fn second(&self, layout: &Layout) -> Result<Vec<bool>, BackendError> {
        let settings = &self.run.config.verify;
        let mut stays = vec![true; layout.len()];
        for model @ Model { world, simulation, .. } in LEVEL_OTHERWISE.map(|run| &self.models[run]) {
            let checked = verify(self.run.backend, world, simulation, settings, &self.starts(model, layout), &GO_ON)?;
            if checked.usable[0] {
                self.group
                    .moving()
                    .for_each(|(body, object)| stays[object] &= checked.motions[body].is_still(settings));
            }
        }
        Ok(stays)
    }
}

/// So many rounds may find nothing better than this one.
fn patience(best: &Trial) -> u32 {
    if best.misplaced { PATIENCE_WHILE_MISPLACED } else { PATIENCE }
}

/// The cheapest of the trials, if it costs less than `best`.
fn cheaper(trials: Vec<Trial>, best: &Trial) -> Option<Trial> {
    let cheapest = trials.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
    cheapest.filter(|trial| trial.cost + WORTH < best.cost)
}

/// The layouts of at most so many of the cheapest trials that cost less than `best`.
fn finalists(mut trials: Vec<Trial>, best: &Trial, most: usize) -> Vec<Layout> {
    trials.retain(|trial| trial.cost + WORTH < best.cost);
    trials.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    trials.into_iter().take(most).map(|trial| trial.layout).collect()
}

/// The best layout with each of these objects as it is in the trial in which it costs least.
fn mixed(best: &Trial, trials: &[Trial], objects: &[usize]) -> Layout {
    let mut layout = best.layout.clone();
    for &object in objects {
        let cheapest = trials.iter().chain([best]).min_by(|a, b| a.costs[object].total_cmp(&b.costs[object]));
        layout[object] = cheapest.map_or(layout[object], |trial| trial.layout[object]);
    }
    layout
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn trial(x: f64, costs: [f64; 3], failing: &[usize]) -> Trial {
        Trial {
            moving: Vec::new(),
            failing: failing.to_vec(),
            lost: Vec::new(),
            astray: Vec::new(),
            misplaced: false,
            cost: costs.iter().sum(),
            costs: costs.to_vec(),
            released: Vec::new(),
            layout: vec![scene::Pose { translation: DVec3::X * x, ..scene::Pose::IDENTITY }; 3],
        }
    }

    #[test]
    fn what_is_misplaced_is_worth_more_rounds() {
        let [placed, misplaced] = [false, true].map(|misplaced| Trial { misplaced, ..trial(0.0, [5.0; 3], &[0]) });
        assert!(patience(&misplaced) > patience(&placed));
    }

    #[test]
    fn a_mixture_takes_the_cheapest_of_what_fails() {
        let best = trial(0.0, [5.0, 2.0, 3.0], &[0, 1]);
        let trials = [trial(1.0, [4.0, 3.0, 0.0], &[]), trial(2.0, [1.0, 9.0, 0.0], &[0, 1])];
        let mixed = mixed(&best, &trials, &best.failing);
        let from: Vec<f64> = mixed.iter().map(|pose| pose.translation.x).collect();
        assert_eq!(from, [2.0, 0.0, 0.0], "nothing better for the second, and the third does not fail");
    }
}
