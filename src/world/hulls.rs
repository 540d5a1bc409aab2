//! Flat tables of convex hulls: vertices, face polygons, edges.

use super::constants::{COPLANAR_DISTANCE, COPLANAR_SHARE};
use super::outline::Outline;
use super::polygons::polygons;
use crate::shape::convex_hull;
use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};

/// One convex hull. Offsets point into the shared tables; vertex and face numbers inside them are local to the hull.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Hull {
    /// First vertex in `HullTables::vertices`.
    pub first_vertex: u32,
    /// Number of vertices.
    pub vertex_count: u32,
    /// First face in `HullTables::faces`.
    pub first_face: u32,
    /// Number of faces.
    pub face_count: u32,
    /// First edge in `HullTables::edges`.
    pub first_edge: u32,
    /// Number of edges.
    pub edge_count: u32,
    /// Largest distance of a vertex from `center`, m.
    pub radius: f32,
    pad: u32,
    /// Centre of the box around the hull, body frame, m. Lies inside the hull's box, not always inside the hull.
    pub center: Vec3,
    pad1: f32,
    /// Half extents of that box along the body's axes, m.
    pub half_extents: Vec3,
    pad2: f32,
}

/// A face polygon: all coplanar triangles of the hull together. Where they have more than `MAX_FACE_VERTICES` corners,
/// they are several faces, one after the other, with the same plane to the bit.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Face {
    /// Outward unit normal and offset: `n · x ≤ d` for every point of the hull, body frame.
    pub plane: Vec4,
    /// First corner in `HullTables::face_vertices`.
    pub first_corner: u32,
    /// Corners, counter-clockwise seen from outside, at most `MAX_FACE_VERTICES`.
    pub corner_count: u32,
    pad: [u32; 2],
}

impl Face {
    /// Outward unit normal.
    pub fn normal(&self) -> Vec3 {
        self.plane.truncate()
    }

    /// Where its corners start and end.
    fn corners(&self) -> [usize; 2] {
        [self.first_corner, self.first_corner + self.corner_count].map(|corner| corner as usize)
    }
}

/// An edge between two faces that are not coplanar.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Edge {
    /// Its ends, numbers within the hull.
    pub vertices: [u32; 2],
    /// The faces left and right of it, numbers within the hull.
    pub faces: [u32; 2],
}

/// All hulls of a world, ready to upload.
#[derive(Clone, Debug, Default)]
pub struct HullTables {
    /// One record a hull.
    pub hulls: Vec<Hull>,
    /// Vertices (w = 0), body frame, m.
    pub vertices: Vec<Vec4>,
    /// Face polygons.
    pub faces: Vec<Face>,
    /// Corners of the face polygons, vertex numbers within the hull.
    pub face_vertices: Vec<u32>,
    /// Edges.
    pub edges: Vec<Edge>,
    /// For every face, what it bears and where that ends.
    pub outlines: Vec<Outline>,
    /// What the outlines refer to.
    pub lines: Vec<Vec4>,
}

impl HullTables {
    /// Adds the hull of `points` (body frame, m). Points without volume are ignored: `shape` has given every part a
    /// minimal thickness.
    pub fn push(&mut self, points: &[Vec3]) {
        let Some((vertices, triangles)) = convex_hull(points) else {
            return;
        };
        let (low, high) =
            vertices.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        let center = 0.5 * (low + high);
        let radius = vertices.iter().map(|v| v.distance(center)).fold(0.0, f32::max);
        // A hull thinner than the tolerance would become two faces back to back: then only what is exactly flat is
        // joined.
        let tolerance = COPLANAR_DISTANCE.min(COPLANAR_SHARE * radius);
        let (mut faces, mut edges) = polygons(&vertices, &triangles, tolerance);
        if faces.len() < 4 {
            (faces, edges) = polygons(&vertices, &triangles, radius * f32::EPSILON);
        }
        let hull = Hull {
            first_vertex: self.vertices.len() as u32,
            vertex_count: vertices.len() as u32,
            first_face: self.faces.len() as u32,
            face_count: faces.len() as u32,
            first_edge: self.edges.len() as u32,
            edge_count: edges.len() as u32,
            radius,
            pad: 0,
            center,
            pad1: 0.0,
            half_extents: 0.5 * (high - low),
            pad2: 0.0,
        };
        self.hulls.push(hull);
        self.vertices.extend(vertices.iter().map(|v| v.extend(0.0)));
        for (plane, corners) in faces {
            self.faces.push(Face {
                plane,
                first_corner: self.face_vertices.len() as u32,
                corner_count: corners.len() as u32,
                pad: [0; 2],
            });
            self.face_vertices.extend(corners);
        }
        self.edges.extend(edges);
        let mut lines = std::mem::take(&mut self.lines);
        let outline = |face| Outline::push(self, &hull, face, &mut lines);
        let outlines: Vec<Outline> = (0..hull.face_count as usize).map(outline).collect();
        self.lines = lines;
        self.outlines.extend(outlines);
    }

