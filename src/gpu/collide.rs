//! From poses to the separations of hulls: broad phase and separating axes, of all candidates at once.
//!
//! What a substep hands to the next, the axis of each hull pair, lies in two tables that change roles: a substep of
//! parity 0 writes table 0 and reads table 1, and the other way round.

use super::buffer::Buffer;
use super::device::{Gpu, GpuError};
use super::kernel::{Recorder, Step};
use super::kernels::{self, Kernels};
use super::layout::{Ball, Batch, Body, Bounds, HullPair, Mark, Pose, Preference, Separation, Sim, Velocity};
use super::tables::Tables;
use crate::world::{SimSettings, World};

/// Buffers of collision detection, candidate-major. `slots` is `Capacities::hull_pairs`.
pub struct Collide {
    /// `[candidates][hulls]`
    pub hull_boxes: Buffer<Bounds>,
    /// `[candidates][bodies]`
    pub body_boxes: Buffer<Bounds>,
    /// `[candidates][bodies]`
    pub marks: Buffer<Mark>,
    /// `[candidates][pairs]`
    pub pair_counts: Buffer<u32>,
    /// By parity, `[candidates][pairs + 1]`: where a body pair's hull pairs begin; the last is their number, which goes
    /// on past the slots.
    pub pair_starts: [Buffer<u32>; 2],
    /// Largest number of hull pairs since `reset`, `[candidates]`.
    pub most_hull_pairs: Buffer<u32>,
    /// By parity, `[candidates][slots]`.
    pub hull_pairs: [Buffer<HullPair>; 2],
    /// `[candidates][slots]`, in the order of the hull pairs.
    pub separations: Buffer<Separation>,
    /// What `measure` finds, `[candidates][pairs]`, m.
    pub depths: Buffer<f32>,
    detecting: [Vec<Step>; 2],
    measuring: Vec<Step>,
}

/// The buffers that the simulation moves on.
#[derive(Clone, Copy)]
pub struct Motion<'a> {
    /// Sizes of the tables.
    pub batch: &'a Buffer<Batch>,
    /// `[bodies]`
    pub bodies: &'a Buffer<Body>,
    /// `[candidates][bodies]`
    pub poses: &'a Buffer<Pose>,
    /// `[candidates][bodies]`
    pub velocities: &'a Buffer<Velocity>,
    /// Bits of `world::Status`, `[candidates]`.
    pub statuses: &'a Buffer<u32>,
}

