//! Candidates that advance in lock step, because the solver takes several at once.

use super::{
    clock::{Clock, Kernel},
    lineup::Lineup,
    narrow_phase::Separator,
    simulate::{Scratch, Workspace},
    solve::Solver,
};
use crate::world::{Pose, SimSettings, World};
use fearless_simd::Level;

/// How many of `candidates` a thread takes at once: the `most` that it can, unless other threads would have nothing to
/// do.
pub(super) fn at_once(candidates: usize, most: usize) -> usize {
    candidates.div_ceil(rayon::current_num_threads()).clamp(1, most)
}

/// What a thread needs to advance candidates, at most as many at once as the solver takes. What becomes of one does not
/// depend on the others.
pub(super) struct Stepper {
    scratch: Scratch,
    solver: Solver,
}

impl Stepper {
    /// Solves with the vectors that `level` says that the processor has.
    pub fn new(level: Level) -> Self {
        Self { scratch: Scratch::default(), solver: Solver::new(level) }
    }

    /// Advances the candidates by one step of `dt`, and tells `clock` of every part.
    pub fn step(
        &mut self,
        (world, settings, narrow): (&World, &SimSettings, &Separator),
        candidates: &mut [Workspace],
        clock: &mut impl Clock,
    ) {
        for _ in 0..settings.substeps.max(1) {
            self.collide((world, settings, narrow), candidates, clock);
            self.solver.substep(&world.bodies, settings, candidates);
            clock.lap(Kernel::Solve);
        }
        candidates.iter_mut().for_each(Workspace::check);
    }

    fn collide(
        &mut self,
        (world, settings, narrow): (&World, &SimSettings, &Separator),
        candidates: &mut [Workspace],
        clock: &mut impl Clock,
    ) {
        for candidate in &mut *candidates {
            candidate.collide(world, settings, narrow, &mut self.scratch, clock);
        }
        // Those that advance together have begun together.
        if candidates.first().is_some_and(|candidate| candidate.begins) {
            debug_assert!(candidates.iter().all(|candidate| candidate.begins), "some have begun before");
            candidates.iter_mut().for_each(|candidate| candidate.begins = false);
            self.solver.find_loads(&world.bodies, settings, candidates);
            clock.lap(Kernel::Solve);
        }
    }
}

/// Some candidates that advance together; made once per thread and reused.
pub struct Group {
    lineup: Lineup,
    stepper: Stepper,
}

impl Group {
    /// How many candidates a thread had best take at once: as many as the solver does.
    pub fn lanes() -> usize {
        Solver::lanes(Level::new())
    }

    /// Room for so many candidates of `world`.
    pub fn new(world: &World, candidates: usize) -> Self {
        Self::stepped_by(Stepper::new(Level::new()), world, candidates)
    }

    fn stepped_by(stepper: Stepper, world: &World, candidates: usize) -> Self {
        Self { lineup: Lineup::new(world, candidates), stepper }
    }

    /// Forgets the last candidates: the bodies are at rest at `placed`, candidate after candidate; nothing touches yet.
    pub fn start(&mut self, placed: &[Pose]) {
        self.lineup.start(placed);
    }

    /// The candidates that `start` was given, but those that have ended; in their order as long as none has.
    pub fn candidates(&self) -> &[Workspace] {
        self.lineup.workspaces()
    }

    /// The same.
    pub fn candidates_mut(&mut self) -> &mut [Workspace] {
        self.lineup.workspaces_mut()
    }

    /// The same, with the number that each had among them all.
    pub fn running_mut(&mut self) -> impl Iterator<Item = (usize, &mut Workspace)> {
        self.lineup.running_mut()
    }

    /// Ends the candidates for which `goes_on` is false.
    pub fn retain(&mut self, goes_on: impl FnMut(usize, &mut Workspace) -> bool) {
        self.lineup.retain(goes_on);
    }

    /// Advances by one step of `dt`.
    pub fn step(&mut self, world: &World, settings: &SimSettings, narrow: &Separator) {
        self.step_timed(world, settings, narrow, &mut ());
    }

    /// The same, and tells `clock` of every part.
    pub fn step_timed(&mut self, world: &World, settings: &SimSettings, narrow: &Separator, clock: &mut impl Clock) {
        self.stepper.step((world, settings, narrow), self.lineup.workspaces_mut(), clock);
    }

    /// Finds the contacts of the next substep.
    pub fn collide(&mut self, world: &World, settings: &SimSettings, narrow: &Separator) {
        self.collide_timed(world, settings, narrow, &mut ());
    }

