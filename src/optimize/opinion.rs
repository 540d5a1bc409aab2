//! A second opinion: what stands only on the facets of one decomposition, or on a point, does not stand in another
//! engine.
//!
//! The settled layout is let go with both decompositions of its meshes, and on slippery slopes that fall four ways. What
//! moves in any of these runs is searched once more, with a wider spread, and so is what leans or has lost its support.
//! Copies of the layout have those objects shifted and turned at random, about where they are and about where they come
//! to rest in one of the runs, or where there is room for them near the place at which they were set onto it. Each copy
//! settles and is let go in the same way, and so is a mixture in which every object is as in a copy that it stands in.
//! The cheapest goes on: what counts is what has lost its support, moves or has fallen over, and the way from the
//! reconstruction.

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
use crate::world::{BackendError, Flow, Pose, SimSettings, Stream, World};
use glam::{DQuat, Vec2, Vec3};

/// Copies that a round looks at.
const COPIES: u32 = 32;

/// Most rounds, and how many in a row that find nothing better are the last.
const ROUNDS: u32 = 8;
const PATIENCE: u32 = 2;

/// How steep the slopes are, rad (1.1°): other engines push what touches apart by tenths of a millimetre, and what stands on
/// less than that falls there.
const SLOPE: f32 = 0.02;

/// Share of the friction that is left on them: what leans with all of it creeps in engines whose friction gives way.
const SLIPPERY: f32 = 0.7;

/// Standard deviation of the shift of an object that fails: m, horizontal and vertical; and of its turn about each axis, rad.
/// The last copies have all of it, the first ones next to nothing.
const SPREAD: [f32; 6] = [0.01, 0.0, 0.01, 0.3, 0.3, 0.3];

/// What an object costs that has lost its support, and that has fallen over: rad, or so many times 17 cm.
const LOST: f64 = 10.0;
const FELL: f64 = 2.0;

/// And one that moves, with the parts that the result names, and with others: those may be at fault themselves.
const MOVES: f64 = 3.0;
const MOVES_OTHERWISE: f64 = 2.0;

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
}

/// All objects with the parts, masses and friction of a run.
struct Model {
    rigs: Vec<Rig>,
    world: World,
    simulation: SimSettings,
    /// What an object costs that moves.
    price: f64,
}

/// The movable objects as they are in each run: with the parts that the result names, with their alternative ones, and with the
/// former on slopes.
pub(super) struct Opinions<'a> {
    run: &'a Run<'a>,
    group: &'a Group,
    models: Vec<Model>,
}

impl<'a> Opinions<'a> {
    /// For the objects of `group`, on slopes as they lie in `layout`.
    pub fn new(run: &'a Run<'a>, group: &'a Group, layout: &[scene::Pose]) -> Self {
        let as_it_is = run.config.fine();
        let slippery = SimSettings { friction: SLIPPERY * as_it_is.friction, ..as_it_is.clone() };
        let model = |rigs: Vec<Rig>, simulation: &SimSettings, price: f64| Model {
            world: group.world(&rigs, &run.walls, layout, &run.seated),
            rigs,
            simulation: simulation.clone(),
            price,
        };
        let alternative =
            |number: usize| run.shapes.iter().map(|s| Rig::alternative(&s.alternatives[number])).collect();
        let slopes = [Vec2::X, Vec2::NEG_X, Vec2::Y, Vec2::NEG_Y].map(|way| SLOPE * way);
        let on = |slope| run.rigs.iter().zip(layout).map(|(rig, pose)| rig.on_slope(pose, slope)).collect();
        let mut models = vec![model(run.rigs.clone(), &as_it_is, MOVES)];
        models.extend([0, 1].map(|number| model(alternative(number), &as_it_is, MOVES_OTHERWISE)));
        models.extend(slopes.map(|slope| model(on(slope), &slippery, MOVES)));
        Self { run, group, models }
    }

    /// Searches what does not stand in all runs once more. The layout stays as it is unless a better one is found.
    pub fn improve(&self, layout: &mut Layout, observer: &mut dyn Observer) -> Result<(), BackendError> {
        let mut best = self.judge(vec![layout.clone()])?.swap_remove(0);
        // Other engines' parts reach farther sideways.
        if let Some(spread) = projection::spread(self.run.scene, &self.run.rigs, layout, self.group) {
            let roomy = self.judge(self.settled(0, &[spread])?)?.swap_remove(0);
            if roomy.failing.len() <= best.failing.len() {
                best = roomy;
            }
        }
        let mut idle = 0;
        for round in 0..ROUNDS {
            if best.failing.is_empty()
                || idle == PATIENCE
                || observer.event(Event::Reconsidering { failing: best.failing.len() }) == Flow::Stop
            {
                break;
            }
            let copies = self.copies(&best, round)?;
            let mut trials = self.judge(self.settled(0, &copies)?)?;
            let mixed = [mixed(&best, &trials, |object, pose| self.distance(object, pose))];
            trials.extend(self.judge(self.settled(0, &mixed)?)?);
            let cheapest = trials.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
            match cheapest.filter(|trial| trial.cost + WORTH < best.cost) {
                Some(better) => (best, idle) = (better, 0),
                None => idle += 1,
            }
        }
        *layout = best.layout;
        Ok(())
    }

