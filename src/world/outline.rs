//! What a face bears and where that ends. It depends on the hull alone, so it is a table.

use super::constants::{COPLANAR_COSINE, MAX_LINES};
use super::hulls::{Face, Hull, HullTables};
use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};

/// Where a face's lines are in `HullTables::lines`.
///
/// The outline goes round the face and its nearly flat neighbours: each steep face round the bearing ones gives one
/// line, through its edges with them. A plate's top that is chamfered by a tenth of a degree is one surface: clipping
/// against one facet alone would drop half of what rests on it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Outline {
    /// First of the outline's lines (outward unit direction across the face's normal and, as w, how far the outline
    /// reaches along it, m); the planes of the faces that bear with it, its own among them, follow.
    pub first: u32,
    /// Number of lines.
    pub lines: u32,
    /// Number of planes.
    pub bearing: u32,
}

/// True for the face with this normal and every face that is nearly as flat: what rests on one rests on all.
fn bears(face: &Face, normal: Vec3) -> bool {
    face.normal().dot(normal) >= COPLANAR_COSINE
}

impl Outline {
    /// Writes the lines of face `face` (number within the hull) behind `out`.
    pub(super) fn push(tables: &HullTables, hull: &Hull, face: usize, out: &mut Vec<Vec4>) -> Self {
        let faces = tables.faces_of(hull);
        let normal = faces[face].normal();
        let first = out.len();
        let plane = faces[face].plane;
        if faces.iter().all(|other| other.plane == plane || !bears(other, normal)) {
            around_polygon(tables, hull, face, out);
        } else {
            around_several(tables, hull, plane, out);
        }
        let planes = out.len();
        out.extend(faces.iter().filter(|face| bears(face, normal)).map(|face| face.plane));
        Self { first: first as u32, lines: (planes - first) as u32, bearing: (out.len() - planes) as u32 }
    }
}

/// A line for every side of the face.
fn around_polygon(tables: &HullTables, hull: &Hull, face: usize, out: &mut Vec<Vec4>) {
    let (normal, vertices) = (tables.faces_of(hull)[face].normal(), tables.vertices_of(hull));
    let mut corners: Vec<u32> = Vec::new();
    for &corner in tables.ring_of(hull, face as u32) {
        if !corners.contains(&corner) {
            corners.push(corner);
        }
    }
    let corner = |k: usize| vertices[corners[k % corners.len()] as usize].truncate();
    out.extend((0..corners.len()).map(|k| {
        let outward = (corner(k + 1) - corner(k)).cross(normal).normalize_or_zero();
        outward.extend(outward.dot(corner(k)))
    }));
}

/// A line for every steep face beside the faces that bear with `plane`.
fn around_several(tables: &HullTables, hull: &Hull, plane: Vec4, out: &mut Vec<Vec4>) {
    let (faces, vertices, normal) = (tables.faces_of(hull), tables.vertices_of(hull), plane.truncate());
    let first = out.len();
    let mut line_of = vec![None; faces.len()];
    for edge in tables.edges_of(hull) {
        let steep = match edge.faces.map(|f| bears(&faces[f as usize], normal)) {
            [true, false] => edge.faces[1] as usize,
            [false, true] => edge.faces[0] as usize,
            _ => continue,
        };
        if line_of[steep].is_none() {
            if out.len() - first == MAX_LINES {
                continue;
            }
            let outward = faces[steep].normal().reject_from_normalized(normal).normalize_or_zero();
            line_of[steep] = Some(out.len());
            out.push(outward.extend(f32::NEG_INFINITY));
        }
        let Some(line) = line_of[steep].map(|index| &mut out[index]) else { continue };
        for v in edge.vertices {
            line.w = line.w.max(line.truncate().dot(vertices[v as usize].truncate()));
        }
    }
    // No farther than where the steep face cuts the reference plane: a flat slope reaches far below it.
    for (steep, index) in line_of.iter().enumerate().filter_map(|(steep, line)| Some((steep, (*line)?))) {
        let cosine = normal.dot(faces[steep].normal());
        let limit = (faces[steep].plane.w - cosine * plane.w) / (1.0 - cosine * cosine).sqrt();
        out[index].w = out[index].w.min(limit);
    }
}
