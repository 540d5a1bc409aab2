//! From the axes of hull pairs to the patches and contact points that the solver reads.
//!
//! Two tables of patches and points change roles: a substep of one parity reads the impulses of the other's.

use super::buffer::Buffer;
use super::device::{Gpu, GpuError};
use super::kernel::{Recorder, Step};
use super::kernels::{self, Kernels};
use super::layout::{
    Batch, Body, Bounds, Contact, Facing, HullPair, Manifold, ManifoldPoint, Merged, Patch, Pose, Separation, Velocity,
};
use super::tables::Tables;
use crate::world::World;
use crate::world::constants::MAX_MANIFOLD_POINTS;

/// What is known before: the state of the bodies and what the search for axes found.
pub struct Inputs<'a> {
    /// Sizes of the tables.
    pub batch: &'a Buffer<Batch>,
    /// `[bodies]`
    pub bodies: &'a Buffer<Body>,
    /// `[candidates][bodies]`
    pub poses: &'a Buffer<Pose>,
    /// `[candidates][bodies]`
    pub velocities: &'a Buffer<Velocity>,
    /// Each body's share of the distance within which contacts are made, `[candidates][bodies]`.
    pub body_boxes: &'a Buffer<Bounds>,
    /// By parity, `[candidates][capacity]`.
    pub hull_pairs: [&'a Buffer<HullPair>; 2],
    /// By parity, `[candidates][pairs + 1]`: where a body pair's hull pairs begin.
    pub pair_starts: [&'a Buffer<u32>; 2],
    /// `[candidates][capacity]`
    pub separations: &'a Buffer<Separation>,
    /// `[candidates]`
    pub statuses: &'a Buffer<u32>,
}

/// Contacts of all candidates. An *entry* of a candidate is a body pair or, past the pairs, a body and the ground; a
/// *slot* is a hull pair or, past their capacity, a hull and the ground.
pub struct Contacts {
    /// By parity, `[candidates][capacity]`.
    pub patches: [Buffer<Patch>; 2],
    /// The same of points.
    pub points: [Buffer<Contact>; 2],
    /// Patches and points in use, by parity, `[candidates]`.
    pub patch_counts: [Buffer<u32>; 2],
    /// Points that there would be with enough room, `[candidates]`.
    pub point_counts: Buffer<u32>,
    /// The body of each hull.
    pub hull_bodies: Buffer<u32>,
    /// `[candidates][capacity of hull pairs]`
    pub facings: Buffer<Facing>,
    /// `[candidates][slots]`
    pub manifolds: Buffer<Manifold>,
    /// `[candidates][slots][MAX_MANIFOLD_POINTS]`
    pub manifold_points: Buffer<ManifoldPoint>,
    /// `[candidates][entries]`
    pub merged: Buffer<Merged>,
    /// Numbers of points, `[candidates][slots][MAX_MANIFOLD_POINTS]`.
    pub merged_points: Buffer<u32>,
    /// First patch and first point of each entry, by parity, `[candidates][entries]`.
    pub starts: [Buffer<[u32; 2]>; 2],
    steps: [Vec<Step>; 2],
}

impl Contacts {
    /// Makes all buffers for so many candidates, and binds them.
    ///
    /// # Errors
    /// If a buffer is larger than the adapter's.
    pub fn new(
        gpu: &Gpu,
        kernels: &Kernels,
        world: &World,
        candidates: u32,
        tables: &Tables,
        inputs: &Inputs<'_>,
    ) -> Result<Self, GpuError> {
        let hulls = world.hulls.hulls.len();
        let [pairs, contacts] = [world.capacities.hull_pairs, world.capacities.contacts].map(|n| n as usize);
        let copies = candidates as usize;
        let slots = copies * (pairs + hulls);
        let entries = copies * (world.pairs.len() + world.bodies.len());
        let mut hull_bodies = vec![0; hulls];
        (0..world.bodies.len()).for_each(|body| hull_bodies[world.hulls_of(body)].fill(body as u32));
        let mut made = Self {
            patches: both(|| Buffer::new(gpu, "patches", copies * contacts))?,
            points: both(|| Buffer::new(gpu, "contacts", copies * contacts))?,
            patch_counts: both(|| Buffer::new(gpu, "patch_counts", copies))?,
            point_counts: Buffer::new(gpu, "point_counts", copies)?,
            hull_bodies: Buffer::from_slice(gpu, "hull_bodies", &hull_bodies)?,
            facings: Buffer::new(gpu, "facings", copies * pairs)?,
            manifolds: Buffer::new(gpu, "manifolds", slots)?,
            manifold_points: Buffer::new(gpu, "manifold_points", slots * MAX_MANIFOLD_POINTS)?,
            merged: Buffer::new(gpu, "merged", entries)?,
            merged_points: Buffer::new(gpu, "merged_points", slots * MAX_MANIFOLD_POINTS)?,
            starts: both(|| Buffer::new(gpu, "starts", entries))?,
            steps: [Vec::new(), Vec::new()],
        };
        let bind = |parity| made.bind(gpu, kernels, tables, inputs, parity);
        made.steps = [bind(0), bind(1)];
        Ok(made)
    }

    fn bind(&self, gpu: &Gpu, kernels: &Kernels, tables: &Tables, inputs: &Inputs<'_>, parity: usize) -> Vec<Step> {
        let old = 1 - parity;
        let (batch, sim) = (inputs.batch.uniform(), tables.sim.uniform());
        let candidates = self.point_counts.len() as u32;
        let aligned_faces = kernels::AlignedFacesBuffers {
            batch,
            sim,
            hulls: tables.hulls.read(),
            faces: tables.faces.read(),
            pairs: tables.pairs.read(),
            poses: inputs.poses.read(),
            body_boxes: inputs.body_boxes.read(),
            hull_pairs: inputs.hull_pairs[parity].read(),
            pair_starts: inputs.pair_starts[parity].read(),
            separations: inputs.separations.read(),
            facings: self.facings.write(),
        };
        let clip_faces = kernels::ClipFacesBuffers {
            batch,
            sim,
            hulls: tables.hulls.read(),
            vertices: tables.vertices.read(),
            faces: tables.faces.read(),
            face_vertices: tables.face_vertices.read(),
            outlines: tables.outlines.read(),
            lines: tables.lines.read(),
            poses: inputs.poses.read(),
            facings: self.facings.read(),
            manifolds: self.manifolds.write(),
            manifold_points: self.manifold_points.write(),
        };
        let single_points = kernels::SinglePointsBuffers {
            batch,
            sim,
            hulls: tables.hulls.read(),
            vertices: tables.vertices.read(),
            faces: tables.faces.read(),
            face_vertices: tables.face_vertices.read(),
            edges: tables.edges.read(),
            poses: inputs.poses.read(),
            separations: inputs.separations.read(),
            facings: self.facings.read(),
            manifolds: self.manifolds.write(),
            manifold_points: self.manifold_points.write(),
        };
        let passing = kernels::PassingBuffers {
            batch,
            sim,
            bodies: inputs.bodies.read(),
            hulls: tables.hulls.read(),
            vertices: tables.vertices.read(),
            faces: tables.faces.read(),
            edges: tables.edges.read(),
            poses: inputs.poses.read(),
            velocities: inputs.velocities.read(),
            facings: self.facings.read(),
            manifold_points: self.manifold_points.read(),
            manifolds: self.manifolds.write(),
        };
        let ground = kernels::GroundBuffers {
            batch,
            sim,
            bodies: inputs.bodies.read(),
            hulls: tables.hulls.read(),
            hull_bodies: self.hull_bodies.read(),
            vertices: tables.vertices.read(),
            poses: inputs.poses.read(),
            body_boxes: inputs.body_boxes.read(),
            manifolds: self.manifolds.write(),
            manifold_points: self.manifold_points.write(),
        };
        let merge = kernels::MergeBuffers {
            batch,
            sim,
            bodies: inputs.bodies.read(),
            pairs: tables.pairs.read(),
            body_boxes: inputs.body_boxes.read(),
            pair_starts: inputs.pair_starts[parity].read(),
            manifolds: self.manifolds.read(),
            manifold_points: self.manifold_points.read(),
            merged: self.merged.write(),
            merged_points: self.merged_points.write(),
        };
        let contact_starts = kernels::ContactStartsBuffers {
            batch,
            sim,
            merged: self.merged.read(),
            starts: self.starts[parity].write(),
            patch_counts: self.patch_counts[parity].write(),
            point_counts: self.point_counts.write(),
            statuses: inputs.statuses.write(),
        };
        let emit = kernels::EmitBuffers {
            batch,
            sim,
            pairs: tables.pairs.read(),
            poses: inputs.poses.read(),
            manifolds: self.manifolds.read(),
            manifold_points: self.manifold_points.read(),
            merged: self.merged.read(),
            merged_points: self.merged_points.read(),
            starts: self.starts[parity].read(),
            old_starts: self.starts[old].read(),
            old_patch_counts: self.patch_counts[old].read(),
            old_patches: self.patches[old].read(),
            old_contacts: self.points[old].read(),
            patches: self.patches[parity].write(),
            contacts: self.points[parity].write(),
        };
        let [hull_pairs, hulls, entries] =
            [self.facings.len(), self.hull_bodies.len() * candidates as usize, self.merged.len()].map(|n| n as u32);
        let lanes = kernels::ContactStartsBuffers::SHADER.workgroup[0];
        vec![
            aligned_faces.step(gpu, kernels, hull_pairs),
            clip_faces.step(gpu, kernels, hull_pairs),
            single_points.step(gpu, kernels, hull_pairs),
            passing.step(gpu, kernels, hull_pairs),
            ground.step(gpu, kernels, hulls),
            merge.step(gpu, kernels, entries),
            contact_starts.step(gpu, kernels, candidates * lanes),
            emit.step(gpu, kernels, entries),
        ]
    }

    /// The kernels of a substep of this parity, in their order.
    pub fn steps(&self, parity: usize) -> &[Step] {
        &self.steps[parity]
    }

    /// Makes the contacts of a substep of this parity.
    pub fn record(&self, recorder: &mut Recorder<'_>, parity: usize) {
        recorder.run(&self.steps[parity]);
    }

    /// Forgets the last substep.
    pub fn reset(&self, recorder: &mut Recorder<'_>) {
        self.patch_counts.iter().for_each(|counts| recorder.clear(counts));
    }
}

fn both<T>(make: impl Fn() -> Result<T, GpuError>) -> Result<[T; 2], GpuError> {
    Ok([make()?, make()?])
}
