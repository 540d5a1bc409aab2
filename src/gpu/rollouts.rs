//! Rollouts of a population without a search around them: what `bench` measures.

use super::buffer::{Buffer, Download};
use super::device::{Gpu, GpuError};
use super::kernel::Recorder;
use super::kernels::Kernels;
use super::simulation::{Pace, Simulation, grown};
use super::timer::Timer;
use crate::world::{KernelTime, Pose, Rollouts, SimSettings, Status, World};

/// A population on the device: as many candidates at a time as fit, with what comes back of them.
struct Rig {
    simulation: Simulation,
    /// Contact points after each step, `[steps][candidates]`.
    tallies: Buffer<u32>,
    poses: Download<Pose>,
    statuses: Download<u32>,
    counted: Download<u32>,
}

impl Rig {
    fn new(
        gpu: &Gpu,
        kernels: &Kernels,
        world: &World,
        settings: &SimSettings,
        candidates: usize,
    ) -> Result<Self, GpuError> {
        let simulation = Simulation::fitting(gpu, kernels, world, settings, candidates as u32, gpu.room())?;
        let at_once = simulation.candidates as usize;
        let tallies = settings.steps as usize * at_once;
        Ok(Self {
            simulation,
            tallies: Buffer::new(gpu, "tallies", tallies)?,
            poses: Download::new(gpu, "poses", at_once * world.bodies.len()),
            statuses: Download::new(gpu, "statuses", at_once),
            counted: Download::new(gpu, "tallies", tallies),
        })
    }

    /// Simulates all candidates; their poses and statuses, and the sum of all tallies.
    fn run(
        &self,
        gpu: &Gpu,
        bodies: usize,
        starts: &[Pose],
        timer: Option<&Timer>,
    ) -> Result<(Vec<Pose>, Vec<Status>, u64), GpuError> {
        let Self { simulation, tallies, poses, statuses, counted } = self;
        let at_once = simulation.candidates as usize;
        let mut pace = Pace::default();
        let (mut settled, mut faults, mut contacts) = (Vec::with_capacity(starts.len()), Vec::new(), 0);
        for chunk in starts.chunks(at_once * bodies) {
            let count = chunk.len() / bodies;
            simulation.state.poses.upload(gpu, chunk);
            let recorder = Recorder::timed(gpu, timer);
            let mut recorder = simulation.steps(gpu, recorder, &mut pace, |recorder, step| {
                recorder.copy_range((simulation.point_counts(), 0), (tallies, step * at_once), at_once);
            })?;
            recorder.fetch(&simulation.state.poses, poses);
            recorder.fetch(&simulation.state.statuses, statuses);
            recorder.fetch(tallies, counted);
            recorder.submit();
            settled.extend_from_slice(&poses.take(gpu)?[..chunk.len()]);
            faults.extend(statuses.take(gpu)?[..count].iter().map(|bits| Status(*bits)));
            let counts = counted.take(gpu)?;
            contacts += counts.chunks(at_once).flat_map(|step| &step[..count]).map(|&n| u64::from(n)).sum::<u64>();
        }
        Ok((settled, faults, contacts))
    }
}

/// Simulates every candidate to its end; where there was too little room, all of them again with more.
pub(super) fn rollouts(
    gpu: &Gpu,
    kernels: &Kernels,
    world: &World,
    settings: &SimSettings,
    starts: &[Pose],
) -> Result<Rollouts, GpuError> {
    if starts.is_empty() || world.bodies.is_empty() {
        return Ok(Rollouts { settled: Vec::new(), statuses: Vec::new(), contacts_per_substep: None });
    }
    let bodies = world.bodies.len();
    let candidates = starts.len() / bodies;
    let mut roomy = world.clone();
    loop {
        let rig = Rig::new(gpu, kernels, &roomy, settings, candidates)?;
        let (settled, statuses, contacts) = rig.run(gpu, bodies, starts, None)?;
        let mut faults = Status::default();
        statuses.iter().for_each(|status| faults.insert(*status));
        let Some(capacities) = grown(roomy.capacities, world.capacities, faults) else {
            let counted = candidates as f64 * f64::from(settings.steps);
            let contacts_per_substep = Some(contacts as f64 / counted.max(1.0));
            return Ok(Rollouts { settled, statuses, contacts_per_substep });
        };
        roomy.capacities = capacities;
    }
}

/// Times the kernels over all candidates; empty where the adapter has no timestamps.
pub(super) fn kernel_times(
    gpu: &Gpu,
    kernels: &Kernels,
    world: &World,
    settings: &SimSettings,
    starts: &[Pose],
) -> Result<Vec<KernelTime>, GpuError> {
    if starts.is_empty() || world.bodies.is_empty() {
        return Ok(Vec::new());
    }
    let bodies = world.bodies.len();
    let candidates = starts.len() / bodies;
    let rig = Rig::new(gpu, kernels, world, settings, candidates)?;
    let rounds = candidates.div_ceil(rig.simulation.candidates as usize) as u32;
    let units = rig.simulation.units(settings.steps).saturating_mul(rounds);
    let Some(timer) = rig.simulation.timer(gpu, units) else { return Ok(Vec::new()) };
    rig.run(gpu, bodies, starts, Some(&timer))?;
    let mut recorder = Recorder::timed(gpu, Some(&timer));
    recorder.fetch_times();
    recorder.submit();
    timer.collect(gpu)?;
    Ok(timer.times())
}
