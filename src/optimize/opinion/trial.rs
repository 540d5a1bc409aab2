//! What a layout at rest costs: it is let go in all runs.

use super::tolerances::{CALM, FELL, JAMS, LEADERS, LEADERS_OF_ONE, LEANING, LEVELS_APART, LOST, ON_ANOTHER_LEVEL};
use super::{
    Layout, Opinions,
    runs::{LAPS, Model},
};
use crate::optimize::{
    posture::angle,
    run::Run,
    settle::{flow, settle},
    support,
    tolerances::{JAMMED, NEARLY_FALLEN},
    verify::verify,
};
use crate::scene;
use crate::world::{BackendError, Pose};
use rayon::prelude::*;

/// A layout at rest, and what the runs make of it.
pub(super) struct Trial {
    pub layout: Layout,
    /// Objects that move in any run, or are jammed.
    pub moving: Vec<usize>,
    /// Those, and what leans, has fallen over or has lost its support.
    pub failing: Vec<usize>,
    /// Those that have lost their support.
    pub lost: Vec<usize>,
    /// Those; if there are none, those that lean or have fallen.
    pub astray: Vec<usize>,
    /// True if something has lost its support, has fallen over or is on another level.
    pub misplaced: bool,
    /// How far the objects are from the reconstruction and how much farther they go when let go, on average over the
    /// runs, as the layout term weighs it; and what it costs that they lost their supports, fell or moved.
    pub cost: f64,
    /// What each object contributes to it.
    pub costs: Vec<f64>,
    /// What came of each object in the runs.
    pub released: Vec<Release>,
}

/// What comes of an object that is let go.
#[derive(Clone, Copy, Default)]
pub(super) struct Release {
    /// What it costs that it moves, in all runs.
    moves: f64,
    /// How much farther it goes, on average over the runs.
    farther: f64,
}

