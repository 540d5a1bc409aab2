//! The Cross-Entropy search on the processor: sample, then place, simulate, energy and elites in every round, moments,
//! once per iteration.
//!
//! Candidates run in parallel, each writing to its own slots, so threads cannot change the result. All of these are made
//! at the start. Poses are not kept: the winner is simulated again when it is asked for, which gives the same bits.
//!
//! A round needs its best candidates only. Large rounds go in waves, and what is sure to cost more than the worst of
//! the best up to then is given up, as placed or after step τ (`energy::least`): the best stay the same to the bit.

use super::{
    best::best,
    elites::elites,
    energy::{Trial, energy, least},
    group::{Group, at_once},
    moments::moments,
    place::place,
    sample::sample_candidate,
    stats::{elite_mean, flags},
};
use crate::world::{
    BackendError, Best, Distribution, Energy, IterationStats, Pose, Round, Search, SearchSettings, Status, Stream,
    Velocity, Winner, World,
};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The simulator as the search needs it: some candidates at once, from placement to rest.
pub trait Rollout: Sync {
    /// Buffers that one thread reuses for all its candidates. What they hold must not change a result, and neither must
    /// the company that a candidate runs in.
    type Scratch: Send;

    /// Most candidates of a run.
    fn at_once(&self) -> usize {
        1
    }

    /// Makes the buffers of one thread.
    fn scratch(&self) -> Self::Scratch;

    /// Simulates so many steps from `placed` (one pose a body, candidate after candidate), at rest at first, and fills
    /// the candidates' `records`. It may ask at placement (with a snapshot of noughts) and after step τ whether a
    /// candidate goes on. The record of one that does not says so by fewer `steps`, and what had gone wrong until then;
    /// else `steps` is as it was.
    fn run(
        &self,
        scratch: &mut Self::Scratch,
        placed: &[Pose],
        steps: u32,
        records: &mut [Record],
        goes_on: &GoesOn<'_>,
    );
}

/// Sees the number of a candidate among those that are run together, and its record up to now.
pub type GoesOn<'a> = dyn Fn(usize, &Record) -> bool + 'a;

/// What a rollout writes of a candidate.
#[derive(Clone, Debug)]
pub struct Record {
    /// Steps that it was simulated for.
    pub steps: u32,
    /// Pose of every body after the last step.
    pub settled: Vec<Pose>,
    /// Velocity of every body after step τ.
    pub snapshot: Vec<Velocity>,
    /// Deepest overlap of every pair of `World::pairs` at placement, m.
    pub depths_placed: Vec<f32>,
    /// The same after the last step.
    pub depths_settled: Vec<f32>,
    /// What went wrong.
    pub status: Status,
}

/// What came of a candidate.
#[derive(Clone, Copy, Debug)]
struct Found {
    energy: Energy,
    status: Status,
    /// Steps that it was simulated for.
    steps: u32,
}

impl Found {
    /// Of a candidate that has not been simulated to the end.
    const NOTHING: Self = Self { energy: Winner::NONE.energy, status: Status(0), steps: 0 };
}

/// Fewest candidates of a wave (of the last one fewer), and most waves of a round. At the end of each, threads wait for
/// one another; and 64 of them are to have all of their lanes full.
const LEAST_WAVE: usize = 1024;
const MOST_WAVES: usize = 8;

/// Buffers of one thread.
struct Worker<S> {
    scratch: S,
    /// Poses of as many candidates as run at once.
    placed: Vec<Pose>,
    records: Vec<Record>,
}

/// About how many bytes a search holds: numbers for every candidate, simulation slots for every thread's group.
pub fn bytes(world: &World, candidates: u32) -> u64 {
    let row = 4 * world.dimensions() + size_of::<(Energy, Status)>() + size_of::<Found>() + 12;
    let slots = rayon::current_num_threads() * Group::lanes();
    (u64::from(candidates) + 1) * row as u64 + slots as u64 * world.slot_bytes()
}

/// A search over the units of one world with any simulator.
pub struct CpuSearch<'a, R: Rollout> {
    world: &'a World,
    settings: &'a SearchSettings,
    stream: Stream,
    rollout: R,
    workers: Vec<Mutex<Worker<R::Scratch>>>,
    /// One row a candidate, and one for the winner.
    deltas: Vec<f32>,
    energies: Vec<Energy>,
    statuses: Vec<Status>,
    order: Vec<u32>,
    rounds: Vec<Round>,
    /// The candidates of a round, and what came of them.
    chosen: Vec<u32>,
    found: Vec<Found>,
    /// Steps of candidates in this iteration.
    steps: u64,
    elites: Vec<u32>,
    distribution: Distribution,
    floor: Vec<f32>,
    iteration: u32,
    winner: Winner,
}

