//! Hulls as the separating-axis search reads them: four vertices or planes to a register, and what prunes the search.

use crate::world::HullTables;
use crate::world::constants::AXIS_ROUNDING;
use glam::{Mat3, Mat4, Vec3, Vec4};

/// Four vectors, one per lane.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lanes {
    pub x: Vec4,
    pub y: Vec4,
    pub z: Vec4,
}

impl Lanes {
    /// Four vectors from their numbers 0 to 3.
    #[inline(always)]
    pub fn gather(vector: impl Fn(usize) -> Vec3) -> Self {
        let v = [vector(0), vector(1), vector(2), vector(3)];
        Self {
            x: Vec4::from_array(v.map(|v| v.x)),
            y: Vec4::from_array(v.map(|v| v.y)),
            z: Vec4::from_array(v.map(|v| v.z)),
        }
    }

    /// The four dot products with `v`.
    #[inline(always)]
    pub fn dot(&self, v: Vec3) -> Vec4 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    /// The vectors turned by `rotation`.
    #[inline(always)]
    pub fn rotated(&self, rotation: &Mat3) -> Self {
        let Mat3 { x_axis: a, y_axis: b, z_axis: c } = rotation;
        Self {
            x: self.x * a.x + self.y * b.x + self.z * c.x,
            y: self.x * a.y + self.y * b.y + self.z * c.y,
            z: self.x * a.z + self.y * b.z + self.z * c.z,
        }
    }

    /// The four dot products, lane by lane.
    #[inline(always)]
    pub fn dot_lanes(&self, other: &Self) -> Vec4 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Each vector × `v`.
    #[inline(always)]
    pub fn crossed_with(&self, v: Vec3) -> Self {
        Self { x: self.y * v.z - self.z * v.y, y: self.z * v.x - self.x * v.z, z: self.x * v.y - self.y * v.x }
    }

    /// The sums, lane by lane.
    #[inline(always)]
    pub fn plus(&self, other: &Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }

    /// What leads from each point to `v`.
    #[inline(always)]
    pub fn toward(&self, v: Vec3) -> Self {
        Self { x: v.x - self.x, y: v.y - self.y, z: v.z - self.z }
    }

    /// Vector of one lane.
    #[inline(always)]
    pub fn lane(&self, k: usize) -> Vec3 {
        Vec3::new(self.x[k], self.y[k], self.z[k])
    }
}

/// Four planes `normal · x = offset`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Planes {
    pub normal: Lanes,
    pub offset: Vec4,
}

impl Planes {
    /// The planes turned by `rotation`, then shifted by `shift`.
    #[inline(always)]
    pub fn moved(&self, rotation: &Mat3, shift: Vec3) -> Self {
        let normal = self.normal.rotated(rotation);
        Self { normal, offset: self.offset + normal.dot(shift) }
    }
}

/// Four edges: a point of each, its unit direction, and the normals of its faces.
#[derive(Clone, Copy, Debug, Default)]
pub struct EdgeLanes {
    pub start: Lanes,
    pub along: Lanes,
    pub left: Lanes,
    pub right: Lanes,
}

impl EdgeLanes {
    /// Four edges from their numbers 0 to 3.
    #[inline(always)]
    pub fn gather<'a>(edge: impl Fn(usize) -> &'a TwinEdge) -> Self {
        let edges = [edge(0), edge(1), edge(2), edge(3)];
        let lanes = |part: fn(&TwinEdge) -> Vec4| {
            let [a, b, c, d] = edges.map(part);
            let Mat4 { x_axis: x, y_axis: y, z_axis: z, .. } = Mat4::from_cols(a, b, c, d).transpose();
            Lanes { x, y, z }
        };
        Self {
            start: lanes(|e| e.start),
            along: lanes(|e| e.along),
            left: lanes(|e| e.left),
            right: lanes(|e| e.right),
        }
    }
}

/// One edge of `EdgeLanes`; the last lanes are 0.
#[derive(Clone, Copy, Debug)]
pub struct TwinEdge {
    pub start: Vec4,
    pub along: Vec4,
    pub left: Vec4,
    pub right: Vec4,
}

/// Four edges: the numbers of their faces, and the cosines between these.
#[derive(Clone, Copy, Debug)]
pub struct EdgeFaces {
    pub left: [u8; 4],
    pub right: [u8; 4],
    pub cosine: Vec4,
}

