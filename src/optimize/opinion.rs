//! A second opinion: what stands only on the facets of one decomposition does not stand in an engine with another.
//!
//! The settled layout is let go with both decompositions of its meshes. What moves with either is searched once more, with
//! a wider spread, and so is what leans or has lost its support. Copies of the layout have those objects shifted and turned
//! at random, about where they are and about where they rest with their other parts, or where there is room for them near
//! the place at which they were set onto it.
//! Each copy settles and is let go with both, and so is a mixture in which every object is as in a copy that it stands in.
//! The one goes on that ends nearest to the reconstruction, with whichever decomposition moves it more, if less falls in it;
//! an object on its support is worth any way.

use super::{
    Event, Observer,
    finish::angle,
    groups::Group,
    rig::Rig,
    run::Run,
    settle::settle,
    support,
    verify::{Motion, verify},
};
use crate::cpu::sample::sample;
use crate::scene;
use crate::world::{BackendError, Flow, Pose, SimSettings, Stream, World};
use glam::{DQuat, Vec3};

/// Copies that a round looks at.
const COPIES: u32 = 32;

/// Most rounds; one that finds nothing better is the last.
const ROUNDS: u32 = 3;

/// Standard deviation of the shift of an object that fails: m, horizontal and vertical; and of its turn about each axis, rad.
/// The last copies have all of it, the first ones next to nothing.
const SPREAD: [f32; 6] = [0.01, 0.0, 0.01, 0.3, 0.3, 0.3];

/// An object turned by more than this from how it was set onto its support leans on something, or has fallen, rad (15°).
const LEANING: f64 = 0.26;

/// Poses of all objects.
type Layout = Vec<scene::Pose>;

/// A layout at rest, and what both decompositions make of it.
struct Trial {
    layout: Layout,
    /// Objects that move with either decomposition.
    moving: Vec<usize>,
    /// Those, and what leans, has fallen over or has lost its support.
    failing: Vec<usize>,
    /// Those that have lost their support.
    lost: Vec<usize>,
    /// Those; if there are none, those that lean or have fallen.
    astray: Vec<usize>,
    /// How far the objects are from the reconstruction and how much farther they go when let go, as the layout term weighs
    /// it.
    cost: f64,
}

impl Trial {
    /// How many objects have lost their support, and how many fail.
    fn failures(&self) -> (usize, usize) {
        (self.lost.len(), self.failing.len())
    }

    /// True if objects are back on their supports, or less fails and all are nearer to the reconstruction.
    fn improves(&self, other: &Self) -> bool {
        self.lost.len() < other.lost.len() || self.failures() < other.failures() && self.cost < other.cost
    }
}

/// One decomposition of all meshes.
struct Model<'a> {
    rigs: &'a [Rig],
    world: World,
}

/// The movable objects with each of their decompositions: first the parts that the result names, then the others.
pub(super) struct Opinions<'a> {
    run: &'a Run<'a>,
    group: &'a Group,
    models: [Model<'a>; 2],
    simulation: SimSettings,
}

impl<'a> Opinions<'a> {
    /// For the objects of `group`; `others` are their rigs with the alternative parts.
    pub fn new(run: &'a Run<'a>, group: &'a Group, others: &'a [Rig], layout: &[scene::Pose]) -> Self {
        let model = |rigs: &'a [Rig]| Model { rigs, world: group.world(rigs, &run.walls, layout, &run.seated) };
        Self { run, group, models: [model(&run.rigs), model(others)], simulation: run.config.fine() }
    }

    /// Searches what does not stand with both decompositions once more. The layout stays as it is unless fewer fail.
    pub fn improve(&self, layout: &mut Layout, observer: &mut dyn Observer) -> Result<(), BackendError> {
        let mut best = self.judge(vec![layout.clone()])?.swap_remove(0);
        for round in 0..ROUNDS {
            if best.failing.is_empty()
                || observer.event(Event::Reconsidering { failing: best.failing.len() }) == Flow::Stop
            {
                break;
            }
            let copies = self.copies(&best, round)?;
            let mut trials = self.judge(self.settled(0, &copies)?)?;
            let mixed = [mixed(&best, &trials, |object, pose| self.distance(object, pose))];
            trials.extend(self.judge(self.settled(0, &mixed)?)?);
            trials.retain(|trial| trial.improves(&best));
            let order = |a: &Trial, b: &Trial| a.failures().cmp(&b.failures()).then(a.cost.total_cmp(&b.cost));
            match trials.into_iter().min_by(order) {
                Some(better) => best = better,
                None => break,
            }
        }
        *layout = best.layout;
        Ok(())
    }

