//! The Cross-Entropy search on the processor: sample, place, simulate, energy, elites, moments, once per iteration.
//!
//! Candidates run in parallel, each writing to its own slots, so threads cannot change the result. All buffers are made
//! at the start. Poses are not kept: the winner is simulated again when it is asked for, which gives the same bits.

use super::{
    best::best,
    elites::elites,
    energy::{Trial, energy},
    moments::moments,
    place::place,
    sample::sample,
    stats::{elite_mean, flags},
};
use crate::world::{
    BackendError, Best, Distribution, Energy, IterationStats, Pose, Search, SearchSettings, Status, Stream, Velocity,
    Winner, World,
};
use rayon::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The simulator as the search needs it: one candidate, from placement to rest.
pub trait Rollout: Sync {
    /// Buffers that one thread reuses for all its candidates. What they hold must not change a result.
    type Scratch: Send;

    /// Makes the buffers of one thread.
    fn scratch(&self) -> Self::Scratch;

    /// Simulates from `placed` (one pose a body), at rest at first, and fills `record`.
    fn run(&self, scratch: &mut Self::Scratch, placed: &[Pose], record: &mut Record) -> Status;
}

/// What a rollout writes.
#[derive(Clone, Debug)]
pub struct Record {
    /// Pose of every body after the last step.
    pub settled: Vec<Pose>,
    /// Velocity of every body after step τ.
    pub snapshot: Vec<Velocity>,
    /// Deepest overlap of every pair of `World::pairs` at placement, m.
    pub depths_placed: Vec<f32>,
    /// The same after the last step.
    pub depths_settled: Vec<f32>,
}

/// Buffers of one thread.
struct Lane<S> {
    scratch: S,
    placed: Vec<Pose>,
    record: Record,
}

/// About how many bytes a search holds: numbers for every candidate, simulation slots for every thread.
pub fn bytes(world: &World, candidates: u32) -> u64 {
    let row = 4 * world.dimensions() + size_of::<Energy>() + size_of::<Status>() + 8;
    (u64::from(candidates) + 1) * row as u64 + rayon::current_num_threads() as u64 * world.slot_bytes()
}

/// A search over the units of one world with any simulator.
pub struct CpuSearch<'a, R: Rollout> {
    world: &'a World,
    settings: &'a SearchSettings,
    stream: Stream,
    rollout: R,
    lanes: Vec<Mutex<Lane<R::Scratch>>>,
    /// One row a candidate, and one for the winner.
    deltas: Vec<f32>,
    energies: Vec<Energy>,
    statuses: Vec<Status>,
    order: Vec<u32>,
    elites: Vec<u32>,
    distribution: Distribution,
    floor: Vec<f32>,
    iteration: u32,
    winner: Winner,
}

impl<'a, R: Rollout> CpuSearch<'a, R> {
    /// Prepares all buffers: one lane a thread, one slot a candidate.
    pub fn new(world: &'a World, settings: &'a SearchSettings, stream: Stream, rollout: R) -> Self {
        let candidates = settings.cem.candidates as usize;
        let bodies = world.bodies.len();
        let lane = || Lane {
            scratch: rollout.scratch(),
            placed: world.start.clone(),
            record: Record {
                settled: world.start.clone(),
                snapshot: vec![Velocity::default(); bodies],
                depths_placed: vec![0.0; world.pairs.len()],
                depths_settled: vec![0.0; world.pairs.len()],
            },
        };
        let lanes = (0..rayon::current_num_threads()).map(|_| Mutex::new(lane())).collect();
        let distribution = settings.cem.initial(world.units.len());
        let floor = distribution.std.iter().map(|std| settings.cem.std_floor * std).collect();
        Self {
            world,
            settings,
            stream,
            lanes,
            rollout,
            deltas: vec![0.0; (candidates + 1) * world.dimensions()],
            energies: vec![Winner::NONE.energy; candidates],
            statuses: vec![Status::default(); candidates],
            order: vec![0; candidates],
            elites: Vec::with_capacity(candidates),
            distribution,
            floor,
            iteration: 0,
            winner: Winner::NONE,
        }
    }

