//! The contact solver: a substep from contacts to new poses and velocities.

use super::adapter::AdapterKind;
use super::buffer::Buffer;
use super::collide::Motion;
use super::device::{Gpu, GpuError};
use super::kernel::{Recorder, Step};
use super::kernels::{self, Kernels};
use super::layout::{Axes, Contact, Cursor, Free, Friction, Gap, Levers, Moving, Normal, Patch, Sim};
use crate::world::constants::{
    MAX_LOAD_SWEEPS, MAX_MANIFOLD_POINTS, MAX_PATCHES, MAX_PUSHING_SWEEPS, MAX_RELAXING_SWEEPS,
};

/// Invocations that share a candidate's patches, as in `solve_load` and `integrate`.
const PATCH_LANES: u32 = kernels::constants::PATCH_LANES;

/// Invocations that share a candidate's patches, as in `solve_waves`.
const WAVE_LANES: u32 = kernels::constants::WAVE_LANES;

/// How the small steps of all candidates are shared out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// An invocation a candidate, kernel `solve`: what software adapters are best at, because they have few units.
    Candidates,
    /// A workgroup a candidate, kernel `solve_waves`, and what is too large for it as above: cards have thousands of
    /// units that would wait for memory.
    Waves,
}

impl Way {
    /// The faster one of those that this adapter can go.
    pub fn best(gpu: &Gpu) -> Self {
        let is_card = gpu.report().kind != AdapterKind::Software;
        if is_card && gpu.has_waves() { Self::Waves } else { Self::Candidates }
    }
}

/// Most patches of a candidate with so many slots for contact points, as `patch_rows` in the shaders.
pub fn patch_rows(contacts: u32) -> u32 {
    contacts.div_ceil(kernels::constants::SLOTS_PER_PATCH)
}

/// How often kernel `solve` has to be run for a substep of so many bodies: it stops before its loops have gone round
/// `Sim::loops` times.
pub fn rounds(sim: &Sim, bodies: u32) -> u32 {
    let longest = 2 * (MAX_PUSHING_SWEEPS + MAX_RELAXING_SWEEPS) + sim.velocity_iterations.max(1) - 1;
    let [steps, sweeps] = portion(sim, bodies, longest.into());
    (u64::from(sim.small_steps).div_ceil(steps) * u64::from(longest).div_ceil(sweeps)) as u32
}

/// How many small steps, and how many sweeps of each, are within `Sim::loops`.
fn portion(sim: &Sim, bodies: u32, longest: u64) -> [u64; 2] {
    let points = 1 + MAX_MANIFOLD_POINTS as u64;
    let [loops, patches, bodies] = [sim.loops, patch_rows(sim.contacts), bodies].map(u64::from);
    let sweep = (1 + points) * patches + 3;
    let apart = 8 * u64::from(kernels::constants::COUNTED_TOGETHER);
    let around = (2 + (2 + apart) * points) * patches + (2 + longest) * bodies + 3;
    let steps = (loops / (around + longest * sweep)).max(1);
    [steps, (loops.saturating_sub(around) / sweep).clamp(1, longest)]
}

/// How often kernel `first_loads` has to be run, likewise.
fn load_rounds(sim: &Sim, bodies: u32) -> u32 {
    let longest = 2 * u64::from(MAX_LOAD_SWEEPS);
    longest.div_ceil(load_sweeps(sim, bodies, longest)) as u32
}

/// How many of its sweeps are within `Sim::loops`.
fn load_sweeps(sim: &Sim, bodies: u32, longest: u64) -> u64 {
    let points = MAX_MANIFOLD_POINTS as u64;
    let [loops, patches, bodies] = [sim.loops, patch_rows(sim.contacts), bodies].map(u64::from);
    let sweep = (1 + 2 * points) * patches + 1;
    let around = (2 + points + 2 * MAX_PATCHES as u64) * patches + bodies + 4;
    (loops.saturating_sub(around) / sweep).clamp(1, longest)
}

/// Contacts of a substep: tables that change roles every substep.
pub struct Touching<'a> {
    /// Patches in use, `[candidates]`.
    pub counts: &'a Buffer<u32>,
    /// `[candidates][Capacities::contacts]`
    pub patches: &'a Buffer<Patch>,
    /// `[candidates][Capacities::contacts]`; `Patch::first` counts from the candidate's first slot.
    pub contacts: &'a Buffer<Contact>,
}

/// The solver of all candidates.
pub struct Solver {
    /// `[candidates][bodies + 1]`; the last is the ground.
    pub moving: Buffer<Moving>,
    /// By contact, `[candidates][Capacities::contacts]`.
    pub normals: Buffer<Normal>,
    /// By patch, `[candidates][patch_rows]`.
    pub frictions: Buffer<Friction>,
    /// Before the first substep, which is an even one.
    loads: Vec<Step>,
    /// Of even and of odd substeps.
    steps: [Vec<Step>; 2],
}

