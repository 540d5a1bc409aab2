//! What a face bears and where that ends. It depends on the hull alone, so a device gets it as a table.

use crate::world::constants::{COPLANAR_COSINE, MAX_HULL_FACES, MAX_LINES};
use crate::world::{Face, Hull, HullTables};
use glam::{Vec3, Vec4};

/// True for the face with this normal and every face that is nearly as flat: what rests on one rests on all.
pub fn bears(face: &Face, normal: Vec3) -> bool {
    face.normal().dot(normal) >= COPLANAR_COSINE
}

/// The lines around a face and its nearly flat neighbours.
#[derive(Clone, Debug)]
pub struct Outline {
    lines: [Vec4; MAX_LINES],
    count: usize,
}

impl Outline {
    /// The lines of face `face` (number within the hull).
    ///
    /// Each steep face round the bearing ones gives one, through its edges with them. A plate's top that is chamfered by
    /// a tenth of a degree is one surface: clipping against one facet alone would drop half of what rests on it.
    pub fn new(tables: &HullTables, hull: &Hull, face: u32) -> Self {
        let faces = tables.faces_of(hull);
        let plane = faces[face as usize].plane;
        let normal = plane.truncate();
        let vertex = |v: u32| tables.vertices_of(hull)[v as usize].truncate();
        let mut outline = Self { lines: [Vec4::ZERO; MAX_LINES], count: 0 };
        if faces.iter().filter(|face| bears(face, normal)).count() == 1 {
            let corners = tables.corners_of(&faces[face as usize]);
            let corner = |k: usize| vertex(corners[k % corners.len()]);
            for k in 0..corners.len() {
                let outward = (corner(k + 1) - corner(k)).cross(normal).normalize_or_zero();
                outline.lines[k] = outward.extend(outward.dot(corner(k)));
            }
            outline.count = corners.len();
            return outline;
        }
        let mut line_of = [MAX_LINES; MAX_HULL_FACES];
        for edge in tables.edges_of(hull) {
            let steep = match edge.faces.map(|f| bears(&faces[f as usize], normal)) {
                [true, false] => edge.faces[1] as usize,
                [false, true] => edge.faces[0] as usize,
                _ => continue,
            };
            if line_of[steep] == MAX_LINES {
                if outline.count == MAX_LINES {
                    continue;
                }
                let outward = faces[steep].normal().reject_from_normalized(normal).normalize_or_zero();
                outline.lines[outline.count] = outward.extend(f32::NEG_INFINITY);
                line_of[steep] = outline.count;
                outline.count += 1;
            }
            let line = &mut outline.lines[line_of[steep]];
            for v in edge.vertices {
                line.w = line.w.max(line.truncate().dot(vertex(v)));
            }
        }
        // No farther than where the steep face cuts the reference plane: a flat slope reaches far below it.
        for (steep, &line) in line_of.iter().enumerate().filter(|(_, line)| **line < MAX_LINES) {
            let cosine = normal.dot(faces[steep].normal());
            let limit = (faces[steep].plane.w - cosine * plane.w) / (1.0 - cosine * cosine).sqrt();
            outline.lines[line].w = outline.lines[line].w.min(limit);
        }
        outline
    }

    /// Outward unit directions across the normal and, as w, how far the outline reaches along them, m.
    pub fn lines(&self) -> &[Vec4] {
        &self.lines[..self.count]
    }
}