    fn simulate_all(&mut self) {
        let width = self.world.dimensions();
        let Self { world, settings, stream, rollout, lanes, distribution, iteration, .. } = self;
        let slots = self.energies.par_iter_mut().zip(self.statuses.par_iter_mut()).enumerate();
        let rows = &mut self.deltas[..slots.len() * width];
        slots.zip(rows.par_chunks_exact_mut(width)).for_each(|((candidate, (cost, status)), delta)| {
            sample(&distribution.mean, &distribution.std, *stream, *iteration, candidate as u32, delta);
            if candidate == 0 && settings.cem.sample_mean {
                delta.copy_from_slice(&distribution.mean);
            }
            let lane = &mut *lock(&lanes[rayon::current_thread_index().unwrap_or(0) % lanes.len()]);
            (*cost, *status) = lane.evaluate(world, settings, rollout, delta);
        });
    }
}

impl<S> Lane<S> {
    fn evaluate<R: Rollout<Scratch = S>>(
        &mut self,
        world: &World,
        settings: &SearchSettings,
        rollout: &R,
        delta: &[f32],
    ) -> (Energy, Status) {
        place(world, delta, &mut self.placed);
        let status = rollout.run(&mut self.scratch, &self.placed, &mut self.record);
        let trial = Trial {
            placed: &self.placed,
            settled: &self.record.settled,
            snapshot: &self.record.snapshot,
            depths_placed: &self.record.depths_placed,
            depths_settled: &self.record.depths_settled,
            status,
        };
        (energy(world, &settings.energy, &trial), status)
    }
}

/// A lane whose thread panicked is as good as any: every rollout overwrites it.
fn lock<T>(lane: &Mutex<T>) -> MutexGuard<'_, T> {
    lane.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<R: Rollout> Search for CpuSearch<'_, R> {
    fn iterate(&mut self) -> Result<IterationStats, BackendError> {
        let width = self.world.dimensions();
        if width == 0 || self.energies.is_empty() {
            return Err(BackendError::Capacity("nothing to search: no unit or no candidate".into()));
        }
        self.simulate_all();

        let wanted = self.settings.cem.elite_count() as usize;
        let usable = elites(&self.energies, wanted, &mut self.order);
        best(
            &self.energies,
            (&self.order, usable),
            wanted,
            self.iteration,
            &mut self.deltas,
            &mut self.winner,
            &mut self.elites,
        );
        moments(
            &self.deltas,
            &self.elites,
            self.settings.cem.std_epsilon,
            &self.floor,
            &mut self.distribution.mean,
            &mut self.distribution.std,
        );

        let stats = IterationStats {
            iteration: self.iteration,
            best: self.winner.energy,
            iteration_best: self.energies[self.order[0] as usize].total,
            elite_mean: elite_mean(&self.energies, &self.elites, &self.winner),
            flagged: flags(&self.statuses),
        };
        self.iteration += 1;
        Ok(stats)
    }

    fn energies(&self) -> Vec<Energy> {
        self.energies.clone()
    }

    fn distribution(&self) -> Distribution {
        self.distribution.clone()
    }

    fn set_distribution(&mut self, distribution: &Distribution) {
        self.distribution.clone_from(distribution);
    }

    fn placed(&self, candidate: u32) -> Vec<Pose> {
        let width = self.world.dimensions();
        let mut placed = self.world.start.clone();
        place(self.world, &self.deltas[candidate as usize * width..][..width], &mut placed);
        placed
    }

    fn best(&mut self) -> Option<Best> {
        let Winner { energy, iteration, candidate } = Some(self.winner).filter(Winner::is_known)?;
        let delta = self.deltas[self.energies.len() * self.world.dimensions()..].to_vec();
        let mut lane = lock(&self.lanes[0]);
        lane.evaluate(self.world, self.settings, &self.rollout, &delta);
        Some(Best {
            energy,
            iteration,
            candidate,
            delta,
            placed: lane.placed.clone(),
            settled: lane.record.settled.clone(),
        })
    }
}
