//! The simulation of a batch: substep after substep of collision detection and solver, in submissions short enough for
//! the watchdogs of desktops.

use super::buffer::Buffer;
use super::collide::{Collide, Motion};
use super::contacts::{Contacts, Inputs};
use super::device::{Gpu, GpuError};
use super::kernel::{Recorder, Step};
use super::kernels::Kernels;
use super::layout::{Batch, Body, Pose, Velocity};
use super::plan::{self, Room};
use super::solver::{Solver, Touching, Way};
use super::tables::Tables;
use super::timer::Timer;
use crate::world::constants::MAX_CAPACITY_GROWTH;
use crate::world::{Capacities, SimSettings, Status, World};
use std::time::Instant;

/// Passes of a substep: collision, contacts, solver.
const PASSES: u32 = 3;

/// So many submissions of one substep that take too long, one after the other, are no accident.
const SLOW: u32 = 8;

/// How many substeps are submitted together, by measured time.
#[derive(Debug)]
pub struct Pace {
    substeps: u32,
    recorded: u32,
    /// Submissions of one substep that took too long, one after the other.
    slow: u32,
    /// What a substep took where so many did, s.
    too_slow: Option<f64>,
}

impl Default for Pace {
    fn default() -> Self {
        Self { substeps: 1, recorded: 0, slow: 0, too_slow: None }
    }
}

impl Pace {
    /// Notes one more substep; submits and waits when there are enough.
    pub(super) fn tick<'g>(&mut self, gpu: &'g Gpu, recorder: Recorder<'g>) -> Result<Recorder<'g>, GpuError> {
        self.recorded += 1;
        if self.recorded < self.substeps {
            return Ok(recorder);
        }
        let clock = Instant::now();
        let next = recorder.next();
        gpu.wait()?;
        let (wanted, taken) = (gpu.submission().as_secs_f64(), clock.elapsed().as_secs_f64());
        let is_slow = self.recorded == 1 && taken > wanted;
        self.slow = if is_slow { self.slow + 1 } else { 0 };
        if self.slow >= SLOW {
            self.too_slow = Some(taken);
        }
        let fit = wanted / taken.max(1e-6) * f64::from(self.recorded);
        // Halfway in between, because the last one may have been a lucky one.
        self.substeps = ((fit as u32).saturating_add(self.substeps) / 2).max(1);
        self.recorded = 0;
        Ok(next)
    }

    /// Seconds that a substep took, if again and again not even one was done in time.
    pub(super) fn too_slow(&self) -> Option<f64> {
        self.too_slow
    }
}

/// Twice the room for what `faults` names, up to the limit; none if that changes nothing.
pub fn grown(now: Capacities, first: Capacities, faults: Status) -> Option<Capacities> {
    let more = |bit, now: u32, first: u32| {
        let twice = now.saturating_mul(2);
        let wanted = faults.intersects(bit) && twice <= first.saturating_mul(MAX_CAPACITY_GROWTH);
        if wanted { twice } else { now }
    };
    let grown = Capacities {
        hull_pairs: more(Status::HULL_PAIRS, now.hull_pairs, first.hull_pairs),
        contacts: more(Status::CONTACTS, now.contacts, first.contacts),
    };
    Some(grown).filter(|grown| *grown != now)
}

/// What a simulation moves. Tables are candidate-major.
pub struct State {
    /// Sizes of the tables.
    pub batch: Buffer<Batch>,
    /// `[bodies]`
    pub bodies: Buffer<Body>,
    /// `[candidates][bodies]`
    pub poses: Buffer<Pose>,
    /// `[candidates][bodies]`
    pub velocities: Buffer<Velocity>,
    /// Velocities of step τ, `[candidates][bodies]`
    pub snapshot: Buffer<Velocity>,
    /// Deepest overlaps at placement, `[candidates][pairs]`, m.
    pub depths_placed: Buffer<f32>,
    /// The same at the end.
    pub depths_settled: Buffer<f32>,
    /// Bits of `world::Status`, `[candidates]`
    pub statuses: Buffer<u32>,
}

