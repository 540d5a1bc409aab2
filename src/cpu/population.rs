//! All candidates of a simulation. When some have ended the others move up, so that the solver's lanes stay full.

use super::{
    group::{Group, Stepper, at_once},
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
    /// Those that still run come first.
    candidates: Vec<Workspace>,
    /// The candidates' numbers in the order in which they came.
    numbers: Vec<usize>,
    running: usize,
    steppers: Vec<Stepper>,
}

impl<'a> Population<'a> {
    /// Candidates at rest at `starts`, candidate-major.
    pub fn new(world: &'a World, settings: &'a SimSettings, starts: &[Pose]) -> Self {
        let workspace = |placed| {
            let mut workspace = Workspace::new(world);
            workspace.start(placed);
            workspace
        };
        let candidates: Vec<Workspace> = starts.chunks_exact(world.bodies.len().max(1)).map(workspace).collect();
        let running = candidates.len();
        // More threads than full groups: then each takes fewer candidates.
        let most = running.min(rayon::current_num_threads()).max(running.div_ceil(Group::best()));
        Self {
            world,
            settings,
            narrow: Separator::new(settings.narrow_phase, &world.hulls),
            candidates,
            numbers: (0..running).collect(),
            running,
            steppers: (0..most).map(|_| Stepper::new(Level::new())).collect(),
        }
    }

    /// Advances what still runs by one step of `dt`.
    pub fn step(&mut self) {
        let Self { world, settings, narrow, candidates, running, steppers, .. } = self;
        let groups = candidates[..*running].par_chunks_mut(at_once(*running, Group::best()));
        groups.zip(steppers).for_each(|(group, stepper)| stepper.step((world, settings, narrow), group, &mut ()));
    }

    /// Candidates that still run, with their numbers.
    pub fn running(&self) -> impl Iterator<Item = (usize, &Workspace)> {
        self.numbers.iter().copied().zip(&self.candidates).take(self.running)
    }

    /// Ends the candidates for which `goes_on` is false.
    pub fn retain(&mut self, mut goes_on: impl FnMut(usize, &Workspace) -> bool) {
        for i in (0..self.running).rev() {
            if !goes_on(self.numbers[i], &self.candidates[i]) {
                self.running -= 1;
                self.candidates.swap(i, self.running);
                self.numbers.swap(i, self.running);
            }
        }
    }

    /// What went wrong in each candidate, by number.
    pub fn statuses(&self) -> Vec<Status> {
        let mut statuses = vec![Status::default(); self.candidates.len()];
        self.numbers.iter().zip(&self.candidates).for_each(|(&number, ended)| statuses[number] = ended.status);
        statuses
    }
}
