//! Candidates that advance in lock step, because the solver takes several at once.

use super::{
    clock::{Clock, Kernel},
    narrow_phase::Separator,
    simulate::Workspace,
    solve::{LANES, Solver},
};
use crate::world::{Pose, SimSettings, World};
use std::ops::{Index, IndexMut};

/// How many of `candidates` a thread takes at once: the `most` that it can, unless other threads would have nothing to do.
pub(super) fn at_once(candidates: usize, most: usize) -> usize {
    candidates.div_ceil(rayon::current_num_threads()).clamp(1, most)
}

/// Up to `Group::MOST` candidates; made once per thread and reused. What becomes of a candidate does not depend on the
/// others.
pub struct Group {
    workspaces: Vec<Workspace>,
    /// The others are spare.
    running: usize,
    solver: Solver,
}

impl Group {
    /// Most candidates of a group.
    pub const MOST: usize = LANES;

    /// Room for so many candidates of `world`.
    pub fn new(world: &World, candidates: usize) -> Self {
        assert!((1..=Self::MOST).contains(&candidates), "a group of {candidates}");
        let workspaces = (0..candidates).map(|_| Workspace::new(world)).collect();
        Self { workspaces, running: candidates, solver: Solver::new() }
    }

    /// Forgets the last candidates: the bodies are at rest at `placed`, candidate after candidate; nothing touches yet.
    pub fn start(&mut self, placed: &[Pose]) {
        let bodies = self.workspaces[0].poses.len().max(1);
        self.running = placed.len() / bodies;
        for (workspace, placed) in self.workspaces[..self.running].iter_mut().zip(placed.chunks_exact(bodies)) {
            workspace.start(placed);
        }
    }

    /// The candidates that `start` was given.
    pub fn candidates(&self) -> &[Workspace] {
        &self.workspaces[..self.running]
    }

    /// The same.
    pub fn candidates_mut(&mut self) -> &mut [Workspace] {
        &mut self.workspaces[..self.running]
    }

    /// Advances by one step of `dt`.
    pub fn step(&mut self, world: &World, settings: &SimSettings, narrow: &Separator) {
        self.step_timed(world, settings, narrow, &mut ());
    }

    /// The same, and tells `clock` of every part.
    pub fn step_timed(&mut self, world: &World, settings: &SimSettings, narrow: &Separator, clock: &mut impl Clock) {
        for _ in 0..settings.substeps.max(1) {
            for candidate in self.candidates_mut() {
                candidate.collide_timed(world, settings, narrow, clock);
            }
            self.solve(world, settings);
            clock.lap(Kernel::Solve);
        }
        self.candidates_mut().iter_mut().for_each(Workspace::check);
    }

    /// Advances by one substep with the contacts at hand.
    pub fn solve(&mut self, world: &World, settings: &SimSettings) {
        self.solver.substep(&world.bodies, settings, &mut self.workspaces[..self.running]);
    }
}

/// A candidate.
impl Index<usize> for Group {
    type Output = Workspace;

    fn index(&self, candidate: usize) -> &Workspace {
        &self.candidates()[candidate]
    }
}

impl IndexMut<usize> for Group {
    fn index_mut(&mut self, candidate: usize) -> &mut Workspace {
        &mut self.candidates_mut()[candidate]
    }
}