impl<'a, R: Rollout> CpuSearch<'a, R> {
    /// Prepares all buffers: one worker a thread, one slot a candidate.
    pub fn new(world: &'a World, settings: &'a SearchSettings, stream: Stream, rollout: R) -> Self {
        let candidates = settings.cem.drawn() as usize;
        let bodies = world.bodies.len();
        let record = Record {
            steps: 0,
            settled: world.start.clone(),
            snapshot: vec![Velocity::default(); bodies],
            depths_placed: vec![0.0; world.pairs.len()],
            depths_settled: vec![0.0; world.pairs.len()],
            status: Status::default(),
        };
        let worker = || Worker {
            scratch: rollout.scratch(),
            placed: world.start.repeat(rollout.at_once()),
            records: vec![record.clone(); rollout.at_once()],
        };
        let workers = (0..rayon::current_num_threads()).map(|_| Mutex::new(worker())).collect();
        let distribution = settings.cem.initial(world.units.len());
        let floor = distribution.std.iter().map(|std| settings.cem.std_floor * std).collect();
        let rounds = settings.rounds();
        Self {
            world,
            settings,
            stream,
            workers,
            rollout,
            deltas: vec![0.0; (candidates + 1) * world.dimensions()],
            energies: vec![Winner::NONE.energy; candidates],
            statuses: vec![Status::default(); candidates],
            order: vec![0; candidates],
            rounds,
            chosen: Vec::with_capacity(candidates),
            found: vec![Found::NOTHING; candidates],
            steps: 0,
            elites: Vec::with_capacity(candidates),
            distribution,
            floor,
            iteration: 0,
            winner: Winner::NONE,
        }
    }

    /// Draws all candidates.
    fn draw(&mut self) {
        let Self { world, settings, stream, distribution, iteration, .. } = self;
        let rows = self.deltas.par_chunks_exact_mut(world.dimensions()).take(self.energies.len());
        rows.enumerate().for_each(|(candidate, delta)| {
            sample_candidate(&settings.cem, distribution, (*stream, *iteration), candidate as u32, delta);
        });
    }

    /// Simulates the chosen candidates of a round in waves and ranks them; all others are out. Gives how many of the
    /// best `wanted`, which alone matter, are usable.
    fn play(&mut self, round: usize, wanted: usize) -> usize {
        self.energies.iter_mut().for_each(|energy| energy.total = f32::INFINITY);
        let steps = self.rounds[round].steps;
        let all = self.chosen.len();
        let wave = if self.settings.cem.prune && steps > 0 { all.div_ceil(MOST_WAVES).max(LEAST_WAVE) } else { all };
        let (mut usable, mut cutoff) = (0, f32::INFINITY);
        for first in (0..all).step_by(wave) {
            self.simulate(first..all.min(first + wave), steps, cutoff);
            usable = elites(&self.energies, wanted, &mut self.order);
            cutoff = self.energies[self.order[wanted - 1] as usize].total;
        }
        usable
    }

    /// Simulates some of the chosen candidates, but those that are sure to cost more than `cutoff`.
    fn simulate(&mut self, wave: Range<usize>, steps: u32, cutoff: f32) {
        let width = self.world.dimensions();
        let Self { world, settings, rollout, workers, deltas, chosen, found, .. } = self;
        let (chosen, found) = (&chosen[wave.clone()], &mut found[wave]);
        let size = at_once(chosen.len(), rollout.at_once());
        chosen.par_chunks(size).zip(found.par_chunks_mut(size)).for_each(|(chosen, found)| {
            let deltas = chosen.iter().map(|&candidate| &deltas[candidate as usize * width..][..width]);
            let worker = &mut *lock(&workers[rayon::current_thread_index().unwrap_or(0) % workers.len()]);
            let evaluated = worker.evaluate(world, settings, (rollout, steps, cutoff), deltas);
            evaluated.zip(found).for_each(|(evaluated, found)| *found = evaluated);
        });
        for (&candidate, found) in chosen.iter().zip(&*found) {
            (self.energies[candidate as usize], self.statuses[candidate as usize]) = (found.energy, found.status);
            self.steps += u64::from(found.steps);
        }
    }
}

