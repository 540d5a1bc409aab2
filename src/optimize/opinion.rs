//! A second opinion: what stands only on the facets of one decomposition does not stand in an engine with another.
//!
//! The settled layout is checked with both decompositions of its meshes. What fails with either is searched once more, with
//! a wider spread: copies of the layout in which those objects are shifted and turned at random, about where they are and
//! about where they rest with their other parts. Each copy settles and is checked with both, and the one goes on in which
//! fewest fail, if what it gains is worth the distance from the reconstruction.

use super::{
    Event, Observer,
    finish::has_fallen,
    groups::Group,
    rig::Rig,
    run::Run,
    settle::settle,
    verify::{Motion, verify},
};
use crate::cpu::sample::sample;
use crate::scene;
use crate::world::{BackendError, Flow, Pose, SimSettings, Stream, World};
use glam::{DQuat, Vec3};

/// Copies that a round looks at.
const COPIES: u32 = 32;

/// Most rounds.
const ROUNDS: u32 = 3;

/// Standard deviation of the shift of an object that fails: m, horizontal and vertical; and of its turn about each axis, rad.
const SPREAD: [f32; 6] = [0.01, 0.0, 0.01, 0.3, 0.3, 0.3];

/// What an object that fails may cost: as much as a turn by half a radian, or a shift by a twelfth of a metre.
const FAILURE: f64 = 0.5;

/// Poses of all objects.
type Layout = Vec<scene::Pose>;

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
        let at_first = layout.clone();
        let mut failing = self.failing(std::slice::from_ref(layout), &at_first)?.swap_remove(0);
        for round in 0..ROUNDS {
            if failing.is_empty() || observer.event(Event::Reconsidering { failing: failing.len() }) == Flow::Stop {
                break;
            }
            let elsewhere = self.settled(1, std::slice::from_ref(layout))?.swap_remove(0);
            let trials: Vec<Layout> = (0..COPIES)
                .map(|copy| {
                    let mut trial = layout.clone();
                    if copy % 2 == 1 {
                        failing.iter().for_each(|&object| trial[object] = elsewhere[object]);
                    }
                    self.perturb(&mut trial, &failing, round, copy);
                    trial
                })
                .collect();
            let trials = self.settled(0, &trials)?;
            let verdicts = self.failing(&trials, &at_first)?;
            let cost = |layout: &Layout, failing: &[usize]| FAILURE * failing.len() as f64 + self.distance(layout);
            let costs =
                trials.into_iter().zip(verdicts).map(|(trial, failing)| (cost(&trial, &failing), trial, failing));
            match costs.min_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((least, trial, verdict)) if least < cost(layout, &failing) && verdict.len() < failing.len() => {
                    (*layout, failing) = (trial, verdict);
                }
                _ => break,
            }
        }
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

    /// Shifts and turns the objects about their centres of mass. The first two copies stay as they are.
    fn perturb(&self, layout: &mut Layout, objects: &[usize], round: u32, copy: u32) {
        if copy < 2 {
            return;
        }
        let std = SPREAD.repeat(objects.len());
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

    /// Objects of each layout that do not stand with both decompositions, or have fallen since the layout `at_first`.
    fn failing(&self, layouts: &[Layout], at_first: &Layout) -> Result<Vec<Vec<usize>>, BackendError> {
        let limits = &self.run.config.verify;
        let input = &self.run.input;
        let mut failing: Vec<Vec<usize>> = layouts
            .iter()
            .map(|layout| {
                let fell = |object: &usize| {
                    has_fallen(&layout[*object], &input[*object]) && !has_fallen(&at_first[*object], &input[*object])
                };
                self.group.moving().map(|(_, object)| object).filter(fell).collect()
            })
            .collect();
        for (model, Model { world, .. }) in self.models.iter().enumerate() {
            let starts: Vec<Pose> = layouts.iter().flat_map(|layout| self.starts(model, layout)).collect();
            let checked = verify(self.run.backend, world, &self.simulation, limits, &starts)?;
            let motions = checked.motions.chunks_exact(world.bodies.len()).zip(&checked.usable);
            for (failing, (motions, usable)) in failing.iter_mut().zip(motions) {
                let moved = |&(body, _): &(usize, usize)| !usable || !motions[body].is_still(limits);
                failing.extend(self.group.moving().filter(moved).map(|(_, object)| object));
            }
        }
        for objects in &mut failing {
            objects.sort_unstable();
            objects.dedup();
        }
        Ok(failing)
    }

    /// How far a layout is from the reconstruction, as the layout term weighs it.
    fn distance(&self, layout: &Layout) -> f64 {
        let Run { rigs, seated, config, .. } = self.run;
        let of = |object: usize| {
            let way = rigs[object].center_of(&layout[object]).distance(rigs[object].center_of(&seated[object]));
            f64::from(config.energy.position) * way + layout[object].rotation.angle_between(seated[object].rotation)
        };
        self.group.moving().map(|(_, object)| of(object)).sum()
    }
}