    /// What the moving bodies of a layout do with their other parts, in the group's order; nothing if that cannot be
    /// simulated.
    pub fn second(&self, layout: &Layout) -> Result<Vec<Motion>, BackendError> {
        let Model { world, .. } = &self.models[1];
        let checked =
            verify(self.run.backend, world, &self.simulation, &self.run.config.verify, &self.starts(1, layout))?;
        let moving = self.group.moving().map(|(body, _)| checked.motions[body]);
        Ok(if checked.usable[0] { moving.collect() } else { Vec::new() })
    }

    /// Copies of a layout in which what moves is shifted and turned, in every other one from where it rests with its other
    /// parts. What has lost its support is set onto it again in all, what leans or has fallen in half of them: it may do so
    /// for good, and take others along.
    fn copies(&self, trial: &Trial, round: u32) -> Result<Vec<Layout>, BackendError> {
        let elsewhere = self.settled(1, std::slice::from_ref(&trial.layout))?.swap_remove(0);
        let places: Vec<Layout> =
            trial.astray.iter().map(|&object| self.run.free_places(object, &trial.layout)).collect();
        let copy = |copy| {
            let mut layout = trial.layout.clone();
            let mut objects = trial.moving.clone();
            if copy % 2 == 1 {
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
        self.run.starts(self.models[model].rigs, self.group, layout)
    }

    /// Where the layouts come to rest; what cannot be simulated stays.
    fn settled(&self, model: usize, layouts: &[Layout]) -> Result<Vec<Layout>, BackendError> {
        let Model { rigs, world } = &self.models[model];
        let starts: Vec<Pose> = layouts.iter().flat_map(|layout| self.starts(model, layout)).collect();
        let settled = settle(self.run.backend, world, &self.simulation, &self.run.config.settle, &starts)?;
        let bodies = world.bodies.len();
        let mut layouts = layouts.to_vec();
        for (candidate, layout) in layouts.iter_mut().enumerate().filter(|(candidate, _)| settled.usable[*candidate]) {
            let own = candidate * bodies..(candidate + 1) * bodies;
            self.group.adopt(rigs, &starts[own.clone()], &settled.poses[own], layout);
        }
        Ok(layouts)
    }

    /// Lets layouts at rest go with both decompositions.
    fn judge(&self, layouts: Vec<Layout>) -> Result<Vec<Trial>, BackendError> {
        let Run { backend, config, seated, .. } = self.run;
        let mut moves = vec![vec![false; seated.len()]; layouts.len()];
        let mut farther = vec![vec![0.0_f64; seated.len()]; layouts.len()];
        for (model, Model { world, .. }) in self.models.iter().enumerate() {
            let starts: Vec<Pose> = layouts.iter().flat_map(|layout| self.starts(model, layout)).collect();
            let checked = verify(*backend, world, &self.simulation, &config.verify, &starts)?;
            let motions = checked.motions.chunks_exact(world.bodies.len()).zip(&checked.usable);
            for ((motions, usable), (moves, farther)) in motions.zip(moves.iter_mut().zip(&mut farther)) {
                for (body, object) in self.group.moving() {
                    let motion = &motions[body];
                    moves[object] |= !usable || !motion.is_still(&config.verify);
                    farther[object] = farther[object].max(self.weighed(motion.drift, motion.turn));
                }
            }
        }
        let trial = |((layout, moves), farther): ((Layout, Vec<bool>), Vec<f64>)| {
            let leans = |object: usize| angle(&layout[object], &seated[object]) > LEANING;
            let movable = || self.group.moving().map(|(_, object)| object);
            let unsupported = self.unsupported(&layout);
            let lost: Vec<usize> = movable().filter(|&object| unsupported[object]).collect();
            // First things first: a round that sets what is lost back leaves alone what only leans.
            let astray = match lost.is_empty() {
                true => movable().filter(|&object| leans(object)).collect(),
                false => lost.clone(),
            };
            let moving: Vec<usize> = movable().filter(|&object| moves[object]).collect();
            let failing = movable().filter(|&object| moves[object] || astray.contains(&object)).collect();
            let cost = movable().map(|object| self.distance(object, &layout[object]) + farther[object]).sum();
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