impl Collide {
    /// Makes all buffers for `candidates` copies of `world`, and binds the kernels to them.
    ///
    /// # Errors
    /// If a table is larger than the adapter's buffers.
    pub fn new(
        gpu: &Gpu,
        kernels: &Kernels,
        world: &World,
        settings: &SimSettings,
        tables: &Tables,
        motion: Motion<'_>,
    ) -> Result<Self, GpuError> {
        let candidates = motion.statuses.len();
        let rows = candidates * world.bodies.len();
        let pairs = candidates * world.pairs.len();
        let slots = candidates * world.capacities.hull_pairs as usize;

        // Without margins only what overlaps is found.
        let still = Sim { substep: 0.0, contact_offset: 0.0, ..Sim::new(settings, world.capacities) };
        let still = Buffer::from_slice(gpu, "still", &[still])?;
        let balls = Buffer::from_slice(gpu, "balls", &Ball::all(&world.hulls))?;
        let contact = Buffer::from_slice(gpu, "preference", &[Preference::CONTACT])?;
        let none = Buffer::from_slice(gpu, "preference", &[Preference::NONE])?;
        let hull_boxes = Buffer::new(gpu, "hull_boxes", candidates * world.hulls.hulls.len())?;
        let body_boxes = Buffer::new(gpu, "body_boxes", rows)?;
        let marks = Buffer::new(gpu, "marks", rows)?;
        let pair_counts = Buffer::new(gpu, "pair_counts", pairs)?;
        let starts = || Buffer::new(gpu, "pair_starts", pairs + candidates);
        let pair_starts = [starts()?, starts()?];
        let most_hull_pairs = Buffer::new(gpu, "most_hull_pairs", candidates)?;
        let table = || Buffer::new(gpu, "hull_pairs", slots);
        let hull_pairs = [table()?, table()?];
        let separations = Buffer::new(gpu, "separations", slots)?;
        let depths = Buffer::new(gpu, "depths", pairs)?;

        let steps = |parity: usize, sim: &Buffer<Sim>, preference: &Buffer<Preference>| -> Vec<Step> {
            let batch = motion.batch.uniform();
            let (new, old) = (parity, 1 - parity);
            let boxes = kernels::BoxesBuffers {
                batch,
                sim: sim.uniform(),
                bodies: motion.bodies.read(),
                hulls: tables.hulls.read(),
                poses: motion.poses.read(),
                velocities: motion.velocities.read(),
                hull_boxes: hull_boxes.write(),
                body_boxes: body_boxes.write(),
                marks: marks.write(),
            };
            let counts = kernels::PairCountsBuffers {
                batch,
                bodies: motion.bodies.read(),
                pairs: tables.pairs.read(),
                hull_boxes: hull_boxes.read(),
                body_boxes: body_boxes.read(),
                pair_counts: pair_counts.write(),
            };
            let starts = kernels::PairStartsBuffers {
                batch,
                sim: sim.uniform(),
                pair_counts: pair_counts.read(),
                pair_starts: pair_starts[new].write(),
                most_hull_pairs: most_hull_pairs.write(),
                statuses: motion.statuses.write(),
            };
            let listing = kernels::HullPairsBuffers {
                batch,
                sim: sim.uniform(),
                bodies: motion.bodies.read(),
                pairs: tables.pairs.read(),
                hull_boxes: hull_boxes.read(),
                body_boxes: body_boxes.read(),
                pair_starts: pair_starts[new].read(),
                old_starts: pair_starts[old].read(),
                old_pairs: hull_pairs[old].read(),
                hull_pairs: hull_pairs[new].write(),
            };
            let remembered = kernels::AxisRememberedBuffers {
                batch,
                sim: sim.uniform(),
                pairs: tables.pairs.read(),
                hulls: tables.hulls.read(),
                balls: balls.read(),
                vertices: tables.vertices.read(),
                faces: tables.faces.read(),
                face_vertices: tables.face_vertices.read(),
                edges: tables.edges.read(),
                poses: motion.poses.read(),
                body_boxes: body_boxes.read(),
                pair_starts: pair_starts[new].read(),
                hull_pairs: hull_pairs[new].read(),
                separations: separations.write(),
            };
            let faces = kernels::AxisFacesBuffers {
                batch,
                sim: sim.uniform(),
                preference: preference.uniform(),
                bodies: motion.bodies.read(),
                pairs: tables.pairs.read(),
                hulls: tables.hulls.read(),
                balls: balls.read(),
                vertices: tables.vertices.read(),
                faces: tables.faces.read(),
                poses: motion.poses.read(),
                hull_boxes: hull_boxes.read(),
                body_boxes: body_boxes.read(),
                pair_starts: pair_starts[new].read(),
                hull_pairs: hull_pairs[new].write(),
                separations: separations.write(),
            };
            let edges = kernels::AxisEdgesBuffers {
                batch,
                sim: sim.uniform(),
                preference: preference.uniform(),
                bodies: motion.bodies.read(),
                pairs: tables.pairs.read(),
                hulls: tables.hulls.read(),
                balls: balls.read(),
                vertices: tables.vertices.read(),
                faces: tables.faces.read(),
                edges: tables.edges.read(),
                poses: motion.poses.read(),
                hull_boxes: hull_boxes.read(),
                body_boxes: body_boxes.read(),
                pair_starts: pair_starts[new].read(),
                hull_pairs: hull_pairs[new].write(),
                separations: separations.write(),
            };
            let [rows, pairs, slots, groups] =
                [rows, pairs, slots, candidates * kernels::constants::WORKGROUP as usize].map(|n| n as u32);
            vec![
                boxes.step(gpu, kernels, rows),
                counts.step(gpu, kernels, pairs),
                starts.step(gpu, kernels, groups),
                listing.step(gpu, kernels, pairs),
                remembered.step(gpu, kernels, slots),
                faces.step(gpu, kernels, slots),
                edges.step(gpu, kernels, slots),
            ]
        };
        let detecting = [0, 1].map(|parity| steps(parity, &tables.sim, &contact));
        let mut measuring = steps(0, &still, &none);
        let depth = kernels::DepthBuffers {
            batch: motion.batch.uniform(),
            sim: still.uniform(),
            pair_starts: pair_starts[0].read(),
            separations: separations.read(),
            depths: depths.write(),
        };
        measuring.push(depth.step(gpu, kernels, pairs as u32));
        Ok(Self {
            hull_boxes,
            body_boxes,
            marks,
            pair_counts,
            pair_starts,
            most_hull_pairs,
            hull_pairs,
            separations,
            depths,
            detecting,
            measuring,
        })
    }

    /// Before the first substep: no hull pair is known yet, and no contact.
    pub fn reset(&self, recorder: &mut Recorder<'_>) {
        self.forget(recorder);
        recorder.clear(&self.most_hull_pairs);
    }

    /// Lists the hull pairs at the present poses in the tables of `parity` (the substep's number modulo 2), with their
    /// separations.
    pub fn detect(&self, recorder: &mut Recorder<'_>, parity: usize) {
        recorder.run(&self.detecting[parity]);
    }

    /// The kernels of a substep of this parity, in their order.
    pub fn steps(&self, parity: usize) -> &[Step] {
        &self.detecting[parity]
    }

    /// The kernels of `measure`.
    pub fn measuring_steps(&self) -> &[Step] {
        &self.measuring
    }

    /// Measures the deepest overlap of each body pair at the present poses, into `depths` (m, 0 if apart). The next
    /// substep knows no hull pairs and keeps no contacts.
    pub fn measure(&self, recorder: &mut Recorder<'_>, depths: &Buffer<f32>) {
        self.forget(recorder);
        recorder.run(&self.measuring);
        recorder.copy(&self.depths, depths);
        self.forget(recorder);
    }

    fn forget(&self, recorder: &mut Recorder<'_>) {
        recorder.clear(&self.marks);
        self.pair_starts.iter().for_each(|starts| recorder.clear(starts));
    }
}
