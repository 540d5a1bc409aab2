//! The contact solver: a substep from contacts to new poses and velocities.

use super::buffer::Buffer;
use super::collide::Motion;
use super::device::{Gpu, GpuError};
use super::kernel::{Recorder, Step};
use super::kernels::{self, Kernels};
use super::layout::{Contact, Friction, Moving, Normal, Patch, Sim};

/// Invocations that share a candidate's patches, as in `solve_load`.
const PATCH_LANES: u32 = kernels::constants::PATCH_LANES;

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
    /// By patch, `[candidates][Capacities::contacts]`.
    pub frictions: Buffer<Friction>,
    /// Of even and of odd substeps.
    steps: [[Step; 4]; 2],
}

impl Solver {
    /// Makes the solver's tables for so many candidates, bodies of each and slots for contacts; `touching` for even and for
    /// odd substeps.
    ///
    /// # Errors
    /// If a table is larger than the adapter's buffers.
    pub fn new(
        gpu: &Gpu,
        kernels: &Kernels,
        [candidates, bodies, contacts]: [u32; 3],
        sim: &Buffer<Sim>,
        motion: Motion<'_>,
        touching: [Touching<'_>; 2],
    ) -> Result<Self, GpuError> {
        let rows = candidates * (bodies + 1);
        let slots = candidates as usize * contacts as usize;
        let moving = Buffer::<Moving>::new(gpu, "moving", rows as usize)?;
        let normals = Buffer::<Normal>::new(gpu, "normals", slots)?;
        let frictions = Buffer::<Friction>::new(gpu, "frictions", slots)?;
        let start = kernels::SolveBodiesBuffers {
            batch: motion.batch.uniform(),
            bodies: motion.bodies.read(),
            poses: motion.poses.read(),
            velocities: motion.velocities.read(),
            moving: moving.write(),
        };
        let steps = touching.map(|Touching { counts, patches, contacts }| {
            let load = kernels::SolveLoadBuffers {
                batch: motion.batch.uniform(),
                sim: sim.uniform(),
                poses: motion.poses.read(),
                moving: moving.read(),
                patch_counts: counts.read(),
                patches: patches.read(),
                contacts: contacts.read(),
                frictions: frictions.write(),
                normals: normals.write(),
            };
            let solve = kernels::SolveBuffers {
                batch: motion.batch.uniform(),
                sim: sim.uniform(),
                patch_counts: counts.read(),
                patches: patches.read(),
                moving: moving.write(),
                frictions: frictions.write(),
                normals: normals.write(),
            };
            let integrate = kernels::IntegrateBuffers {
                batch: motion.batch.uniform(),
                sim: sim.uniform(),
                bodies: motion.bodies.read(),
                moving: moving.read(),
                patch_counts: counts.read(),
                frictions: frictions.read(),
                normals: normals.read(),
                patches: patches.write(),
                contacts: contacts.write(),
                poses: motion.poses.write(),
                velocities: motion.velocities.write(),
                statuses: motion.statuses.write(),
            };
            [
                start.step(gpu, kernels, rows),
                load.step(gpu, kernels, candidates * PATCH_LANES),
                solve.step(gpu, kernels, candidates),
                integrate.step(gpu, kernels, candidates),
            ]
        });
        Ok(Self { moving, normals, frictions, steps })
    }

    /// The kernels of a substep of this parity, in their order.
    pub fn steps(&self, parity: usize) -> &[Step] {
        &self.steps[parity]
    }

    /// Advances all candidates by a substep. `parity`: 0 for even, 1 for odd substeps.
    pub fn solve(&self, recorder: &mut Recorder<'_>, parity: usize) {
        recorder.run(&self.steps[parity]);
    }
}