    /// Vertices of a hull.
    pub fn vertices_of(&self, hull: &Hull) -> &[Vec4] {
        &self.vertices[hull.first_vertex as usize..][..hull.vertex_count as usize]
    }

    /// Faces of a hull.
    pub fn faces_of(&self, hull: &Hull) -> &[Face] {
        &self.faces[hull.first_face as usize..][..hull.face_count as usize]
    }

    /// Edges of a hull.
    pub fn edges_of(&self, hull: &Hull) -> &[Edge] {
        &self.edges[hull.first_edge as usize..][..hull.edge_count as usize]
    }

    /// Corners of face `face` (number within the hull) and of all in its plane, one polygon after the other. As one
    /// closed line it runs along every edge of the whole, and to and fro where that was cut.
    pub fn ring_of(&self, hull: &Hull, face: u32) -> &[u32] {
        let (faces, face) = (self.faces_of(hull), face as usize);
        let cut = |piece: &Face| piece.plane != faces[face].plane;
        let first = faces[..face].iter().rposition(cut).map_or(0, |before| before + 1);
        let last = faces[face..].iter().position(cut).map_or(faces.len(), |after| face + after) - 1;
        let [start, _] = faces[first].corners();
        let [_, end] = faces[last].corners();
        &self.face_vertices[start..end]
    }

    /// Lines around face `face` (number within the hull) and its nearly flat neighbours, and their planes.
    pub fn outline_of(&self, hull: &Hull, face: u32) -> (&[Vec4], &[Vec4]) {
        let Outline { first, lines, bearing } = self.outlines[(hull.first_face + face) as usize];
        self.lines[first as usize..][..(lines + bearing) as usize].split_at(lines as usize)
    }

