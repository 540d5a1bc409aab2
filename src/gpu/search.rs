//! The Cross-Entropy search on the device: only what an iteration reports comes back.

use super::buffer::Download;
use super::device::{Gpu, GpuError};
use super::funnel::Funnel;
use super::kernel::Recorder;
use super::kernels::Kernels;
use super::layout::{Flags, Stats};
use super::plan::{Room, ranking_loops};
use super::population::Population;
use super::simulation::{Pace, Simulation, grown};
use super::timer::Timer;
use crate::world::{
    BackendError, Best, Capacities, CemSettings, Distribution, Energy, IterationStats, KernelTime, Pose, Search,
    SearchSettings, Status, Stream, Winner, World,
};
use bytemuck::Pod;

/// A halving of the candidates at a time helped if it left less than this share of a substep's time.
const HELPED: f64 = 0.75;

/// A search over the units of one world.
pub struct GpuSearch<'a> {
    gpu: &'a Gpu,
    kernels: &'a Kernels,
    /// With the capacities that it took so far.
    world: World,
    first_capacities: Capacities,
    settings: &'a SearchSettings,
    stream: Stream,
    population: Population,
    funnel: Funnel,
    /// How many times fewer candidates it simulates at a time than would fit.
    split: u32,
    /// What a substep took when it was last too slow, s; 0 if fewer at a time did not help.
    too_slow: f64,
    /// Of most rounds, and of a smaller last one.
    paces: [Pace; 2],
    iteration: u32,
    distribution: Distribution,
    flags: Download<Flags>,
    stats: Download<Stats>,
    mean: Download<f32>,
    std: Download<f32>,
    timer: Option<Timer>,
}

impl<'a> GpuSearch<'a> {
    /// Makes all buffers.
    ///
    /// # Errors
    /// If not even one candidate fits, there are more than a software adapter ranks, or the device failed.
    pub fn new(
        gpu: &'a Gpu,
        kernels: &'a Kernels,
        world: &World,
        settings: &'a SearchSettings,
        stream: Stream,
    ) -> Result<Self, GpuError> {
        let candidates = settings.cem.drawn();
        if ranking_loops(&settings.cem) > gpu.loops().into() {
            return Err(GpuError::Capacity(format!(
                "{} does not rank {candidates} candidates to the end: its driver ends long loops; use fewer candidates, a \
                 smaller elite_fraction, or --backend cpu",
                gpu.report().name
            )));
        }
        let width = world.dimensions();
        let population = Population::new(gpu, kernels, world, settings, stream)?;
        let funnel = Funnel::new(gpu, kernels, world, settings, &population, gpu.room())?;
        let timer = funnel.timer(gpu);
        Ok(Self {
            gpu,
            kernels,
            world: world.clone(),
            first_capacities: world.capacities,
            settings,
            stream,
            population,
            funnel,
            split: gpu.room().split,
            too_slow: f64::INFINITY,
            paces: Default::default(),
            iteration: 0,
            distribution: settings.cem.initial(world.units.len()),
            flags: Download::new(gpu, "flags", 1),
            stats: Download::new(gpu, "stats", 1),
            mean: Download::new(gpu, "mean", width),
            std: Download::new(gpu, "std", width),
            timer,
        })
    }

    /// Simulates the placed candidates, and tells how many failed, by reason.
    fn simulate(&mut self) -> Result<Flags, GpuError> {
        let Self { gpu, population, funnel, timer, .. } = self;
        let recorder = Recorder::timed(gpu, timer.as_ref());
        let mut recorder = funnel.run(gpu, population, recorder, &mut self.paces)?;
        population.flag(&mut recorder);
        recorder.fetch(&population.flags, &self.flags);
        recorder.fetch_times();
        recorder.submit();
        let flags = self.flags.take(gpu)?[0];
        timer.as_ref().map_or(Ok(()), |timer| timer.collect(gpu))?;
        Ok(flags)
    }

    /// Makes more room where some candidate had too little; false if that is not wanted any more.
    fn grow(&mut self, flags: Flags) -> Result<bool, GpuError> {
        let mut faults = Status::default();
        for (fault, _) in Status::FAULTS.iter().zip(flags.counts).filter(|(_, count)| *count > 0) {
            faults.insert(fault.bit);
        }
        let Some(capacities) = grown(self.world.capacities, self.first_capacities, faults) else { return Ok(false) };
        self.world.capacities = capacities;
        self.remake()?;
        Ok(true)
    }

    /// Simulates half as many candidates at a time from now on if a substep of them takes too long for a watchdog, and
    /// the last halving, if any, helped.
    fn hurry(&mut self) -> Result<(), GpuError> {
        let Some(seconds) = self.paces[0].too_slow().filter(|_| self.gpu.is_watched()) else { return Ok(()) };
        self.paces = Default::default();
        self.too_slow = if seconds < HELPED * self.too_slow { seconds } else { 0.0 };
        if self.too_slow == 0.0 || self.funnel.at_once() == 1 {
            return Ok(());
        }
        self.split *= 2;
        self.remake()
    }