impl State {
    fn new(gpu: &Gpu, world: &World, candidates: u32) -> Result<Self, GpuError> {
        let [rows, depths] = [world.bodies.len(), world.pairs.len()].map(|n| candidates as usize * n);
        Ok(Self {
            batch: Buffer::from_slice(gpu, "batch", &[Batch::new(world, candidates)])?,
            bodies: Buffer::from_slice(gpu, "bodies", &world.bodies)?,
            poses: Buffer::new(gpu, "poses", rows)?,
            velocities: Buffer::new(gpu, "velocities", rows)?,
            snapshot: Buffer::new(gpu, "snapshot", rows)?,
            depths_placed: Buffer::new(gpu, "depths_placed", depths)?,
            depths_settled: Buffer::new(gpu, "depths_settled", depths)?,
            statuses: Buffer::new(gpu, "statuses", candidates as usize)?,
        })
    }
}

/// Simulates so many candidates at a time.
pub struct Simulation {
    /// How many.
    pub candidates: u32,
    /// What moves.
    pub state: State,
    /// Its parts, in the order in which they work.
    pub collide: Collide,
    /// Contacts, found anew or carried over.
    pub contacts: Contacts,
    /// What turns them into motion.
    pub solver: Solver,
    steps: u32,
    substeps: u32,
    snapshot_step: u32,
}

impl Simulation {
    /// For at most `candidates` at a time: as many as there is room for.
    ///
    /// # Errors
    /// If not even one candidate fits, or the device failed.
    pub fn fitting(
        gpu: &Gpu,
        kernels: &Kernels,
        world: &World,
        settings: &SimSettings,
        candidates: u32,
        room: Room,
    ) -> Result<Self, GpuError> {
        Self::new(gpu, kernels, world, settings, plan::fitting(world, candidates, 0, room))
    }

    /// For so many at a time.
    pub(super) fn new(
        gpu: &Gpu,
        kernels: &Kernels,
        world: &World,
        settings: &SimSettings,
        candidates: u32,
    ) -> Result<Self, GpuError> {
        let tables = Tables::new(gpu, world, settings)?;
        let state = State::new(gpu, world, candidates)?;
        let motion = Motion {
            batch: &state.batch,
            bodies: &state.bodies,
            poses: &state.poses,
            velocities: &state.velocities,
            statuses: &state.statuses,
        };
        let collide = Collide::new(gpu, kernels, world, settings, &tables, motion)?;
        let inputs = Inputs {
            batch: &state.batch,
            bodies: &state.bodies,
            poses: &state.poses,
            velocities: &state.velocities,
            body_boxes: &collide.body_boxes,
            hull_pairs: collide.hull_pairs.each_ref(),
            pair_starts: collide.pair_starts.each_ref(),
            separations: &collide.separations,
            statuses: &state.statuses,
        };
        let contacts = Contacts::new(gpu, kernels, world, candidates, &tables, &inputs)?;
        let touching = [0, 1].map(|parity| Touching {
            counts: &contacts.patch_counts[parity],
            patches: &contacts.patches[parity],
            contacts: &contacts.points[parity],
        });
        let (sizes, sim) = ([candidates, world.bodies.len() as u32], (&tables.parameters, &tables.sim));
        let solver = Solver::new(gpu, kernels, sizes, sim, Way::best(gpu), motion, touching)?;
        let SimSettings { steps, snapshot_step, .. } = *settings;
        let substeps = settings.substeps.max(1);
        Ok(Self { candidates, state, collide, contacts, solver, steps, substeps, snapshot_step })
    }

    /// Everything is at rest at the present poses, and nothing went wrong yet.
    pub fn rest(&self, recorder: &mut Recorder<'_>) {
        recorder.clear(&self.state.velocities);
        recorder.clear(&self.state.statuses);
        self.collide.reset(recorder);
        self.contacts.reset(recorder);
    }