impl Opinions<'_> {
    /// Lets layouts at rest go in all runs.
    pub(super) fn judge(&self, layouts: Vec<Layout>) -> Result<Vec<Trial>, BackendError> {
        let released = vec![self.known.clone(); layouts.len()];
        self.let_go(&self.models, layouts, released)
    }

    /// The same for copies of `best`, but what can be neither the cheapest nor have the cheapest of what fails does not
    /// end its runs and does not come back.
    pub(super) fn judge_copies(&self, layouts: Vec<Layout>, best: &Trial) -> Result<Vec<Trial>, BackendError> {
        let [second, third] = LAPS;
        let released = vec![self.known.clone(); layouts.len()];
        let begun = self.let_go(&self.models[..second], layouts, released)?;
        let laps = [&self.models[second..third], &self.models[third..]];
        race(begun, best, &laps, |lap, trials| {
            let (layouts, released) = trials.into_iter().map(|trial| (trial.layout, trial.released)).unzip();
            self.let_go(lap, layouts, released)
        })
    }

    pub(super) fn starts(&self, model: &Model, layout: &Layout) -> Vec<Pose> {
        self.group.starts(&model.rigs, model.walls, layout)
    }

    /// Where the layouts come to rest; what cannot be simulated stays.
    pub(super) fn settled(&self, model: &Model, layouts: &[Layout]) -> Result<Vec<Layout>, BackendError> {
        let Model { rigs, world, simulation, .. } = model;
        let starts: Vec<Pose> = layouts.iter().flat_map(|layout| self.starts(model, layout)).collect();
        let goes_on = |_: &[Pose]| flow(&self.stop);
        let settled = settle(self.run.backend, world, simulation, &self.run.config.settle, &starts, &goes_on)?;
        let bodies = world.bodies.len();
        let mut layouts = layouts.to_vec();
        for (candidate, layout) in layouts.iter_mut().enumerate().filter(|(candidate, _)| settled.usable[*candidate]) {
            let own = candidate * bodies..(candidate + 1) * bodies;
            self.group.adopt(rigs, &starts[own.clone()], &settled.poses[own], layout);
        }
        Ok(layouts)
    }

    /// Lets layouts at rest go in these runs, too, after those of which `released` came.
    fn let_go(
        &self,
        models: &[Model],
        layouts: Vec<Layout>,
        mut released: Vec<Vec<Release>>,
    ) -> Result<Vec<Trial>, BackendError> {
        let run = |model: &Model| {
            let starts: Vec<Pose> = layouts.iter().flat_map(|layout| self.starts(model, layout)).collect();
            verify(self.run.backend, &model.world, &model.simulation, &model.check, &starts, &self.stop)
        };
        let runs = self.beside(layouts.len(), models, run)?;
        for (Model { world, check, price, .. }, run) in models.iter().zip(runs) {
            let motions = run.motions.chunks_exact(world.bodies.len()).zip(&run.usable);
            for ((motions, usable), released) in motions.zip(&mut released) {
                for (body, object) in self.group.moving() {
                    let motion = &motions[body];
                    let stays = *usable && motion.is_within(CALM, check);
                    released[object].moves += if stays { 0.0 } else { *price };
                    released[object].farther += self.weighed(motion.drift, motion.turn) / self.models.len() as f64;
                }
            }
        }
        let begun: Vec<(Layout, Vec<Release>)> = layouts.into_iter().zip(released).collect();
        self.beside(1, &begun, |(layout, released)| self.trial(layout.clone(), released.clone()))
    }

    /// What `work` makes of the items, in their order. As many at a time beside one another as leave the backend room,
    /// if each simulates so many candidates.
    pub(super) fn beside<T: Sync, R: Send>(
        &self,
        candidates: usize,
        items: &[T],
        work: impl Fn(&T) -> Result<R, BackendError> + Sync,
    ) -> Result<Vec<R>, BackendError> {
        let at_once = (self.run.backend.busy_with() / candidates.max(1)).max(1);
        let mut made = Vec::with_capacity(items.len());
        for items in items.chunks(at_once) {
            made.extend(items.par_iter().map(&work).collect::<Result<Vec<R>, _>>()?);
        }
        Ok(made)
    }

    fn trial(&self, layout: Layout, released: Vec<Release>) -> Result<Trial, BackendError> {
        let movable = || (0..layout.len()).filter(|&object| !self.run.scene.is_static(object));
        let mut moves: Vec<f64> = released.iter().map(|released| released.moves).collect();
        let model @ Model { world, simulation, .. } = &self.models[0];
        let depths = self.run.backend.overlaps(world, simulation, &self.starts(model, &layout))?;
        for (pair, _) in world.pairs.iter().zip(&depths).filter(|(_, depth)| **depth > JAMMED) {
            let jammed = self.group.moving().filter(|(body, _)| pair.contains(&(*body as u32)));
            jammed.for_each(|(_, object)| moves[object] += JAMS);
        }
        let turned = |object: usize| angle(&layout[object], &self.run.seated[object]);
        let unsupported = self.unsupported(&layout);
        let lost: Vec<usize> = movable().filter(|&object| unsupported[object]).collect();
        // First things first: a round that sets what is lost back leaves alone what only leans.
        let astray: Vec<usize> = match lost.is_empty() {
            true => movable().filter(|&object| turned(object) > LEANING).collect(),
            false => lost.clone(),
        };
        let moving: Vec<usize> = movable().filter(|&object| moves[object] > 0.0).collect();
        let failing = movable().filter(|&object| moves[object] > 0.0 || astray.contains(&object)).collect();
        let mut costs = vec![0.0; layout.len()];
        let mut misplaced = false;
        for object in movable() {
            let place = self.misplaced(object, &layout[object]) + if unsupported[object] { LOST } else { 0.0 };
            let distance = self.distance(object, &layout[object]);
            costs[object] = distance + released[object].farther + place + moves[object];
            misplaced |= place > 0.0;
        }
        Ok(Trial { moving, failing, lost, astray, misplaced, cost: costs.iter().sum(), costs, released, layout })
    }

    /// True for what has lost its support.
    fn unsupported(&self, layout: &Layout) -> Vec<bool> {
        let Run { scene, rigs, .. } = self.run;
        let bodies: Vec<Pose> = rigs.iter().zip(layout).map(|(rig, pose)| rig.body(pose)).collect();
        support::lost(scene, rigs, &bodies)
    }

    /// What it costs that an object has fallen over or come to another level.
    fn misplaced(&self, object: usize, pose: &scene::Pose) -> f64 {
        let height = |pose: &scene::Pose| self.run.rigs[object].center_of(pose).y;
        let climbed = height(pose) - height(&self.run.seated[object]);
        match self.fell(object, pose) {
            true => FELL,
            false if climbed.abs() > LEVELS_APART => ON_ANOTHER_LEVEL,
            false => 0.0,
        }
    }

    /// True for what has fallen over.
    pub(super) fn fell(&self, object: usize, pose: &scene::Pose) -> bool {
        angle(pose, &self.run.input[object]) > NEARLY_FALLEN
    }

    /// How far an object is from its reconstruction, as the layout term weighs it.
    fn distance(&self, object: usize, pose: &scene::Pose) -> f64 {
        self.between(object, pose, &self.run.seated[object])
    }

    /// How far two poses of an object are from each other, as the layout term weighs it.
    pub(super) fn between(&self, object: usize, a: &scene::Pose, b: &scene::Pose) -> f64 {
        let rig = &self.run.rigs[object];
        self.weighed(rig.center_of(a).distance(rig.center_of(b)), a.rotation.angle_between(b.rotation))
    }

    /// A way (m) and an angle (rad) in one number.
    fn weighed(&self, way: f64, angle: f64) -> f64 {
        f64::from(self.run.config.energy.position) * way + angle
    }
}

