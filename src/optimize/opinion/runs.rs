//! The runs in which a layout is let go: with the parts that the result names and with others, level and on slopes.

use super::Layout;
use crate::optimize::{config::VerifySettings, groups::Group, rig::Rig, run::Run};
use crate::world::{BodyDef, SimSettings, World};
use glam::Vec2;
use rayon::prelude::*;
use std::sync::Arc;

/// How steep the slopes are, rad (1.1°): other engines push what touches apart by tenths of a millimetre, and what stands on
/// less than that falls there.
const SLOPE: f32 = 0.02;

/// How long things are let go on slopes, at most, s: what rolls does so at once, and time is what these runs cost.
const ON_SLOPE_SECONDS: f32 = 2.0;

/// Share of the friction that is left on them: what leans with all of it creeps in engines whose friction gives way.
const SLIPPERY: f32 = 0.7;

/// What an object costs that moves, with the parts that the result names and with others, which may be at fault themselves: rad,
/// or so many times 17 cm.
const MOVES: f64 = 3.0;
const MOVES_OTHERWISE: f64 = 2.0;

/// And one that moves with others on one of the slopes: all eight of these runs count as much as one of those.
const MOVES_OTHERWISE_ON_SLOPE: f64 = 0.25;

/// Where the runs begin in which a race goes on: V-HACD's parts overlap and are many, and each of their runs takes as long as
/// ten others.
pub(super) const LAPS: [usize; 2] = [10, 11];

/// The runs on level ground with other parts.
pub(super) const LEVEL_OTHERWISE: [usize; 2] = [1, LAPS[0]];

/// All objects with the parts, masses and friction of a run, and its walls.
pub(super) struct Model<'a> {
    pub rigs: Arc<[Rig]>,
    pub walls: &'a [BodyDef],
    pub world: World,
    pub simulation: SimSettings,
    /// How long the objects are let go, and what counts as moving.
    pub check: VerifySettings,
    /// What an object costs that moves.
    pub price: f64,
}

impl<'a> Model<'a> {
    /// All runs of the objects of `group`, on slopes as they lie in `layout`.
    pub fn runs(run: &'a Run<'a>, group: &Group, layout: &Layout) -> Vec<Self> {
        let as_it_is = run.config.fine();
        let slippery = SimSettings { friction: SLIPPERY * as_it_is.friction, ..as_it_is.clone() };
        let level = &run.config.verify;
        let on_slope = VerifySettings { seconds: level.seconds.min(ON_SLOPE_SECONDS), ..level.clone() };
        let model = |(rigs, simulation, check, price): (Arc<[Rig]>, &SimSettings, &VerifySettings, f64)| Self {
            world: group.world(&rigs, &run.leant_on, layout, &run.seated),
            rigs,
            walls: &run.leant_on,
            simulation: simulation.clone(),
            check: check.clone(),
            price,
        };
        let slopes = [Vec2::X, Vec2::NEG_X, Vec2::Y, Vec2::NEG_Y].map(|way| SLOPE * way);
        let on_slopes = |rigs: &[Rig], price| {
            slopes.map(|slope| {
                let rigs = rigs.iter().zip(layout).map(|(rig, pose)| rig.on_slope(pose, slope)).collect();
                (rigs, &slippery, &on_slope, price)
            })
        };
        let stated = run.rigs.iter().zip(&run.scene.objects).map(|(rig, object)| rig.with_stated_mass(object.mass));
        let stated: Vec<Rig> = stated.collect();
        let otherwise = |rigs: &[Rig]| (rigs.into(), &as_it_is, level, MOVES_OTHERWISE);
        let [similar, voxels] = &run.alternatives;
        let mut runs = vec![(run.rigs[..].into(), &as_it_is, level, MOVES), otherwise(similar)];
        runs.extend(on_slopes(&stated, MOVES));
        runs.extend(on_slopes(similar, MOVES_OTHERWISE_ON_SLOPE));
        runs.push(otherwise(voxels));
        runs.extend(on_slopes(voxels, MOVES_OTHERWISE_ON_SLOPE));
        runs.into_par_iter().map(model).collect()
    }

    /// The same run in which only the objects of `group` that move there do.
    pub fn of(&self, group: &Group) -> Self {
        Self {
            rigs: Arc::clone(&self.rigs),
            walls: self.walls,
            world: self.world.holding(|body| !group.moves(body)),
            simulation: self.simulation.clone(),
            check: self.check.clone(),
            price: self.price,
        }
    }

    /// How copies settle: with the parts that the result names, and all walls.
    pub fn settling(run: &'a Run<'a>, group: &Group, layout: &Layout) -> Self {
        Self {
            rigs: run.rigs[..].into(),
            walls: &run.walls,
            world: group.world(&run.rigs, &run.walls, layout, &run.seated),
            simulation: run.config.fine(),
            check: run.config.verify.clone(),
            price: MOVES,
        }
    }
}
