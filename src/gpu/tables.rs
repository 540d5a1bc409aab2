//! The tables that all candidates share: hulls, bodies' pairs, parameters. Made once.

use super::buffer::Buffer;
use super::device::{Gpu, GpuError};
use super::layout::{Edge, Face, Hull, Outline, Sim};
use crate::world::{SimSettings, World};
use glam::Vec4;

/// `World` on the device.
pub struct Tables {
    /// How it is simulated, one.
    pub sim: Buffer<Sim>,
    /// What is in `sim`.
    pub parameters: Sim,
    /// `[hulls]`
    pub hulls: Buffer<Hull>,
    /// Of all hulls, m.
    pub vertices: Buffer<Vec4>,
    /// Of all hulls.
    pub faces: Buffer<Face>,
    /// What faces refer to: indices of vertices.
    pub face_vertices: Buffer<u32>,
    /// Of all hulls.
    pub edges: Buffer<Edge>,
    /// One a face.
    pub outlines: Buffer<Outline>,
    /// What outlines refer to.
    pub lines: Buffer<Vec4>,
    /// Bodies of each pair.
    pub pairs: Buffer<[u32; 2]>,
}

impl Tables {
    /// Uploads everything.
    ///
    /// # Errors
    /// If a table is larger than the adapter's buffers.
    pub fn new(gpu: &Gpu, world: &World, settings: &SimSettings) -> Result<Self, GpuError> {
        let hulls = &world.hulls;
        let sim = Sim { loops: gpu.loops(), ..Sim::new(settings, world.capacities) };
        Ok(Self {
            sim: Buffer::from_slice(gpu, "sim", &[sim])?,
            parameters: sim,
            hulls: Buffer::from_slice(gpu, "hulls", &hulls.hulls)?,
            vertices: Buffer::from_slice(gpu, "vertices", &hulls.vertices)?,
            faces: Buffer::from_slice(gpu, "faces", &hulls.faces)?,
            face_vertices: Buffer::from_slice(gpu, "face_vertices", &hulls.face_vertices)?,
            edges: Buffer::from_slice(gpu, "edges", &hulls.edges)?,
            outlines: Buffer::from_slice(gpu, "outlines", &hulls.outlines)?,
            lines: Buffer::from_slice(gpu, "lines", &hulls.lines)?,
            pairs: Buffer::from_slice(gpu, "pairs", &world.pairs)?,
        })
    }
}
