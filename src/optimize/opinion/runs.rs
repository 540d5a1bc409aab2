//! The runs in which a layout is let go: with the parts that the result names and with others, level and on slopes.

use super::Layout;
use crate::optimize::{groups::Group, rig::Rig, run::Run};
use crate::world::{BodyDef, SimSettings, World};
use glam::Vec2;

/// How steep the slopes are, rad (1.1°): other engines push what touches apart by tenths of a millimetre, and what stands on
/// less than that falls there.
const SLOPE: f32 = 0.02;

/// Share of the friction that is left on them: what leans with all of it creeps in engines whose friction gives way.
const SLIPPERY: f32 = 0.7;

/// What an object costs that moves, with the parts that the result names and with others, which may be at fault themselves: rad,
/// or so many times 17 cm.
const MOVES: f64 = 3.0;
const MOVES_OTHERWISE: f64 = 2.0;

/// And one that moves with others on one of the slopes: all eight of these runs count as much as one of those.
const MOVES_OTHERWISE_ON_SLOPE: f64 = 0.25;

/// The first runs tell most: level, and on slopes with the parts that the result names.
pub(super) const FIRST: usize = 7;

/// All objects with the parts, masses and friction of a run, and its walls.
pub(super) struct Model<'a> {
    pub rigs: Vec<Rig>,
    pub walls: &'a [BodyDef],
    pub world: World,
    pub simulation: SimSettings,
    /// What an object costs that moves.
    pub price: f64,
}

impl<'a> Model<'a> {
    /// All runs of the objects of `group`, on slopes as they lie in `layout`.
    pub fn runs(run: &'a Run<'a>, group: &Group, layout: &Layout) -> Vec<Self> {
        let as_it_is = run.config.fine();
        let slippery = SimSettings { friction: SLIPPERY * as_it_is.friction, ..as_it_is.clone() };
        let model = |rigs: Vec<Rig>, simulation: &SimSettings, price| Self {
            world: group.world(&rigs, &run.leant_on, layout, &run.seated),
            rigs,
            walls: &run.leant_on,
            simulation: simulation.clone(),
            price,
        };
        let slopes = [Vec2::X, Vec2::NEG_X, Vec2::Y, Vec2::NEG_Y].map(|way| SLOPE * way);
        let on = |rigs: &[Rig], slope| rigs.iter().zip(layout).map(|(rig, pose)| rig.on_slope(pose, slope)).collect();
        let mut models = vec![model(run.rigs.clone(), &as_it_is, MOVES)];
        models.extend(run.alternatives.iter().map(|rigs| model(rigs.clone(), &as_it_is, MOVES_OTHERWISE)));
        let stated = run.rigs.iter().zip(&run.scene.objects).map(|(rig, object)| rig.with_stated_mass(object.mass));
        let stated: Vec<Rig> = stated.collect();
        models.extend(slopes.map(|slope| model(on(&stated, slope), &slippery, MOVES)));
        let otherwise = run.alternatives.iter().flat_map(|rigs| slopes.map(|slope| on(rigs, slope)));
        models.extend(otherwise.map(|rigs| model(rigs, &slippery, MOVES_OTHERWISE_ON_SLOPE)));
        models
    }

    /// How copies settle: with the parts that the result names, and all walls.
    pub fn settling(run: &'a Run<'a>, group: &Group, layout: &Layout) -> Self {
        Self {
            rigs: run.rigs.clone(),
            walls: &run.walls,
            world: group.world(&run.rigs, &run.walls, layout, &run.seated),
            simulation: run.config.fine(),
            price: MOVES,
        }
    }
}
