//! The CPU backend: one file per kernel, named as its shader; candidates in parallel over all cores.

pub mod best;
pub mod broad_phase;
pub mod clock;
pub mod contacts;
pub mod elites;
pub mod energy;
mod group;
mod lineup;
pub mod moments;
pub mod narrow_phase;
pub mod place;
mod population;
mod raster;
mod rollouts;
pub mod sample;
pub mod search;
mod simulate;
mod solve;
pub mod stats;

pub use group::Group;
pub use raster::CpuPainter;
pub use search::{CpuSearch, GoesOn, Record, Rollout};
pub use simulate::Workspace;

use crate::world::{
    Backend, BackendError, Flow, KernelTime, MemoryPlan, NarrowPhase, OnCandidate, OnStep, Pose, Rollouts, Search,
    SearchSettings, SimSettings, Status, Stream, Velocity, World, free_memory,
};
use narrow_phase::Separator;
use population::Population;

/// Simulates on the processor's cores.
#[derive(Clone, Copy, Debug, Default)]
pub struct CpuBackend;

impl Backend for CpuBackend {
    fn describe(&self) -> String {
        format!("CPU, {} threads", rayon::current_num_threads())
    }

    fn arithmetic(&self) -> String {
        "CPU".into()
    }

    fn narrow_phases(&self) -> &'static [NarrowPhase] {
        &[NarrowPhase::Twin, NarrowPhase::Reference]
    }

    fn busy_with(&self) -> usize {
        rayon::current_num_threads() * Group::lanes()
    }

    fn simulate(
        &self,
        world: &World,
        settings: &SimSettings,
        starts: &[Pose],
        on_step: &mut OnStep<'_>,
    ) -> Result<Vec<Status>, BackendError> {
        let bodies = world.bodies.len();
        if bodies == 0 {
            return Ok(Vec::new());
        }
        let mut population = Population::new(world, settings, starts);
        let mut poses = starts.to_vec();
        let mut velocities = vec![Velocity::default(); starts.len()];
        for step in 0..settings.steps {
            population.step();
            let rows = poses.chunks_exact_mut(bodies).zip(velocities.chunks_exact_mut(bodies));
            for ((poses, velocities), (_, candidate)) in rows.zip(population.running()) {
                poses.copy_from_slice(&candidate.poses);
                velocities.copy_from_slice(&candidate.velocities);
            }
            if on_step(step, &poses, &velocities) == Flow::Stop {
                break;
            }
        }
        Ok(population.statuses())
    }

    fn simulate_each(
        &self,
        world: &World,
        settings: &SimSettings,
        starts: &[Pose],
        on_candidate: &mut OnCandidate<'_>,
    ) -> Result<Vec<Status>, BackendError> {
        let mut population = Population::new(world, settings, starts);
        for _ in 0..settings.steps {
            population.step();
            population.retain(|number, candidate| {
                on_candidate(number, &candidate.poses, &candidate.velocities) == Flow::Continue
            });
            if population.running().next().is_none() {
                break;
            }
        }
        Ok(population.statuses())
    }

    fn rollouts(&self, world: &World, settings: &SimSettings, starts: &[Pose]) -> Result<Rollouts, BackendError> {
        Ok(rollouts::rollouts(world, settings, starts))
    }

    fn kernel_times(
        &self,
        world: &World,
        settings: &SimSettings,
        starts: &[Pose],
    ) -> Result<Vec<KernelTime>, BackendError> {
        Ok(rollouts::kernel_times(world, settings, starts))
    }

    fn search<'a>(
        &'a self,
        world: &'a World,
        settings: &'a SearchSettings,
        stream: Stream,
    ) -> Result<Box<dyn Search + 'a>, BackendError> {
        let simulator = Simulator::new(world, &settings.simulation);
        Ok(Box::new(CpuSearch::new(world, settings, stream, simulator)))
    }

    fn memory(&self, world: &World, SearchSettings { cem, .. }: &SearchSettings) -> MemoryPlan {
        MemoryPlan { bytes: search::bytes(world, cem.drawn()), at_once: cem.candidates }
    }

    fn free_bytes(&self) -> Option<u64> {
        free_memory()
    }

    fn overlaps(&self, world: &World, settings: &SimSettings, poses: &[Pose]) -> Result<Vec<f32>, BackendError> {
        let mut depths = vec![0.0; world.pairs.len()];
        let mut workspace = Workspace::new(world);
        workspace.start(poses);
        workspace.measure_depths(world, &Separator::new(settings.narrow_phase, &world.hulls), &mut depths);
        Ok(depths)
    }
}

/// The rollout of a candidate by this backend's kernels.
pub struct Simulator<'a> {
    world: &'a World,
    simulation: &'a SimSettings,
    narrow: Separator,
}

impl<'a> Simulator<'a> {
    /// Prepares what all candidates share.
    pub fn new(world: &'a World, simulation: &'a SimSettings) -> Self {
        Self { world, simulation, narrow: Separator::new(simulation.narrow_phase, &world.hulls) }
    }
}

impl Rollout for Simulator<'_> {
    type Scratch = Group;

    fn at_once(&self) -> usize {
        Group::lanes()
    }

    fn scratch(&self) -> Group {
        Group::new(self.world, Group::lanes())
    }

    fn run(&self, group: &mut Group, placed: &[Pose], steps: u32, records: &mut [Record], goes_on: &GoesOn<'_>) {
        let Self { world, simulation, narrow } = self;
        group.start(placed);
        group.retain(|number, candidate| {
            let record = &mut records[number];
            candidate.measure_depths(world, narrow, &mut record.depths_placed);
            record.snapshot.fill(Velocity::default());
            (record.steps, record.status) = (0, candidate.status);
            steps == 0 || goes_on(number, record)
        });
        for step in 1..=steps {
            group.step(world, simulation, narrow);
            if step == simulation.snapshot_step {
                group.retain(|number, candidate| {
                    let record = &mut records[number];
                    record.snapshot.copy_from_slice(&candidate.velocities);
                    (record.steps, record.status) = (step, candidate.status);
                    step == steps || goes_on(number, record)
                });
            }
        }
        for (number, candidate) in group.running_mut() {
            let record = &mut records[number];
            match steps {
                0 => record.depths_settled.copy_from_slice(&record.depths_placed),
                _ => candidate.measure_depths(world, narrow, &mut record.depths_settled),
            }
            record.settled.copy_from_slice(&candidate.poses);
            (record.steps, record.status) = (steps, candidate.status);
        }
    }
}