impl<S> Worker<S> {
    /// Runs the candidates with these adjustments for so many steps, but those that are sure to cost more than a
    /// cutoff.
    fn evaluate<'d, R: Rollout<Scratch = S>>(
        &mut self,
        world: &World,
        settings: &SearchSettings,
        (rollout, steps, cutoff): (&R, u32, f32),
        deltas: impl ExactSizeIterator<Item = &'d [f32]>,
    ) -> impl Iterator<Item = Found> {
        let (bodies, candidates) = (world.bodies.len(), deltas.len());
        let (placed, records) = (&mut self.placed[..candidates * bodies], &mut self.records[..candidates]);
        for (delta, placed) in deltas.zip(placed.chunks_exact_mut(bodies)) {
            place(world, delta, placed);
        }
        records.iter_mut().for_each(|record| record.steps = steps);
        let least = |placed: &[Pose], record: &Record| {
            least(world, &settings.energy, placed, &record.snapshot, &record.depths_placed)
        };
        rollout.run(&mut self.scratch, placed, steps, records, &|number, record| {
            cutoff == f32::INFINITY || least(&placed[number * bodies..][..bodies], record) <= cutoff
        });
        records.iter().zip(placed.chunks_exact(bodies)).map(move |(record, placed)| {
            if record.steps < steps {
                return Found { status: record.status, steps: record.steps, ..Found::NOTHING };
            }
            let trial = Trial {
                placed,
                settled: &record.settled,
                snapshot: &record.snapshot,
                depths_placed: &record.depths_placed,
                depths_settled: &record.depths_settled,
                status: record.status,
            };
            Found { energy: energy(world, &settings.energy, &trial), status: record.status, steps }
        })
    }
}

/// A worker whose thread panicked is as good as any: every rollout overwrites it.
fn lock<T>(worker: &Mutex<T>) -> MutexGuard<'_, T> {
    worker.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<R: Rollout> Search for CpuSearch<'_, R> {
    fn iterate(&mut self) -> Result<IterationStats, BackendError> {
        let width = self.world.dimensions();
        if width == 0 || self.energies.is_empty() {
            return Err(BackendError::Capacity("nothing to search: no unit or no candidate".into()));
        }
        self.draw();
        let wanted = self.settings.cem.elite_count() as usize;
        let mut usable = 0;
        self.steps = 0;
        for round in 0..self.rounds.len() {
            let candidates = self.rounds[round].candidates;
            self.chosen.clear();
            match round {
                0 => self.chosen.extend(0..candidates),
                _ => self.chosen.extend_from_slice(&self.order[..candidates as usize]),
            }
            usable = self.play(round, self.rounds.get(round + 1).map_or(wanted, |next| next.candidates as usize));
        }
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
            steps: self.steps,
        };
        self.iteration += 1;
        Ok(stats)
    }

    fn energies(&self) -> Result<Vec<Energy>, BackendError> {
        Ok(self.energies.clone())
    }

    fn distribution(&self) -> Distribution {
        self.distribution.clone()
    }

    fn set_distribution(&mut self, distribution: &Distribution) {
        self.distribution.clone_from(distribution);
    }

    fn placed(&self, candidate: u32) -> Result<Vec<Pose>, BackendError> {
        let width = self.world.dimensions();
        let mut placed = self.world.start.clone();
        place(self.world, &self.deltas[candidate as usize * width..][..width], &mut placed);
        Ok(placed)
    }

    fn best(&mut self) -> Result<Option<Best>, BackendError> {
        if !self.winner.is_known() {
            return Ok(None);
        }
        let Winner { energy, iteration, candidate } = self.winner;
        let delta = self.deltas[self.energies.len() * self.world.dimensions()..].to_vec();
        let mut worker = lock(&self.workers[0]);
        let to_the_end = (&self.rollout, self.settings.simulation.steps, f32::INFINITY);
        worker.evaluate(self.world, self.settings, to_the_end, [&delta[..]].into_iter()).for_each(drop);
        Ok(Some(Best {
            energy,
            iteration,
            candidate,
            delta,
            placed: worker.placed[..self.world.bodies.len()].to_vec(),
            settled: worker.records[0].settled.clone(),
        }))
    }
}