/// Where a hull's groups of four lie, and a ball inside it.
#[derive(Clone, Copy, Debug)]
pub struct TwinHull {
    pub first_vertices: u32,
    pub vertex_groups: u32,
    pub first_planes: u32,
    pub plane_groups: u32,
    pub first_edges: u32,
    pub edge_groups: u32,
    /// Centre of the ball, body frame, m.
    pub center: Vec3,
    /// Radius of the ball, m.
    pub inner_radius: f32,
    /// How far a face's plane may lie outside its own edges, m: joined triangles are flat only within a tolerance. With
    /// `AXIS_ROUNDING`.
    pub slack: f32,
}

/// The search's tables of all hulls of a world.
#[derive(Clone, Debug, Default)]
pub struct TwinTables {
    pub hulls: Vec<TwinHull>,
    /// The last group of a hull is filled with its last vertex.
    pub vertices: Vec<Lanes>,
    /// The last group of a hull is filled with its last plane.
    pub planes: Vec<Planes>,
    /// The edges, numbered as `HullTables::edges`.
    pub edges: Vec<TwinEdge>,
    /// The last group of a hull is filled with its last edge.
    pub edge_faces: Vec<EdgeFaces>,
}

impl TwinTables {
    pub fn new(tables: &HullTables) -> Self {
        let mut out = Self::default();
        for hull in &tables.hulls {
            let (vertices, faces, edges) = (tables.vertices_of(hull), tables.faces_of(hull), tables.edges_of(hull));
            // The mean of the face centres lies well inside even where vertices crowd on one side.
            let center = faces
                .iter()
                .map(|f| {
                    let corners = tables.corners_of(f);
                    corners.iter().map(|&c| vertices[c as usize].truncate()).sum::<Vec3>() / corners.len().max(1) as f32
                })
                .sum::<Vec3>()
                / faces.len().max(1) as f32;
            let inner_radius =
                faces.iter().map(|f| f.plane.w - f.normal().dot(center)).fold(f32::INFINITY, f32::min).max(0.0);
            let over = |f: u32, v: u32| {
                let face = &faces[f as usize];
                face.plane.w - face.normal().dot(vertices[v as usize].truncate())
            };
            let slack = edges
                .iter()
                .flat_map(|e| e.faces.map(|f| over(f, e.vertices[0]).max(over(f, e.vertices[1]))))
                .fold(0.0, f32::max)
                + AXIS_ROUNDING;
            out.hulls.push(TwinHull {
                first_vertices: out.vertices.len() as u32,
                vertex_groups: vertices.len().div_ceil(4) as u32,
                first_planes: out.planes.len() as u32,
                plane_groups: faces.len().div_ceil(4) as u32,
                first_edges: out.edge_faces.len() as u32,
                edge_groups: edges.len().div_ceil(4) as u32,
                center,
                inner_radius,
                slack,
            });
            for first in (0..vertices.len()).step_by(4) {
                out.vertices.push(Lanes::gather(|k| vertices[(first + k).min(vertices.len() - 1)].truncate()));
            }
            for first in (0..faces.len()).step_by(4) {
                let face = |k: usize| &faces[(first + k).min(faces.len() - 1)];
                out.planes.push(Planes {
                    normal: Lanes::gather(|k| face(k).normal()),
                    offset: Vec4::new(face(0).plane.w, face(1).plane.w, face(2).plane.w, face(3).plane.w),
                });
            }
            out.edges.extend(edges.iter().map(|e| {
                let [start, end] = e.vertices.map(|v| vertices[v as usize].truncate());
                let [left, right] = e.faces.map(|f| faces[f as usize].normal().extend(0.0));
                TwinEdge { start: start.extend(0.0), along: (end - start).normalize_or_zero().extend(0.0), left, right }
            }));
            for first in (0..edges.len()).step_by(4) {
                let group = [0, 1, 2, 3].map(|k| edges[(first + k).min(edges.len() - 1)].faces);
                let normal = |face: u32| faces[face as usize].normal();
                out.edge_faces.push(EdgeFaces {
                    left: group.map(|[left, _]| left as u8),
                    right: group.map(|[_, right]| right as u8),
                    cosine: Vec4::from_array(group.map(|[left, right]| normal(left).dot(normal(right)))),
                });
            }
        }
        out
    }

    pub fn vertices_of(&self, hull: &TwinHull) -> &[Lanes] {
        &self.vertices[hull.first_vertices as usize..][..hull.vertex_groups as usize]
    }

    pub fn planes_of(&self, hull: &TwinHull) -> &[Planes] {
        &self.planes[hull.first_planes as usize..][..hull.plane_groups as usize]
    }

    pub fn edge_faces_of(&self, hull: &TwinHull) -> &[EdgeFaces] {
        &self.edge_faces[hull.first_edges as usize..][..hull.edge_groups as usize]
    }
}