    /// One substep, `number` counted from the last `rest`.
    pub fn substep(&self, recorder: &mut Recorder<'_>, number: u32) {
        let parity = number as usize % 2;
        self.collide.detect(recorder, parity);
        self.contacts.record(recorder, parity);
        if number == 0 {
            recorder.run_once(self.solver.load_steps());
        }
        self.solver.solve(recorder, parity);
    }

    /// The kernels of a substep of this parity, in their order.
    pub fn kernels(&self, parity: usize) -> impl Iterator<Item = &Step> {
        self.collide.steps(parity).iter().chain(self.contacts.steps(parity)).chain(self.solver.steps(parity))
    }

    /// Those that find what contacts carry in the first one.
    pub fn load_kernels(&self) -> &[Step] {
        self.solver.load_steps()
    }

    /// Those that measure overlaps.
    pub fn measuring_kernels(&self) -> &[Step] {
        self.collide.measuring_steps()
    }

    /// Deepest overlaps at the present poses, into `State::depths_placed`.
    pub fn overlaps(&self, recorder: &mut Recorder<'_>) {
        self.collide.measure(recorder, &self.state.depths_placed);
    }

    /// So many steps from the present poses, with what the energy needs. The work is done when this returns, but for
    /// what is still in the recorder that it gives back.
    ///
    /// # Errors
    /// If the device failed.
    pub fn run<'g>(
        &self,
        gpu: &'g Gpu,
        mut recorder: Recorder<'g>,
        pace: &mut Pace,
        steps: u32,
    ) -> Result<Recorder<'g>, GpuError> {
        self.rest(&mut recorder);
        recorder.begin_unit();
        self.overlaps(&mut recorder);
        if steps == 0 {
            recorder.end_units();
            recorder.clear(&self.state.snapshot);
            recorder.copy(&self.state.depths_placed, &self.state.depths_settled);
            return pace.tick(gpu, recorder);
        }
        for substep in 0..steps * self.substeps {
            recorder.begin_unit();
            self.substep(&mut recorder, substep);
            if substep + 1 == self.snapshot_step * self.substeps {
                recorder.copy(&self.state.velocities, &self.state.snapshot);
            }
            recorder = pace.tick(gpu, recorder)?;
        }
        recorder.begin_unit();
        self.collide.measure(&mut recorder, &self.state.depths_settled);
        recorder.end_units();
        Ok(recorder)
    }

    /// The steps, substep by substep and without overlaps; `after_step` records what is wanted of each. The work is
    /// done as with `run`.
    ///
    /// # Errors
    /// If the device failed.
    pub fn steps<'g>(
        &self,
        gpu: &'g Gpu,
        mut recorder: Recorder<'g>,
        pace: &mut Pace,
        mut after_step: impl FnMut(&mut Recorder<'g>, usize),
    ) -> Result<Recorder<'g>, GpuError> {
        self.rest(&mut recorder);
        for step in 0..self.steps {
            for substep in step * self.substeps..(step + 1) * self.substeps {
                recorder.begin_unit();
                self.substep(&mut recorder, substep);
                recorder = pace.tick(gpu, recorder)?;
            }
            after_step(&mut recorder, step as usize);
        }
        recorder.end_units();
        Ok(recorder)
    }

    /// Points of contact that the last substep made, `[candidates]`.
    pub fn point_counts(&self) -> &Buffer<u32> {
        &self.contacts.point_counts
    }

    /// Units of work of so many steps, for a timer.
    pub(super) fn units(&self, steps: u32) -> u32 {
        if steps == 0 { 1 } else { steps * self.substeps + 2 }
    }

    /// A timer for so many units, none where the adapter has no timestamps.
    pub(super) fn timer(&self, gpu: &Gpu, units: u32) -> Option<Timer> {
        let timer = Timer::new(gpu)?;
        self.announce(&timer, units);
        Some(timer)
    }

    /// Tells a timer how much there will be to time.
    pub(super) fn announce(&self, timer: &Timer, units: u32) {
        timer.expect([units, self.kernels(0).count() as u32, PASSES]);
    }
}