    /// Whether each object of a layout stays where it is with both of its other decompositions.
    pub fn second(&self, layout: &Layout) -> Result<Vec<bool>, BackendError> {
        let settings = &self.run.config.verify;
        let mut stays = vec![true; layout.len()];
        for (number, Model { world, simulation, .. }) in self.models.iter().enumerate().skip(1).take(2) {
            let checked = verify(self.run.backend, world, simulation, settings, &self.starts(number, layout))?;
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
        let elsewhere: Vec<Layout> = (1..self.models.len()).map(settled).collect::<Result<_, BackendError>>()?;
        let places: Vec<Layout> =
            trial.astray.iter().map(|&object| self.run.free_places(object, &trial.layout)).collect();
        let copy = |copy| {
            let mut layout = trial.layout.clone();
            let mut objects = trial.moving.clone();
            if copy % 2 == 1 {
                let elsewhere = &elsewhere[copy as usize / 2 % elsewhere.len()];
                objects.iter().for_each(|&object| layout[object] = elsewhere[object]);
            }
            if !trial.lost.is_empty() || trial.moving.is_empty() || copy % 4 < 2 {
                for (&object, places) in trial.astray.iter().zip(&places) {
                    let place = places.get(copy as usize * places.len() / COPIES as usize);
                    layout[object] = *place.unwrap_or(&layout[object]);
                }
                objects.clone_from(&trial.failing);
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
            let rig = &self.run.rigs[object];
            let center = rig.center_of(&layout[object]);
            let turn = DQuat::from_scaled_axis(Vec3::from_slice(&noise[3..]).as_dvec3());
            let turned = scene::Pose { rotation: (turn * layout[object].rotation).normalize(), ..layout[object] };
            let shift = center + Vec3::from_slice(noise).as_dvec3() - rig.center_of(&turned);
            layout[object] = scene::Pose { translation: turned.translation + shift, ..turned };
        }
    }

    fn starts(&self, model: usize, layout: &Layout) -> Vec<Pose> {
        self.run.starts(&self.models[model].rigs, self.group, layout)
    }

    /// Where the layouts come to rest; what cannot be simulated stays.
    fn settled(&self, model: usize, layouts: &[Layout]) -> Result<Vec<Layout>, BackendError> {
        let Model { rigs, world, simulation, .. } = &self.models[model];
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

    /// Lets layouts at rest go in all runs.
    fn judge(&self, layouts: Vec<Layout>) -> Result<Vec<Trial>, BackendError> {
        let Run { backend, config, seated, .. } = self.run;
        let mut moves = vec![vec![0.0_f64; seated.len()]; layouts.len()];
        let mut farther = vec![vec![0.0_f64; seated.len()]; layouts.len()];
        for (model, Model { world, simulation, price, .. }) in self.models.iter().enumerate() {
            let starts: Vec<Pose> = layouts.iter().flat_map(|layout| self.starts(model, layout)).collect();
            let checked = verify(*backend, world, simulation, &config.verify, &starts)?;
            let motions = checked.motions.chunks_exact(world.bodies.len()).zip(&checked.usable);
            for ((motions, usable), (moves, farther)) in motions.zip(moves.iter_mut().zip(&mut farther)) {
                for (body, object) in self.group.moving() {
                    let motion = &motions[body];
                    moves[object] += if *usable && motion.is_still(&config.verify) { 0.0 } else { *price };
                    farther[object] += self.weighed(motion.drift, motion.turn) / self.models.len() as f64;
                }
            }
        }
        let Model { world, simulation, .. } = &self.models[0];
        for (layout, moves) in layouts.iter().zip(&mut moves) {
            let depths = backend.overlaps(world, simulation, &self.starts(0, layout))?;
            for (pair, _) in world.pairs.iter().zip(&depths).filter(|(_, depth)| **depth > JAMMED) {
                let movable = self.group.moving().filter(|(body, _)| pair.contains(&(*body as u32)));
                movable.for_each(|(_, object)| moves[object] += JAMS);
            }
        }
        let trial = |((layout, moves), farther): ((Layout, Vec<f64>), Vec<f64>)| {
            let turned = |object: usize| angle(&layout[object], &seated[object]);
            let movable = || self.group.moving().map(|(_, object)| object);
            let unsupported = self.unsupported(&layout);
            let lost: Vec<usize> = movable().filter(|&object| unsupported[object]).collect();
            // First things first: a round that sets what is lost back leaves alone what only leans.
            let astray = match lost.is_empty() {
                true => movable().filter(|&object| turned(object) > LEANING).collect(),
                false => lost.clone(),
            };
            let moving: Vec<usize> = movable().filter(|&object| moves[object] > 0.0).collect();
            let failing = movable().filter(|&object| moves[object] > 0.0 || astray.contains(&object)).collect();
            let price = |object: usize| {
                self.distance(object, &layout[object])
                    + farther[object]
                    + if unsupported[object] { LOST } else { 0.0 }
                    + if turned(object) > FALLEN { FELL } else { 0.0 }
                    + moves[object]
            };
            let cost = movable().map(price).sum();
            Trial { moving, failing, lost, astray, cost, layout }
        };
        Ok(layouts.into_iter().zip(moves).zip(farther).map(trial).collect())
    }

    /// True for what has lost its support.
    fn unsupported(&self, layout: &Layout) -> Vec<bool> {
        let Run { scene, rigs, .. } = self.run;
        let bodies: Vec<Pose> = rigs.iter().zip(layout).map(|(rig, pose)| rig.body(pose)).collect();
        support::lost(scene, rigs, &bodies)
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

/// Every object that fails as it is in the trial in which it stands nearest to its reconstruction: what stands here and
/// there in different trials may stand together.
fn mixed(best: &Trial, trials: &[Trial], distance: impl Fn(usize, &scene::Pose) -> f64) -> Layout {
    let mut layout = best.layout.clone();
    for &object in &best.failing {
        let stands = trials.iter().filter(|trial| !trial.failing.contains(&object));
        let nearest = stands.map(|trial| trial.layout[object]);
        let nearest = nearest.min_by(|a, b| distance(object, a).total_cmp(&distance(object, b)));
        layout[object] = nearest.unwrap_or(layout[object]);
    }
    layout
}
