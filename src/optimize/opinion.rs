//! A second opinion: what stands only on the facets of one decomposition, or on a point, does not stand in another
//! engine.
//!
//! The settled layout is let go with all decompositions of its meshes, level and on slippery slopes that fall four ways. On
//! these, and with V-HACD's parts, objects without a stated mass weigh as much as their parts are large: the mass of a
//! category is a guess, and a lamp that only a heavy bowl holds falls elsewhere. What moves in any of these runs is searched
//! once more, with a wider spread, and so is what leans or has lost its support. Copies of the layout have those objects
//! shifted and turned at random, about where they are and about where they come to rest in one of the runs, or where there is
//! room for them near the place at which they were set onto it. Each copy settles and is let go in the same way, and so are
//! mixtures in which every object is as in the copy in which it costs least. What costs is what has lost its support, moves or
//! has fallen over, and the way from the reconstruction. The cheapest goes on.

use super::{
    Event, Observer,
    finish::{FALLEN, angle},
    groups::Group,
    projection,
    rig::Rig,
    run::Run,
    settle::settle,
    support,
    verify::verify,
};
use crate::cpu::sample::sample;
use crate::scene;
use crate::world::{BackendError, BodyDef, Flow, Pose, SimSettings, Stream, World};
use glam::{DQuat, Vec2, Vec3};

/// Copies that a round looks at.
const COPIES: u32 = 64;

/// Most rounds, and how many in a row that find nothing better are the last.
const ROUNDS: u32 = 6;
const PATIENCE: u32 = 2;

/// Copies are let go until they are at rest, which takes half the time. Of 1000 objects that move two only do so after they
/// have been slow for half a second, so these copies, the cheapest, are let go to the end before one goes on.
const FINALISTS: usize = 5;

/// How steep the slopes are, rad (1.1°): other engines push what touches apart by tenths of a millimetre, and what stands on
/// less than that falls there.
const SLOPE: f32 = 0.02;

/// Share of the friction that is left on them: what leans with all of it creeps in engines whose friction gives way.
const SLIPPERY: f32 = 0.7;

/// Standard deviation of the shift of an object that fails: m, horizontal and vertical; and of its turn about each axis, rad.
/// The last copies have all of it, the first ones next to nothing.
const SPREAD: [f32; 6] = [0.01, 0.0, 0.01, 0.3, 0.3, 0.3];

/// What an object costs that has lost its support, that has fallen over, and that has come to another level: rad, or so many
/// times 17 cm.
const LOST: f64 = 10.0;
const FELL: f64 = 5.0;
const ON_ANOTHER_LEVEL: f64 = 8.0;

/// What is so much higher or lower than it was set onto its support is on another level, m: what other parts push off the
/// board of a shelf finds rest on the next one.
const LEVELS_APART: f64 = 0.1;

/// And one that moves, with the parts that the result names, and with others: those may be at fault themselves.
const MOVES: f64 = 3.0;
const MOVES_OTHERWISE: f64 = 2.0;

/// And one that moves with others on one of the slopes: all eight of these runs count as much as one of those.
const MOVES_OTHERWISE_ON_SLOPE: f64 = 0.25;

/// What moves by more than this share of what the check allows counts as moving: other engines differ by as much.
const CALM: f64 = 0.5;

/// What is deeper than this in another at rest is jammed, m: parts of meshes that only touch overlap by less. And its cost.
const JAMMED: f32 = 2e-3;
const JAMS: f64 = 3.0;

/// Less than this is no gain, in the same unit.
const WORTH: f64 = 0.05;

/// An object turned by more than this from how it was set onto its support leans on something, or has fallen, rad (15°).
const LEANING: f64 = 0.26;

/// Poses of all objects.
type Layout = Vec<scene::Pose>;

/// A layout at rest, and what the runs make of it.
struct Trial {
    layout: Layout,
    /// Objects that move in any run, or are jammed.
    moving: Vec<usize>,
    /// Those, and what leans, has fallen over or has lost its support.
    failing: Vec<usize>,
    /// Those that have lost their support.
    lost: Vec<usize>,
    /// Those; if there are none, those that lean or have fallen.
    astray: Vec<usize>,
    /// How far the objects are from the reconstruction and how much farther they go when let go, on average over the runs, as
    /// the layout term weighs it; and what it costs that they lost their supports, fell or moved.
    cost: f64,
    /// What each object contributes to it.
    costs: Vec<f64>,
}

/// What comes of an object that is let go.
#[derive(Clone, Copy, Default)]
struct Release {
    /// What it costs that it moves, in all runs.
    moves: f64,
    /// How much farther it goes, on average over the runs.
    farther: f64,
}

