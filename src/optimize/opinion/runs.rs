//! The runs in which a layout is let go: with the parts of the search and with others, level and on slopes.

use super::Layout;
use super::tolerances::{
    FILLED, HASTE, MOVES, MOVES_OTHERWISE, MOVES_OTHERWISE_ON_SLOPE, ON_SLOPE_SECONDS, SLIPPERY, SLOPE,
};
use crate::optimize::{config::VerifySettings, groups::Group, rig::Rig, run::Run};
use crate::world::{BackendError, BodyDef, SimSettings, World};
use glam::Vec2;
use rayon::prelude::*;
use std::sync::Arc;

/// Where the runs begin in which a race goes on: V-HACD's parts overlap and are many, and each of their runs takes as
/// long as ten others.
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
    /// All runs of the objects of `group`, on slopes as they lie in `layout`; and the objects that have the parts of the
    /// search in some where others are meant, because those fill what is in them.
    pub fn runs(run: &'a Run<'a>, group: &Group, layout: &Layout) -> Result<(Vec<Self>, Vec<usize>), BackendError> {
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
        let closed = [filled(run, group, layout, similar)?, filled(run, group, layout, voxels)?];
        let open = |rigs: &[Rig], closed: &[usize]| {
            let mut rigs = rigs.to_vec();
            closed.iter().for_each(|&object| rigs[object] = run.rigs[object].clone());
            rigs
        };
        let [similar, voxels] = [&open(similar, &closed[0]), &open(voxels, &closed[1])];
        let mut runs = vec![(run.rigs[..].into(), &as_it_is, level, MOVES), otherwise(similar)];
        runs.extend(on_slopes(&stated, MOVES));
        runs.extend(on_slopes(similar, MOVES_OTHERWISE_ON_SLOPE));
        runs.push(otherwise(voxels));
        runs.extend(on_slopes(voxels, MOVES_OTHERWISE_ON_SLOPE));
        let mut closed = closed.concat();
        closed.sort_unstable();
        closed.dedup();
        Ok((runs.into_par_iter().map(model).collect(), closed))
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

    /// The same run for a first look: with the resolution of the search, and for a share of the time.
    pub fn hastened(self, search: &SimSettings) -> Self {
        let SimSettings { substeps, position_iterations, .. } = *search;
        Self {
            simulation: SimSettings { substeps, position_iterations, ..self.simulation },
            check: VerifySettings { seconds: HASTE * self.check.seconds, ..self.check },
            ..self
        }
    }

    /// How copies settle: with the parts of the search, and all walls.
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

/// Objects whose parts in another decomposition fill what one is in that they bear: V-HACD closes a basin in a long
/// worktop and the compartments of a shelf, and what is in there finds rest nowhere, whatever the search does.
fn filled(run: &Run, group: &Group, layout: &Layout, alternative: &[Rig]) -> Result<Vec<usize>, BackendError> {
    let world = group.world(alternative, &run.leant_on, layout, &run.seated);
    let starts = group.starts(alternative, &run.leant_on, layout);
    let depths = run.backend.overlaps(&world, &run.config.fine(), &starts)?;
    let mut filled = Vec::new();
    for (pair, _) in world.pairs.iter().zip(&depths).filter(|(_, depth)| **depth > FILLED) {
        // A wall is no object.
        let objects: Vec<usize> = pair.iter().filter_map(|&body| group.objects.get(body as usize)).copied().collect();
        let bears = |bearer: &usize| objects.iter().any(|&object| run.scene.bearers(object).any(|b| b == *bearer));
        filled.extend(objects.iter().copied().filter(bears));
    }
    Ok(filled)
}