/// Ends what is begun where it may matter: first what leads, then, lap by lap, what that and `best` do not beat
/// already. No lap makes a trial cheaper, so what is beaten stays beaten.
fn race<L, E>(
    begun: Vec<Trial>,
    best: &Trial,
    laps: &[L],
    mut run: impl FnMut(&L, Vec<Trial>) -> Result<Vec<Trial>, E>,
) -> Result<Vec<Trial>, E> {
    let ahead = in_the_lead(&begun, &best.failing);
    let (leaders, others): (Vec<_>, Vec<_>) = begun.into_iter().zip(ahead).partition(|(_, ahead)| *ahead);
    let [leaders, mut others] = [leaders, others].map(|trials| trials.into_iter().map(|(trial, _)| trial).collect());
    let done = laps.iter().try_fold(leaders, |trials, lap| run(lap, trials))?;
    for lap in laps {
        others.retain(|trial| !is_beaten(trial, done.iter().chain([best]), &best.failing));
        others = run(lap, others)?;
    }
    Ok(done.into_iter().chain(others).collect())
}

/// Which trials are among the cheapest as a whole, or for one of the objects that fail.
fn in_the_lead(trials: &[Trial], failing: &[usize]) -> Vec<bool> {
    let mut ahead = vec![false; trials.len()];
    let mut lead = |count: usize, cost: &dyn Fn(&Trial) -> f64| {
        let mut order: Vec<usize> = (0..trials.len()).collect();
        order.sort_by(|&a, &b| cost(&trials[a]).total_cmp(&cost(&trials[b])));
        order.iter().take(count).for_each(|&trial| ahead[trial] = true);
    };
    lead(LEADERS, &|trial| trial.cost);
    failing.iter().for_each(|&object| lead(LEADERS_OF_ONE, &|trial| trial.costs[object]));
    ahead
}

/// True for a trial that costs more than another one, and whose every failing object costs more than in another one.
fn is_beaten<'t>(trial: &Trial, others: impl Iterator<Item = &'t Trial> + Clone, failing: &[usize]) -> bool {
    let beaten = |cost: &dyn Fn(&Trial) -> f64| others.clone().any(|other| cost(other) < cost(trial));
    beaten(&|trial| trial.cost) && failing.iter().all(|&object| beaten(&|trial| trial.costs[object]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::convert::Infallible;

    fn trial(costs: Vec<f64>) -> Trial {
        Trial {
            layout: Vec::new(),
            moving: Vec::new(),
            failing: (0..costs.len()).collect(),
            lost: Vec::new(),
            astray: Vec::new(),
            misplaced: false,
            cost: costs.iter().sum(),
            costs,
            released: Vec::new(),
        }
    }

    /// The least total, and the least cost of each object.
    fn least(trials: &[Trial], best: &Trial) -> Vec<f64> {
        let all = || trials.iter().chain([best]);
        let least = |cost: &dyn Fn(&Trial) -> f64| all().map(cost).fold(f64::INFINITY, f64::min);
        let each = (0..best.costs.len()).map(|object| least(&|trial| trial.costs[object]));
        each.chain([least(&|trial| trial.cost)]).collect()
    }

    proptest! {
        /// Costs of trials after the first runs, and what the others add: a multiple of a quarter, so that some are
        /// equal.
        #[test]
        fn a_race_finds_what_all_would_and_ends_no_more_than_all(
            costs in prop::collection::vec(prop::collection::vec([0_u8..20, 0_u8..12, 0_u8..12], 3), 1..64),
            best in prop::collection::vec(0_u8..40, 3),
        ) {
            let quarters = |n: u8| 0.25 * f64::from(n);
            let best = trial(best.into_iter().map(quarters).collect());
            let begun = costs.iter().map(|costs| trial(costs.iter().map(|[first, ..]| quarters(*first)).collect()));
            let begun: Vec<Trial> = begun.enumerate().map(|(i, t)| Trial { moving: vec![i], ..t }).collect();
            let run = |lap: usize, begun: &Trial| {
                let more = costs[begun.moving[0]].iter().map(|costs| quarters(costs[lap]));
                let costs = begun.costs.iter().zip(more).map(|(before, more)| before + more).collect();
                Trial { moving: begun.moving.clone(), ..trial(costs) }
            };
            let all: Vec<Trial> = begun.iter().map(|trial| run(2, &run(1, trial))).collect();
            let lap = |lap: &usize, trials: Vec<Trial>| Ok::<_, Infallible>(trials.iter().map(|trial| run(*lap, trial)).collect());
            let raced = race(begun, &best, &[1, 2], lap).unwrap_or_default();
            prop_assert_eq!(least(&raced, &best), least(&all, &best));
            prop_assert!(raced.len() <= all.len());
        }
    }

    #[test]
    fn what_is_beaten_does_not_go_on() {
        // One good for each of two objects, and many that are worse in everything.
        let best = trial(vec![9.0, 9.0]);
        let begun: Vec<Trial> = (0..40).map(|i| trial(vec![f64::from(i), f64::from(i)])).collect();
        let mut run = Vec::new();
        let raced = race(begun, &best, &[(), ()], |(), trials| {
            run.push(trials.len());
            Ok::<_, Infallible>(trials)
        });
        assert_eq!((raced.unwrap_or_default().len(), run), (LEADERS, vec![LEADERS, LEADERS, 0, 0]));
    }
}
