//! All candidates of a simulation.

use super::{
    group::{Group, Stepper, at_once},
    lineup::Lineup,
    narrow_phase::Separator,
    simulate::Workspace,
};
use crate::world::{Pose, SimSettings, Status, World};
use fearless_simd::Level;
use rayon::prelude::*;

/// Candidates, and what all threads need to advance them.
pub(super) struct Population<'a> {
    world: &'a World,
    settings: &'a SimSettings,
    narrow: Separator,
    lineup: Lineup,
    steppers: Vec<Stepper>,
}

impl<'a> Population<'a> {
    /// Candidates at rest at `starts`, candidate-major.
    pub fn new(world: &'a World, settings: &'a SimSettings, starts: &[Pose]) -> Self {
        let candidates = starts.len() / world.bodies.len().max(1);
        let mut lineup = Lineup::new(world, candidates);
        lineup.start(starts);
        // More threads than full groups: then each takes fewer candidates.
        let most = candidates.min(rayon::current_num_threads()).max(candidates.div_ceil(Group::lanes()));
        Self {
            world,
            settings,
            narrow: Separator::new(settings.narrow_phase, &world.hulls),
            lineup,
            steppers: (0..most).map(|_| Stepper::new(Level::new())).collect(),
        }
    }

    /// Advances what still runs by one step of `dt`.
    pub fn step(&mut self) {
        let Self { world, settings, narrow, lineup, steppers } = self;
        let running = lineup.workspaces_mut();
        let size = at_once(running.len(), Group::lanes());
        let groups = running.par_chunks_mut(size).zip(steppers);
        groups.for_each(|(group, stepper)| stepper.step((world, settings, narrow), group, &mut ()));
    }

    /// Candidates that still run, with their numbers.
    pub fn running(&self) -> impl Iterator<Item = (usize, &Workspace)> {
        self.lineup.running()
    }

    /// Ends the candidates for which `goes_on` is false.
    pub fn retain(&mut self, mut goes_on: impl FnMut(usize, &Workspace) -> bool) {
        self.lineup.retain(|number, candidate| goes_on(number, candidate));
    }

    /// What went wrong in each candidate, by number.
    pub fn statuses(&self) -> Vec<Status> {
        let mut statuses = vec![Status::default(); self.lineup.all().count()];
        self.lineup.all().for_each(|(number, candidate)| statuses[number] = candidate.status);
        statuses
    }
}