    /// Makes the simulation anew, for the present capacities.
    fn remake(&mut self) -> Result<(), GpuError> {
        let room = Room { split: self.split, ..self.gpu.room() };
        self.funnel = Funnel::new(self.gpu, self.kernels, &self.world, self.settings, &self.population, room)?;
        if let Some(timer) = &self.timer {
            self.funnel.announce(timer);
        }
        Ok(())
    }

    /// Candidates that are simulated at a time.
    pub fn at_once(&self) -> u32 {
        self.funnel.at_once()
    }

    /// Places and simulates one candidate alone, which gives the same bits: its poses at placement and at the end.
    fn replay(&self, delta: &[f32]) -> Result<[Vec<Pose>; 2], GpuError> {
        let Self { gpu, kernels, world, settings, stream, .. } = self;
        let cem = CemSettings { candidates: 1, draws: 1, ..settings.cem.clone() };
        let settings = SearchSettings { cem, ..(*settings).clone() };
        let population = Population::new(gpu, kernels, world, &settings, *stream)?;
        let simulation = Simulation::fitting(gpu, kernels, world, &settings.simulation, 1, gpu.room())?;
        population.deltas.upload(gpu, delta);
        let mut recorder = Recorder::new(gpu);
        population.place(&mut recorder);
        recorder.copy(&population.placed, &simulation.state.poses);
        simulation.run(gpu, recorder, &mut Pace::default(), settings.simulation.steps)?.submit();
        let bodies = world.bodies.len();
        Ok([self.read(&population.placed, 0, bodies)?, self.read(&simulation.state.poses, 0, bodies)?])
    }

    fn read<T: Pod>(&self, buffer: &super::Buffer<T>, first: usize, len: usize) -> Result<Vec<T>, GpuError> {
        let download = Download::new(self.gpu, "read", len);
        let mut recorder = Recorder::new(self.gpu);
        recorder.fetch_range(buffer, first, &download);
        recorder.submit();
        download.take(self.gpu)
    }

    fn winner(&self) -> Result<Option<Best>, GpuError> {
        let Winner { energy, iteration, candidate } = match self.read(&self.population.winner, 0, 1)?[0] {
            winner if winner.is_known() => winner,
            _ => return Ok(None),
        };
        let width = self.world.dimensions();
        let delta = self.read(&self.population.deltas, self.settings.cem.drawn() as usize * width, width)?;
        let [placed, settled] = self.replay(&delta)?;
        Ok(Some(Best { energy, iteration, candidate, delta, placed, settled }))
    }
}

impl Search for GpuSearch<'_> {
    fn iterate(&mut self) -> Result<IterationStats, BackendError> {
        if self.world.dimensions() == 0 || self.settings.cem.candidates == 0 {
            return Err(BackendError::Capacity("nothing to search: no unit or no candidate".into()));
        }
        self.gpu.count_request();
        self.hurry()?;
        self.population.set_iteration(self.gpu, self.iteration);
        let mut recorder = Recorder::timed(self.gpu, self.timer.as_ref());
        self.population.draw(&mut recorder);
        recorder.submit();
        let mut flags = self.simulate()?;
        while self.grow(flags)? {
            flags = self.simulate()?;
        }
        let mut recorder = Recorder::timed(self.gpu, self.timer.as_ref());
        self.population.rank(&mut recorder);
        recorder.fetch(&self.population.stats, &self.stats);
        recorder.fetch(&self.population.mean, &self.mean);
        recorder.fetch(&self.population.std, &self.std);
        recorder.fetch_times();
        recorder.submit();
        let Stats { best, iteration_best, elite_mean } = self.stats.take(self.gpu)?[0];
        self.distribution = Distribution { mean: self.mean.take(self.gpu)?, std: self.std.take(self.gpu)? };
        self.timer.as_ref().map_or(Ok(()), |timer| timer.collect(self.gpu))?;
        let stats = IterationStats {
            iteration: self.iteration,
            best,
            iteration_best,
            elite_mean,
            flagged: flags.counts,
            steps: self.settings.steps(),
        };
        self.iteration += 1;
        Ok(stats)
    }

    fn kernel_times(&self) -> Vec<KernelTime> {
        self.timer.as_ref().map(Timer::times).unwrap_or_default()
    }

    fn energies(&self) -> Result<Vec<Energy>, BackendError> {
        Ok(self.read(&self.population.energies, 0, self.settings.cem.drawn() as usize)?)
    }

    fn distribution(&self) -> Distribution {
        self.distribution.clone()
    }

    fn set_distribution(&mut self, distribution: &Distribution) {
        self.distribution.clone_from(distribution);
        self.population.set_distribution(self.gpu, distribution);
    }

    fn placed(&self, candidate: u32) -> Result<Vec<Pose>, BackendError> {
        let bodies = self.world.bodies.len();
        Ok(self.read(&self.population.placed, candidate as usize * bodies, bodies)?)
    }

    fn best(&mut self) -> Result<Option<Best>, BackendError> {
        self.gpu.count_request();
        Ok(self.winner()?)
    }
}
