//! The rounds of an iteration: which candidates are simulated and for how long, and how they come to the simulation and
//! back.
//!
//! The first round takes all candidates in their order, by copies; the others take those of the first ranks, by
//! kernels.

use super::Buffer;
use super::device::{Gpu, GpuError};
use super::kernel::{Recorder, Step};
use super::kernels::{self, Kernels};
use super::layout::Portion;
use super::plan::{self, Room};
use super::population::Population;
use super::simulation::{Pace, Simulation};
use super::timer::Timer;
use crate::world::{Round, SearchSettings, World};

/// How the candidates of some ranks come to a simulation and back.
struct Handover {
    gather: [Step; 1],
    scatter: [Step; 1],
}

/// What simulates the candidates of a search.
pub struct Funnel {
    rounds: Vec<Round>,
    simulation: Simulation,
    /// For the last round, where that is smaller.
    last: Option<Simulation>,
    /// Of every round but the first, as many as it takes.
    handovers: Vec<Vec<Handover>>,
}

impl Funnel {
    /// Makes all buffers: for as many candidates at a time as there is room for beside `population`.
    ///
    /// # Errors
    /// If not even one candidate fits, or the device failed.
    pub fn new(
        gpu: &Gpu,
        kernels: &Kernels,
        world: &World,
        settings: &SearchSettings,
        population: &Population,
        room: Room,
    ) -> Result<Self, GpuError> {
        let simulation = &settings.simulation;
        let rounds = settings.rounds();
        let (at_once, last) = plan::at_once(world, settings, room);
        let make = |candidates| Simulation::new(gpu, kernels, world, simulation, candidates);
        let mut funnel =
            Self { rounds, simulation: make(at_once)?, last: last.map(make).transpose()?, handovers: Vec::new() };
        for round in 1..funnel.rounds.len() {
            let simulation = funnel.simulation(round);
            let handover = |portion| handover(gpu, kernels, population, simulation, portion);
            let handovers: Vec<Handover> = funnel.portions(round).map(handover).collect::<Result<_, _>>()?;
            funnel.handovers.push(handovers);
        }
        Ok(funnel)
    }

    /// Candidates that are simulated at a time, in the first round.
    pub fn at_once(&self) -> u32 {
        self.simulation.candidates
    }

    /// The kernels between the rounds.
    pub fn kernels(&self) -> impl Iterator<Item = &Step> {
        self.handovers.iter().flatten().flat_map(|Handover { gather, scatter }| gather.iter().chain(scatter))
    }

    fn simulation(&self, round: usize) -> &Simulation {
        self.last.as_ref().filter(|_| round + 1 == self.rounds.len()).unwrap_or(&self.simulation)
    }

    /// What is simulated at a time in a round.
    fn portions(&self, round: usize) -> impl Iterator<Item = Portion> + use<> {
        let (all, at_once) = (self.rounds[round].candidates, self.simulation(round).candidates);
        (0..all).step_by(at_once as usize).map(move |first| Portion { first, count: (all - first).min(at_once) })
    }

    /// Simulates the drawn candidates of `population`, and ranks them after each round but the last. `paces`: of most
    /// rounds, and of a smaller last one.
    ///
    /// # Errors
    /// If the device failed.
    pub fn run<'g>(
        &self,
        gpu: &'g Gpu,
        population: &Population,
        mut recorder: Recorder<'g>,
        [pace, last]: &mut [Pace; 2],
    ) -> Result<Recorder<'g>, GpuError> {
        for (round, Round { steps, .. }) in self.rounds.iter().enumerate() {
            let simulation = self.simulation(round);
            let Some(before) = round.checked_sub(1) else {
                for portion in self.portions(round) {
                    population.hand_over(&mut recorder, &simulation.state, portion);
                    recorder = simulation.run(gpu, recorder, pace, *steps)?;
                    population.take_back(&mut recorder, &simulation.state, portion);
                }
                continue;
            };
            population.choose(&mut recorder);
            let is_small = self.last.is_some() && round + 1 == self.rounds.len();
            let pace = if is_small { &mut *last } else { &mut *pace };
            for Handover { gather, scatter } in &self.handovers[before] {
                recorder.run(gather);
                recorder = simulation.run(gpu, recorder, pace, *steps)?;
                recorder.run(scatter);
            }
        }
        Ok(recorder)
    }

    /// A timer for an iteration; none where the adapter has no timestamps.
    pub(super) fn timer(&self, gpu: &Gpu) -> Option<Timer> {
        self.simulation.timer(gpu, self.units())
    }

    /// Tells a timer how much there will be to time.
    pub(super) fn announce(&self, timer: &Timer) {
        self.simulation.announce(timer, self.units());
    }

    fn units(&self) -> u32 {
        let of = |(round, Round { steps, .. }): (usize, &Round)| {
            self.simulation.units(*steps).saturating_mul(self.portions(round).count() as u32)
        };
        self.rounds.iter().enumerate().map(of).fold(0, u32::saturating_add)
    }
}

fn handover(
    gpu: &Gpu,
    kernels: &Kernels,
    all: &Population,
    simulation: &Simulation,
    portion: Portion,
) -> Result<Handover, GpuError> {
    let state = &simulation.state;
    let bodies = (state.poses.len() / state.statuses.len().max(1)) as u32;
    let at = Buffer::from_slice(gpu, "portion", &[portion])?;
    let gather = kernels::GatherBuffers {
        batch: all.batch.uniform(),
        portion: at.uniform(),
        order: all.order.read(),
        placed: all.placed.read(),
        poses: state.poses.write(),
    };
    let scatter = kernels::ScatterBuffers {
        batch: all.batch.uniform(),
        portion: at.uniform(),
        order: all.order.read(),
        poses: state.poses.read(),
        snapshot: state.snapshot.read(),
        depths_placed: state.depths_placed.read(),
        depths_settled: state.depths_settled.read(),
        statuses: state.statuses.read(),
        all_poses: all.poses.write(),
        all_snapshots: all.snapshot.write(),
        all_depths_placed: all.depths_placed.write(),
        all_depths_settled: all.depths_settled.write(),
        all_statuses: all.statuses.write(),
    };
    Ok(Handover {
        gather: [gather.step(gpu, kernels, portion.count * bodies)],
        scatter: [scatter.step(gpu, kernels, portion.count)],
    })
}