impl Solver {
    /// Makes the solver's tables for so many candidates and bodies of each; `touching` for even and for odd substeps.
    /// `sim` with its buffer.
    ///
    /// # Errors
    /// If a table is larger than the adapter's buffers.
    pub fn new(
        gpu: &Gpu,
        kernels: &Kernels,
        [candidates, bodies]: [u32; 2],
        (parameters, sim): (&Sim, &Buffer<Sim>),
        way: Way,
        motion: Motion<'_>,
        touching: [Touching<'_>; 2],
    ) -> Result<Self, GpuError> {
        let rows = candidates * (bodies + 1);
        let slots = candidates as usize * parameters.contacts as usize;
        let moving = Buffer::<Moving>::new(gpu, "moving", rows as usize)?;
        let normals = Buffer::<Normal>::new(gpu, "normals", slots)?;
        let patches = candidates as usize * patch_rows(parameters.contacts) as usize;
        let frictions = Buffer::<Friction>::new(gpu, "frictions", patches)?;
        let levers = Buffer::<Levers>::new(gpu, "levers", patches)?;
        let gaps = Buffer::<Gap>::new(gpu, "gaps", slots)?;
        let cursors = Buffer::<Cursor>::new(gpu, "cursors", candidates as usize)?;
        let axes = Buffer::<Axes>::new(gpu, "axes", rows as usize)?;
        let free = Buffer::<Free>::new(gpu, "free", rows as usize)?;
        let start = kernels::SolveBodiesBuffers {
            batch: motion.batch.uniform(),
            bodies: motion.bodies.read(),
            poses: motion.poses.read(),
            velocities: motion.velocities.read(),
            moving: moving.write(),
            axes: axes.write(),
        };
        let prepare = |Touching { counts, patches, contacts }: &Touching<'_>| {
            let load = kernels::SolveLoadBuffers {
                batch: motion.batch.uniform(),
                sim: sim.uniform(),
                poses: motion.poses.read(),
                moving: moving.read(),
                axes: axes.read(),
                patch_counts: counts.read(),
                patches: patches.read(),
                contacts: contacts.read(),
                frictions: frictions.write(),
                normals: normals.write(),
                levers: levers.write(),
                gaps: gaps.write(),
                cursors: cursors.write(),
            };
            vec![start.step(gpu, kernels, rows), load.step(gpu, kernels, candidates * PATCH_LANES)]
        };
        let first = kernels::FirstLoadsBuffers {
            batch: motion.batch.uniform(),
            sim: sim.uniform(),
            patch_counts: touching[0].counts.read(),
            gaps: gaps.read(),
            moving: moving.write(),
            frictions: frictions.write(),
            normals: normals.write(),
            cursors: cursors.write(),
            patches: touching[0].patches.write(),
            contacts: touching[0].contacts.write(),
        };
        let mut loads = prepare(&touching[0]);
        loads.extend((0..load_rounds(parameters, bodies)).map(|_| first.step(gpu, kernels, candidates)));
        let steps = touching.map(|touching| {
            let mut steps = prepare(&touching);
            let Touching { counts, patches, contacts } = touching;
            let waves = kernels::SolveWavesBuffers {
                batch: motion.batch.uniform(),
                sim: sim.uniform(),
                patch_counts: counts.read(),
                patches: patches.read(),
                axes: axes.read(),
                free: free.write(),
                all_moving: moving.write(),
                all_frictions: frictions.write(),
                all_normals: normals.write(),
                levers: levers.write(),
                gaps: gaps.write(),
                cursors: cursors.write(),
            };
            let solve = kernels::SolveBuffers {
                batch: motion.batch.uniform(),
                sim: sim.uniform(),
                patch_counts: counts.read(),
                patches: patches.read(),
                axes: axes.read(),
                free: free.write(),
                moving: moving.write(),
                frictions: frictions.write(),
                normals: normals.write(),
                levers: levers.write(),
                gaps: gaps.write(),
                cursors: cursors.write(),
            };
            let integrate = kernels::IntegrateBuffers {
                batch: motion.batch.uniform(),
                sim: sim.uniform(),
                bodies: motion.bodies.read(),
                moving: moving.read(),
                axes: axes.read(),
                patch_counts: counts.read(),
                frictions: frictions.read(),
                normals: normals.read(),
                gaps: gaps.read(),
                cursors: cursors.read(),
                patches: patches.write(),
                contacts: contacts.write(),
                poses: motion.poses.write(),
                velocities: motion.velocities.write(),
                statuses: motion.statuses.write(),
            };
            let rounds = rounds(parameters, bodies);
            if way == Way::Waves {
                let lanes = candidates * WAVE_LANES;
                steps.extend((0..rounds).map(|_| waves.step(gpu, kernels, lanes)));
            }
            steps.extend((0..rounds).map(|_| solve.step(gpu, kernels, candidates)));
            steps.push(integrate.step(gpu, kernels, candidates * PATCH_LANES));
            steps
        });
        Ok(Self { moving, normals, frictions, loads, steps })
    }

    /// The kernels of a substep of this parity, in their order.
    pub fn steps(&self, parity: usize) -> &[Step] {
        &self.steps[parity]
    }

    /// The kernels that find what contacts carry when a simulation begins, in their order.
    pub fn load_steps(&self) -> &[Step] {
        &self.loads
    }

    /// Advances all candidates by a substep. `parity`: 0 for even, 1 for odd substeps.
    pub fn solve(&self, recorder: &mut Recorder<'_>, parity: usize) {
        recorder.run(&self.steps[parity]);
    }
}