    /// The same, and tells `clock` of every part and of what it found.
    pub fn collide_timed(&mut self, world: &World, settings: &SimSettings, narrow: &Separator, clock: &mut impl Clock) {
        self.stepper.collide((world, settings, narrow), self.lineup.workspaces_mut(), clock);
    }

    /// Advances by one substep with the contacts at hand.
    pub fn solve(&mut self, world: &World, settings: &SimSettings) {
        self.stepper.solver.substep(&world.bodies, settings, self.lineup.workspaces_mut());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::box_corners;
    use crate::world::{BodyDef, Status};
    use glam::{Quat, Vec3};

    /// More than any processor's vectors have lanes.
    const CANDIDATES: usize = 17;
    /// The candidate that leaves the numbers.
    const LOST: usize = 4;

    /// A flat brick with three cubes above it.
    fn world() -> World {
        let brick = |half: Vec3, y: f32| {
            let start = Pose::new(Quat::IDENTITY, Vec3::Y * y);
            let inertia = Vec3::splat(0.7 * half.max_element() * half.max_element());
            BodyDef { parts: vec![box_corners(half)], mass: 1.0, inertia, unit: 0, start, reference: start }
        };
        let flat = brick(Vec3::new(0.2, 0.05, 0.2), 0.05);
        let cubes = [0.2, 0.41, 0.62].map(|y| brick(Vec3::splat(0.1), y));
        let [a, b, c] = cubes;
        World::new(&[flat, a, b, c], &[0])
    }

    /// The higher the number, the farther the cubes are from standing on one another: none, then one, then all fall.
    fn starts(world: &World) -> Vec<Pose> {
        let placed = |candidate: usize| {
            let shift = Vec3::new(0.031, 0.004, 0.013) * candidate as f32;
            let turn = Quat::from_rotation_y(0.07 * candidate as f32) * Quat::from_rotation_x(0.02 * candidate as f32);
            let moved = move |(body, pose): (usize, &Pose)| {
                Pose::new(turn * pose.rotation, pose.translation + body as f32 * shift)
            };
            world.start.iter().enumerate().map(moved)
        };
        (0..CANDIDATES).flat_map(placed).collect()
    }

    /// Bits of all candidates' motion, step by step, and what went wrong, simulated so many at once.
    fn simulated(world: &World, level: Level, at_once: usize) -> Vec<(Vec<u8>, Status)> {
        let settings = SimSettings { steps: 40, ..Default::default() };
        let narrow = Separator::new(settings.narrow_phase, &world.hulls);
        let mut group = Group::stepped_by(Stepper::new(level), world, at_once);
        let mut all = Vec::new();
        for placed in starts(world).chunks(at_once * world.bodies.len()) {
            group.start(placed);
            // The sign of a nought must not depend on the company either.
            for velocity in group.candidates_mut().iter_mut().flat_map(|candidate| &mut candidate.velocities) {
                (velocity.linear, velocity.angular) = (Vec3::splat(-0.0), Vec3::splat(-0.0));
            }
            if let Some(lost) = LOST.checked_sub(all.len()).and_then(|lost| group.candidates_mut().get_mut(lost)) {
                lost.velocities[1].linear = Vec3::new(0.0, -3e38, 1e38);
            }
            let mut motion = vec![Vec::new(); group.candidates().len()];
            for _ in 0..settings.steps {
                group.step(world, &settings, &narrow);
                for (candidate, bytes) in group.candidates().iter().zip(&mut motion) {
                    bytes.extend_from_slice(bytemuck::cast_slice(&candidate.poses));
                    bytes.extend_from_slice(bytemuck::cast_slice(&candidate.velocities));
                }
            }
            all.extend(motion.into_iter().zip(group.candidates().iter().map(|candidate| candidate.status)));
        }
        all
    }

    #[test]
    fn company_and_processor_change_no_bit() {
        let world = world();
        let alone = simulated(&world, Level::new(), 1);
        assert!(alone.windows(2).all(|two| two[0] != two[1]), "the candidates must differ");
        for (candidate, (_, status)) in alone.iter().enumerate() {
            assert_eq!(status.intersects(Status::NOT_FINITE), candidate == LOST, "candidate {candidate}");
        }
        for (level, at_once) in [(Level::new(), 2), (Level::new(), 7), (Level::new(), 17), (Level::baseline(), 17)] {
            let together = simulated(&world, level, at_once);
            for (candidate, (one, other)) in alone.iter().zip(&together).enumerate() {
                assert_eq!(one.1, other.1, "candidate {candidate}, {at_once} at once");
                assert!(candidate == LOST || one.0 == other.0, "candidate {candidate}, {at_once} at once, {level:?}");
            }
        }
    }
}