    /// Corners of a face, vertex numbers within its hull.
    pub fn corners_of(&self, face: &Face) -> &[u32] {
        let [start, end] = face.corners();
        &self.face_vertices[start..end]
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::constants::MAX_FACE_VERTICES;
    use super::*;
    use crate::shape::box_corners;
    use glam::Quat;

    /// Points on a ball in a spiral: a hull without parallel faces.
    fn ball(count: usize, radius: f32) -> Vec<Vec3> {
        (0..count)
            .map(|i| {
                let y = 1.0 - 2.0 * (i as f32 + 0.5) / count as f32;
                let (sin, cos) = (2.4 * i as f32).sin_cos();
                radius * Vec3::new((1.0 - y * y).sqrt() * cos, y, (1.0 - y * y).sqrt() * sin)
            })
            .collect()
    }

    fn table(points: &[Vec3]) -> HullTables {
        let mut tables = HullTables::default();
        tables.push(points);
        tables
    }

    /// (vertices, edges, faces) after checking that the polygons close, face outwards and hold all points below them.
    fn counts(tables: &HullTables, points: &[Vec3]) -> [u32; 3] {
        let hull = tables.hulls[0];
        let vertices = tables.vertices_of(&hull);
        let at = |v: u32| vertices[v as usize].truncate();
        for face in tables.faces_of(&hull) {
            let corners = tables.corners_of(face);
            assert!(corners.len() >= 3);
            for k in 0..corners.len() {
                let [a, b, c] = [0, 1, 2].map(|n| at(corners[(k + n) % corners.len()]));
                assert!((b - a).cross(c - b).dot(face.normal()) >= 0.0, "not convex and counter-clockwise");
                assert!((face.normal().dot(a) - face.plane.w).abs() <= COPLANAR_DISTANCE);
            }
            for p in points {
                assert!(face.normal().dot(*p) <= face.plane.w + 1e-6 * hull.radius, "a point above a face");
            }
        }
        for edge in tables.edges_of(&hull) {
            let [left, right] = edge.faces.map(|f| tables.faces_of(&hull)[f as usize]);
            let along = at(edge.vertices[1]) - at(edge.vertices[0]);
            assert!(left.normal().cross(right.normal()).dot(along) > 0.0, "left and right exchanged, or concave");
        }
        [hull.vertex_count, hull.edge_count, hull.face_count]
    }

    #[test]
    fn boxes_plates_and_needles_have_six_faces_in_any_position() {
        // The plate is 2 m by 1 mm, the needle 1 m by 0.5 mm: parry alone takes them for flat.
        for half in [Vec3::new(0.3, 0.1, 0.2), Vec3::new(1.0, 0.0005, 0.7), Vec3::new(0.5, 0.00025, 0.00025)] {
            for turn in [Quat::IDENTITY, Quat::from_rotation_x(0.4) * Quat::from_rotation_z(0.7)] {
                let points: Vec<Vec3> =
                    box_corners(half).iter().map(|p| turn * *p + Vec3::new(0.2, -0.1, 0.3)).collect();
                assert_eq!(counts(&table(&points), &points), [8, 12, 6], "{half} {turn}");
            }
        }
    }

    #[test]
    fn round_hulls_are_closed() {
        for (count, radius) in [(12, 0.003), (24, 0.05), (64, 0.8)] {
            let points = ball(count, radius);
            let [v, e, f] = counts(&table(&points), &points);
            assert_eq!(v, count as u32);
            assert_eq!(v + f, e + 2, "Euler, {count} points");
        }
    }

    #[test]
    fn nearly_flat_triangles_become_one_face() {
        let mut points = box_corners(Vec3::new(0.2, 0.1, 0.2));
        points.extend((0..12).map(|i| {
            let (sin, cos) = (i as f32 * 0.53).sin_cos();
            Vec3::new(0.15 * cos, 0.1 + 0.00002 * (i % 3) as f32, 0.15 * sin)
        }));
        let tables = table(&points);
        assert_eq!(tables.hulls[0].face_count, 6);
        let top = tables.faces.iter().find(|f| f.plane.y > 0.99).unwrap();
        assert_eq!(tables.corners_of(top).len(), 4);
    }

    #[test]
    fn faces_of_many_corners_are_cut_and_keep_their_outline() {
        for (sides, kept, pieces) in [(16_usize, 16, 1), (17, 17, 2), (30, 30, 2), (32, 32, 3), (40, 32, 3)] {
            // A cone, so that one face has as many corners as there may be.
            let corner = |k: usize| {
                let (sin, cos) = (k as f32 / sides as f32 * std::f32::consts::TAU).sin_cos();
                Vec3::new(0.3 * cos, 0.0, 0.3 * sin)
            };
            let mut points: Vec<Vec3> = (0..sides).map(corner).collect();
            points.push(Vec3::Y * 0.4);
            let tables = table(&points);
            let hull = tables.hulls[0];
            let faces = tables.faces_of(&hull);
            let base = faces.iter().position(|face| face.plane.y < -0.999).unwrap();
            let cut = faces.iter().filter(|face| face.plane == faces[base].plane).count();
            assert_eq!(cut, pieces, "{sides} sides");
            assert!(faces.iter().all(|face| face.corner_count as usize <= MAX_FACE_VERTICES));
            for piece in base..base + cut {
                let ring = tables.ring_of(&hull, piece as u32);
                let mut corners = ring.to_vec();
                corners.sort_unstable();
                corners.dedup();
                assert_eq!((corners.len(), ring.len()), (kept, kept + 2 * (cut - 1)), "{sides} sides");
                let (lines, bearing) = tables.outline_of(&hull, piece as u32);
                assert_eq!((lines.len(), bearing.len()), (kept, cut), "{sides} sides");
                let reach = |line: &Vec4, p: Vec3| line.truncate().dot(p) - line.w;
                assert!(lines.iter().all(|line| reach(line, Vec3::ZERO) < -0.29), "an outline goes round the middle");
                if kept == sides {
                    assert!(lines.iter().all(|line| points.iter().all(|p| reach(line, p.with_y(0.0)) < 1e-6)));
                }
            }
        }
    }

    #[test]
    fn points_without_volume_are_ignored() {
        let flat: Vec<Vec3> = box_corners(Vec3::new(1.0, 0.0, 1.0));
        let line: Vec<Vec3> = (0..5).map(|i| Vec3::splat(i as f32)).collect();
        for points in [&[][..], &[Vec3::ONE], &[Vec3::ONE; 8], &flat, &line, &[Vec3::NAN; 4]] {
            assert!(table(points).hulls.is_empty(), "{points:?}");
        }
    }

    #[test]
    fn a_hull_thinner_than_the_tolerance_keeps_four_faces() {
        let points = [Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::new(1.0, 0.00005, 1.0)];
        assert_eq!(counts(&table(&points), &points), [4, 6, 4]);
    }
}
