//! The GPU as the optimizer sees it.

use super::adapter::{AdapterChoice, AdapterKind, AdapterReport};
use super::buffer::Download;
use super::device::{Gpu, GpuError, Options};
use super::kernel::Recorder;
use super::kernels::Kernels;
use super::plan::{Room, plan};
use super::rollouts::{kernel_times, rollouts};
use super::search::GpuSearch;
use super::simulation::{Simulation, grown};
use crate::world::{
    Backend, BackendError, Flow, KernelTime, MemoryPlan, OnStep, Pose, Rollouts, Search, SearchSettings, SimSettings,
    Status, Stream, World, free_memory,
};

/// Simulates on a graphics adapter.
pub struct GpuBackend {
    gpu: Gpu,
    kernels: Kernels,
}

impl GpuBackend {
    /// Opens the adapter and compiles all kernels.
    ///
    /// # Errors
    /// If there is no such adapter, or it lacks something.
    pub fn open(choice: &AdapterChoice) -> Result<Self, GpuError> {
        Self::open_with(&Options { adapter: choice.clone(), ..Options::default() })
    }

    /// The same, in a certain manner.
    ///
    /// # Errors
    /// As `open`.
    pub fn open_with(options: &Options) -> Result<Self, GpuError> {
        let gpu = Gpu::open_with(options)?;
        let kernels = Kernels::compile(&gpu)?;
        if let Some(pipelines) = &gpu.pipelines {
            // Without the file the next start takes longer, no more.
            let _ = pipelines.store();
        }
        Ok(Self { gpu, kernels })
    }

    /// The adapter.
    pub fn report(&self) -> &AdapterReport {
        self.gpu.report()
    }

    /// Refuses settings that the shaders do not know.
    fn check(&self, settings: &SimSettings) -> Result<(), BackendError> {
        if self.narrow_phases().contains(&settings.narrow_phase) {
            return Ok(());
        }
        Err(BackendError::Unsupported(
            "the reference narrow phase runs on the CPU only: set narrow_phase = \"twin\", or use --backend cpu".into(),
        ))
    }

    /// A simulation of all candidates at once: who asks for so many has split them.
    fn simulation(&self, world: &World, settings: &SimSettings, candidates: usize) -> Result<Simulation, GpuError> {
        let room = Room { split: 1, ..self.gpu.room() };
        let made = Simulation::fitting(&self.gpu, &self.kernels, world, settings, candidates as u32, room)?;
        if (made.candidates as usize) < candidates {
            return Err(GpuError::Capacity(format!(
                "{} simulates at most {} candidates of this scene at once",
                self.gpu.report().name,
                made.candidates
            )));
        }
        Ok(made)
    }

    /// Steps from the start, and calls `on_step` after all steps but the first `known`, which a run with less room has
    /// told of. Ends early when `on_step` says so, or when a candidate for which `rerun` is true had too little room.
    fn steps(
        &self,
        (world, settings, starts): (&World, &SimSettings, &[Pose]),
        known: &mut u32,
        rerun: impl Fn(Status) -> bool,
        on_step: &mut OnStep<'_>,
    ) -> Result<Vec<Status>, GpuError> {
        let gpu = &self.gpu;
        let candidates = starts.len() / world.bodies.len();
        let simulation = self.simulation(world, settings, candidates)?;
        let state = &simulation.state;
        let poses = Download::new(gpu, "poses", starts.len());
        let velocities = Download::new(gpu, "velocities", starts.len());
        let faults = Download::<u32>::new(gpu, "statuses", candidates);
        let mut statuses = vec![Status::default(); candidates];
        state.poses.upload(gpu, starts);
        let mut recorder = Recorder::new(gpu);
        simulation.rest(&mut recorder);
        let substeps = settings.substeps.max(1);
        for step in 0..settings.steps {
            for substep in step * substeps..(step + 1) * substeps {
                simulation.substep(&mut recorder, substep);
            }
            recorder.fetch(&state.poses, &poses);
            recorder.fetch(&state.velocities, &velocities);
            recorder.fetch(&state.statuses, &faults);
            recorder.submit();
            recorder = Recorder::new(gpu);
            let (poses, velocities) = (poses.take(gpu)?, velocities.take(gpu)?);
            statuses = faults.take(gpu)?.into_iter().map(Status).collect();
            if statuses.iter().any(|status| rerun(*status)) {
                break;
            }
            if step >= *known {
                *known += 1;
                if on_step(step, &poses, &velocities) == Flow::Stop {
                    break;
                }
            }
        }
        Ok(statuses)
    }
}

