//! Candidates of which some end before others. Those that still run move up, so that the solver's lanes are full as
//! long as there are enough.

use super::simulate::Workspace;
use crate::world::{Pose, World};

/// Candidates and their numbers, those that still run first.
pub(super) struct Lineup {
    workspaces: Vec<Workspace>,
    /// In the order in which they came.
    numbers: Vec<usize>,
    running: usize,
}

impl Lineup {
    /// Room for so many candidates of `world`, all of them running.
    pub fn new(world: &World, candidates: usize) -> Self {
        let workspaces = (0..candidates).map(|_| Workspace::new(world)).collect();
        Self { workspaces, numbers: (0..candidates).collect(), running: candidates }
    }

    /// Forgets the last candidates: the bodies are at rest at `placed`, candidate after candidate; nothing touches yet.
    pub fn start(&mut self, placed: &[Pose]) {
        let bodies = self.workspaces.first().map_or(1, |workspace| workspace.poses.len().max(1));
        self.running = placed.len() / bodies;
        let starts = self.workspaces.iter_mut().zip(&mut self.numbers).zip(placed.chunks_exact(bodies));
        for (i, ((workspace, number), placed)) in starts.enumerate() {
            workspace.start(placed);
            *number = i;
        }
    }

    /// Candidates that still run, with their numbers.
    pub fn running(&self) -> impl Iterator<Item = (usize, &Workspace)> {
        self.numbers.iter().copied().zip(&self.workspaces).take(self.running)
    }

    /// The same.
    pub fn running_mut(&mut self) -> impl Iterator<Item = (usize, &mut Workspace)> {
        self.numbers.iter().copied().zip(&mut self.workspaces).take(self.running)
    }

    /// The same without numbers.
    pub fn workspaces(&self) -> &[Workspace] {
        &self.workspaces[..self.running]
    }

    /// The same.
    pub fn workspaces_mut(&mut self) -> &mut [Workspace] {
        &mut self.workspaces[..self.running]
    }

    /// Ends the candidates for which `goes_on` is false.
    pub fn retain(&mut self, mut goes_on: impl FnMut(usize, &mut Workspace) -> bool) {
        for i in (0..self.running).rev() {
            if !goes_on(self.numbers[i], &mut self.workspaces[i]) {
                self.running -= 1;
                self.workspaces.swap(i, self.running);
                self.numbers.swap(i, self.running);
            }
        }
    }

    /// All candidates, ended ones too, with their numbers.
    pub fn all(&self) -> impl Iterator<Item = (usize, &Workspace)> {
        self.numbers.iter().copied().zip(&self.workspaces)
    }
}