/// All objects with the parts, masses and friction of a run, and its walls.
struct Model<'a> {
    rigs: Vec<Rig>,
    walls: &'a [BodyDef],
    world: World,
    simulation: SimSettings,
    /// What an object costs that moves.
    price: f64,
}

/// The movable objects as they are in each run: with the parts that the result names, with their alternative ones, and with
/// either on slopes.
pub(super) struct Opinions<'a> {
    run: &'a Run<'a>,
    group: &'a Group,
    models: Vec<Model<'a>>,
    /// How copies settle: with the parts that the result names, and all walls.
    settling: Model<'a>,
}

impl<'a> Opinions<'a> {
    /// For the objects of `group`, on slopes as they lie in `layout`.
    pub fn new(run: &'a Run<'a>, group: &'a Group, layout: &[scene::Pose]) -> Self {
        let as_it_is = run.config.fine();
        let slippery = SimSettings { friction: SLIPPERY * as_it_is.friction, ..as_it_is.clone() };
        let between = |walls: &'a [BodyDef], rigs: Vec<Rig>, simulation: &SimSettings, price: f64| Model {
            world: group.world(&rigs, walls, layout, &run.seated),
            rigs,
            walls,
            simulation: simulation.clone(),
            price,
        };
        let model = |rigs, simulation: &SimSettings, price| between(&run.leant_on, rigs, simulation, price);
        let slopes = [Vec2::X, Vec2::NEG_X, Vec2::Y, Vec2::NEG_Y].map(|way| SLOPE * way);
        let on = |rigs: &[Rig], slope| rigs.iter().zip(layout).map(|(rig, pose)| rig.on_slope(pose, slope)).collect();
        let mut models = vec![model(run.rigs.clone(), &as_it_is, MOVES)];
        models.extend(run.alternatives.iter().map(|rigs| model(rigs.clone(), &as_it_is, MOVES_OTHERWISE)));
        let stated = run.rigs.iter().zip(&run.scene.objects).map(|(rig, object)| rig.with_stated_mass(object.mass));
        let stated: Vec<Rig> = stated.collect();
        models.extend(slopes.map(|slope| model(on(&stated, slope), &slippery, MOVES)));
        let otherwise = run.alternatives.iter().flat_map(|rigs| slopes.map(|slope| on(rigs, slope)));
        models.extend(otherwise.map(|rigs| model(rigs, &slippery, MOVES_OTHERWISE_ON_SLOPE)));
        let settling = between(&run.walls, run.rigs.clone(), &as_it_is, MOVES);
        Self { run, group, models, settling }
    }

    /// Searches what does not stand in all runs once more. The layout stays as it is unless a better one is found.
    pub fn improve(&self, layout: &mut Layout, observer: &mut dyn Observer) -> Result<(), BackendError> {
        let mut best = self.judge(vec![layout.clone()], None)?.swap_remove(0);
        // Other engines' parts reach farther sideways. What then moves is searched like everything that does.
        if let Some(spread) = projection::spread(self.run.scene, &self.run.rigs, layout, self.group) {
            let roomy = self.judge(self.settled(&self.settling, &[spread])?, None)?.swap_remove(0);
            if roomy.lost.len() <= best.lost.len() {
                best = roomy;
            }
        }
        let rest_speed = self.run.config.settle.rest_speed;
        let mut idle = 0;
        for round in 0..ROUNDS {
            if best.failing.is_empty()
                || idle == PATIENCE
                || observer.event(Event::Reconsidering { failing: best.failing.len() }) == Flow::Stop
            {
                break;
            }
            let copies = self.copies(&best, round)?;
            let look = |layouts: &[Layout]| self.judge(self.settled(&self.settling, layouts)?, Some(rest_speed));
            let mut trials = look(&copies)?;
            // What stands here and there in different trials may stand together; what does not may still stand one at a time.
            let one_by_one = best.failing.chunks(1).map(|object| mixed(&best, &trials, object));
            let mixtures: Vec<Layout> = one_by_one.chain([mixed(&best, &trials, &best.failing)]).collect();
            trials.extend(look(&mixtures)?);
            let again = mixed(&best, &trials, &best.failing);
            trials.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            let cheapest = trials.into_iter().take(FINALISTS).map(|trial| trial.layout);
            let finalists: Vec<Layout> =
                cheapest.chain(self.settled(&self.settling, std::slice::from_ref(&again))?).collect();
            let finalists = self.judge(finalists, None)?;
            idle += 1;
            if let Some(cheapest) = finalists.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost))
                && cheapest.cost + WORTH < best.cost
            {
                (best, idle) = (cheapest, 0);
            }
        }
        *layout = best.layout;
        Ok(())
    }

    /// Whether each object of a layout stays where it is with both of its other decompositions.
    pub fn second(&self, layout: &Layout) -> Result<Vec<bool>, BackendError> {
        let settings = &self.run.config.verify;
        let mut stays = vec![true; layout.len()];
        for model @ Model { world, simulation, .. } in self.models.iter().skip(1).take(2) {
            let checked = verify(self.run.backend, world, simulation, settings, None, &self.starts(model, layout))?;
            if checked.usable[0] {
                self.group
                    .moving()
                    .for_each(|(body, object)| stays[object] &= checked.motions[body].is_still(settings));
            }
        }
        Ok(stays)
    }

    /// Copies of a layout in which what moves is shifted and turned, in every other one from where it comes to rest in one of
    /// the runs. What has lost its support is set onto it again in all, what leans or has fallen in half of them: it may do so
    /// for good, and take others along.
    fn copies(&self, trial: &Trial, round: u32) -> Result<Vec<Layout>, BackendError> {
        let settled = |model| Ok(self.settled(model, std::slice::from_ref(&trial.layout))?.swap_remove(0));
        let elsewhere: Vec<Layout> = self.models[1..].iter().map(settled).collect::<Result<_, BackendError>>()?;
        let places: Vec<Layout> =
            trial.astray.iter().map(|&object| self.run.free_places(object, &trial.layout)).collect();
        let copy = |copy| {
            let mut layout = trial.layout.clone();
            let mut objects = trial.moving.clone();
            if copy % 2 == 1 {
                let elsewhere = &elsewhere[copy as usize / 2 % elsewhere.len()];
                objects.iter().for_each(|&object| layout[object] = elsewhere[object]);
            } else if copy % 4 == 2 {
                // As they were reconstructed, where they are.
                for &object in &objects {
                    layout[object] = self.run.rigs[object].turned(&layout[object], self.run.input[object].rotation);
                }
            }
            if !trial.lost.is_empty() || trial.moving.is_empty() || copy % 4 < 2 {
                objects.clone_from(&trial.failing);
                for (&object, places) in trial.astray.iter().zip(&places) {
                    if let Some(place) = places.get(copy as usize * places.len() / COPIES as usize) {
                        layout[object] = *place;
                        // It was set down there in a pose of rest: any tilt, and a pear rolls off again.
                        objects.retain(|&other| other != object);
                    }
                }
            }
            self.perturb(&mut layout, &objects, round, copy);
            layout
        };
        Ok((0..COPIES).map(copy).collect())
    }

    /// Shifts and turns the objects about their centres of mass; the first two copies stay as they are.
    fn perturb(&self, layout: &mut Layout, objects: &[usize], round: u32, copy: u32) {
        let wide = (copy / 2) as f32 / (COPIES / 2 - 1) as f32;
        let std = SPREAD.map(|std| wide * std).repeat(objects.len());
        let mut noise = vec![0.0; std.len()];
        let stream = Stream { seed: self.run.seed, stage: self.run.groups.len() as u32 };
        sample(&vec![0.0; std.len()], &std, stream, round, copy, &mut noise);
        for (&object, noise) in objects.iter().zip(noise.chunks_exact(SPREAD.len())) {
            let turn = DQuat::from_scaled_axis(Vec3::from_slice(&noise[3..]).as_dvec3());
            layout[object] = self.run.rigs[object].turned(&layout[object], turn * layout[object].rotation);
            layout[object].translation += Vec3::from_slice(noise).as_dvec3();
        }
    }

    fn starts(&self, model: &Model, layout: &Layout) -> Vec<Pose> {
        self.group.starts(&model.rigs, model.walls, layout)
    }

    /// Where the layouts come to rest; what cannot be simulated stays.
    fn settled(&self, model: &Model, layouts: &[Layout]) -> Result<Vec<Layout>, BackendError> {
        let Model { rigs, world, simulation, .. } = model;
        let starts: Vec<Pose> = layouts.iter().flat_map(|layout| self.starts(model, layout)).collect();
        let settled = settle(self.run.backend, world, simulation, &self.run.config.settle, &starts)?;
        let bodies = world.bodies.len();
        let mut layouts = layouts.to_vec();
        for (candidate, layout) in layouts.iter_mut().enumerate().filter(|(candidate, _)| settled.usable[*candidate]) {
            let own = candidate * bodies..(candidate + 1) * bodies;
            self.group.adopt(rigs, &starts[own.clone()], &settled.poses[own], layout);
        }
        Ok(layouts)
    }

    /// Lets layouts at rest go in all runs, to the end or, given a speed of rest, until they are at rest.
    fn judge(&self, layouts: Vec<Layout>, rest_speed: Option<f32>) -> Result<Vec<Trial>, BackendError> {
        let Run { backend, seated, .. } = self.run;
        let mut released = self.let_go(&layouts, rest_speed)?;
        let model @ Model { world, simulation, .. } = &self.models[0];
        for (layout, released) in layouts.iter().zip(&mut released) {
            let depths = backend.overlaps(world, simulation, &self.starts(model, layout))?;
            for (pair, _) in world.pairs.iter().zip(&depths).filter(|(_, depth)| **depth > JAMMED) {
                let movable = self.group.moving().filter(|(body, _)| pair.contains(&(*body as u32)));
                movable.for_each(|(_, object)| released[object].moves += JAMS);
            }
        }
        let trial = |(layout, released): (Layout, Vec<Release>)| {
            let turned = |object: usize| angle(&layout[object], &seated[object]);
            let movable = || self.group.moving().map(|(_, object)| object);
            let unsupported = self.unsupported(&layout);
            let lost: Vec<usize> = movable().filter(|&object| unsupported[object]).collect();
            // First things first: a round that sets what is lost back leaves alone what only leans.
            let astray = match lost.is_empty() {
                true => movable().filter(|&object| turned(object) > LEANING).collect(),
                false => lost.clone(),
            };
            let moving: Vec<usize> = movable().filter(|&object| released[object].moves > 0.0).collect();
            let failing =
                movable().filter(|&object| released[object].moves > 0.0 || astray.contains(&object)).collect();
            let price = |object: usize| {
                self.distance(object, &layout[object])
                    + released[object].farther
                    + if unsupported[object] { LOST } else { 0.0 }
                    + self.misplaced(object, &layout[object])
                    + released[object].moves
            };
            let mut costs = vec![0.0; layout.len()];
            movable().for_each(|object| costs[object] = price(object));
            Trial { moving, failing, lost, astray, cost: costs.iter().sum(), costs, layout }
        };
        Ok(layouts.into_iter().zip(released).map(trial).collect())
    }

    /// What comes of every object of every layout in all runs.
    fn let_go(&self, layouts: &[Layout], rest_speed: Option<f32>) -> Result<Vec<Vec<Release>>, BackendError> {
        let Run { backend, config, seated, .. } = self.run;
        let mut released = vec![vec![Release::default(); seated.len()]; layouts.len()];
        for model @ Model { world, simulation, price, .. } in &self.models {
            let starts: Vec<Pose> = layouts.iter().flat_map(|layout| self.starts(model, layout)).collect();
            let checked = verify(*backend, world, simulation, &config.verify, rest_speed, &starts)?;
            let motions = checked.motions.chunks_exact(world.bodies.len()).zip(&checked.usable);
            for ((motions, usable), released) in motions.zip(&mut released) {
                for (body, object) in self.group.moving() {
                    let motion = &motions[body];
                    let stays = *usable && motion.is_within(CALM, &config.verify);
                    released[object].moves += if stays { 0.0 } else { *price };
                    released[object].farther += self.weighed(motion.drift, motion.turn) / self.models.len() as f64;
                }
            }
        }
        Ok(released)
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
        match angle(pose, &self.run.input[object]) > FALLEN {
            true => FELL,
            false if climbed.abs() > LEVELS_APART => ON_ANOTHER_LEVEL,
            false => 0.0,
        }
    }

    /// How far an object is from its reconstruction, as the layout term weighs it.
    fn distance(&self, object: usize, pose: &scene::Pose) -> f64 {
        let (rig, seated) = (&self.run.rigs[object], &self.run.seated[object]);
        let way = rig.center_of(pose).distance(rig.center_of(seated));
        self.weighed(way, pose.rotation.angle_between(seated.rotation))
    }

    /// A way (m) and an angle (rad) in one number.
    fn weighed(&self, way: f64, angle: f64) -> f64 {
        f64::from(self.run.config.energy.position) * way + angle
    }
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

    #[test]
    fn a_mixture_takes_the_cheapest_of_what_fails() {
        let trial = |x: f64, costs: [f64; 3], failing: &[usize]| Trial {
            moving: Vec::new(),
            failing: failing.to_vec(),
            lost: Vec::new(),
            astray: Vec::new(),
            cost: costs.iter().sum(),
            costs: costs.to_vec(),
            layout: vec![scene::Pose { translation: DVec3::X * x, ..scene::Pose::IDENTITY }; 3],
        };
        let best = trial(0.0, [5.0, 2.0, 3.0], &[0, 1]);
        let trials = [trial(1.0, [4.0, 3.0, 0.0], &[]), trial(2.0, [1.0, 9.0, 0.0], &[0, 1])];
        let mixed = mixed(&best, &trials, &best.failing);
        let from: Vec<f64> = mixed.iter().map(|pose| pose.translation.x).collect();
        assert_eq!(from, [2.0, 0.0, 0.0], "nothing better for the second, and the third does not fail");
    }
}