impl Backend for GpuBackend {
    fn describe(&self) -> String {
        let AdapterReport { name, kind, api, .. } = self.gpu.report();
        format!("GPU, {name} ({kind}, {api})")
    }

    fn simulate(
        &self,
        world: &World,
        settings: &SimSettings,
        starts: &[Pose],
        on_step: &mut OnStep<'_>,
    ) -> Result<Vec<Status>, BackendError> {
        self.check(settings)?;
        if world.bodies.is_empty() {
            return Ok(Vec::new());
        }
        let mut roomy = world.clone();
        let mut known = 0;
        loop {
            let more = |faults| grown(roomy.capacities, world.capacities, faults);
            let statuses =
                self.steps((&roomy, settings, starts), &mut known, |status| more(status).is_some(), on_step)?;
            let Some(capacities) = statuses.iter().find_map(|status| more(*status)) else { return Ok(statuses) };
            roomy.capacities = capacities;
        }
    }

    fn overlaps(&self, world: &World, settings: &SimSettings, poses: &[Pose]) -> Result<Vec<f32>, BackendError> {
        let mut roomy = world.clone();
        loop {
            let simulation = self.simulation(&roomy, settings, 1)?;
            let state = &simulation.state;
            let depths = Download::new(&self.gpu, "depths", world.pairs.len());
            let status = Download::<u32>::new(&self.gpu, "status", 1);
            state.poses.upload(&self.gpu, poses);
            let mut recorder = Recorder::new(&self.gpu);
            simulation.rest(&mut recorder);
            simulation.overlaps(&mut recorder);
            recorder.fetch(&state.depths_placed, &depths);
            recorder.fetch(&state.statuses, &status);
            recorder.submit();
            let depths = depths.take(&self.gpu)?;
            let faults = Status(status.take(&self.gpu)?[0]);
            let Some(capacities) = grown(roomy.capacities, world.capacities, faults) else { return Ok(depths) };
            roomy.capacities = capacities;
        }
    }

    fn rollouts(&self, world: &World, settings: &SimSettings, starts: &[Pose]) -> Result<Rollouts, BackendError> {
        self.check(settings)?;
        Ok(rollouts(&self.gpu, &self.kernels, world, settings, starts)?)
    }

    fn kernel_times(
        &self,
        world: &World,
        settings: &SimSettings,
        starts: &[Pose],
    ) -> Result<Vec<KernelTime>, BackendError> {
        self.check(settings)?;
        Ok(kernel_times(&self.gpu, &self.kernels, world, settings, starts)?)
    }

    fn search<'a>(
        &'a self,
        world: &'a World,
        settings: &'a SearchSettings,
        stream: Stream,
    ) -> Result<Box<dyn Search + 'a>, BackendError> {
        self.check(&settings.simulation)?;
        Ok(Box::new(GpuSearch::new(&self.gpu, &self.kernels, world, settings, stream)?))
    }

    fn memory(&self, world: &World, settings: &SearchSettings) -> MemoryPlan {
        plan(world, settings, self.gpu.room())
    }

    /// A software adapter has the processor's memory; of a card's, drivers do not tell.
    fn free_bytes(&self) -> Option<u64> {
        match self.gpu.report().kind {
            AdapterKind::Software | AdapterKind::Integrated => free_memory(),
            _ => None,
        }
    }
}
