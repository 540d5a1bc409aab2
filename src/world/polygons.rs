//! Faces of a hull: its triangles joined to polygons that a kernel can go round.

use super::constants::{COPLANAR_COSINE, MAX_FACE_VERTICES, MAX_LINES};
use super::hulls::Edge;
use glam::{Vec2, Vec3, Vec4};
use std::collections::BTreeMap;

/// Planes with their rings of corners, and edges.
type Polygons = (Vec<(Vec4, Vec<u32>)>, Vec<Edge>);

/// Joins neighbouring triangles within `tolerance` (m) of one plane to polygons, largest triangle first, and lists the
/// edges between polygons.
pub(super) fn polygons(vertices: &[Vec3], triangles: &[[u32; 3]], tolerance: f32) -> Polygons {
    let corner = |t: usize, k: usize| vertices[triangles[t][k] as usize];
    let area_normal: Vec<Vec3> =
        (0..triangles.len()).map(|t| (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0))).collect();
    // Directed edge → triangle on its left; a BTreeMap so that the tables do not depend on a hasher.
    let mut left: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for (t, tri) in triangles.iter().enumerate() {
        for k in 0..3 {
            left.insert([tri[k], tri[(k + 1) % 3]], t);
        }
    }
    let mut order: Vec<usize> = (0..triangles.len()).collect();
    order.sort_by(|&a, &b| area_normal[b].length_squared().total_cmp(&area_normal[a].length_squared()).then(a.cmp(&b)));

    const NONE: usize = usize::MAX;
    let mut face_of = vec![NONE; triangles.len()];
    let mut faces: Vec<(Vec4, Vec<u32>)> = Vec::new();
    for &seed in &order {
        if face_of[seed] != NONE {
            continue;
        }
        let Some(normal) = area_normal[seed].try_normalize() else {
            continue;
        };
        let offset = normal.dot(corner(seed, 0));
        let face = faces.len();
        face_of[seed] = face;
        let mut members = vec![seed];
        let mut next = 0;
        while next < members.len() {
            let tri = triangles[members[next]];
            next += 1;
            for k in 0..3 {
                let Some(&t) = left.get(&[tri[(k + 1) % 3], tri[k]]) else {
                    continue;
                };
                let flat = (0..3).all(|k| (normal.dot(corner(t, k)) - offset).abs() <= tolerance);
                // A sliver has no normal of its own: lying in the plane is enough.
                let aligned = area_normal[t].try_normalize().is_none_or(|n| n.dot(normal) >= COPLANAR_COSINE);
                if face_of[t] == NONE && flat && aligned {
                    face_of[t] = face;
                    members.push(t);
                }
            }
        }
        let mut corners: Vec<u32> = members.iter().flat_map(|&t| triangles[t]).collect();
        corners.sort_unstable();
        corners.dedup();
        let ring = thin(vertices, normal, ring(vertices, normal, &corners));
        // All vertices lie below the plane, so that no support is missed.
        let offset = vertices.iter().map(|v| normal.dot(*v)).fold(f32::NEG_INFINITY, f32::max);
        faces.extend(pieces(&ring).into_iter().map(|corners| (normal.extend(offset), corners)));
    }
    let mut edges = Vec::new();
    for (&[a, b], &t) in &left {
        if a < b
            && let Some(&u) = left.get(&[b, a])
            && face_of[t] != face_of[u]
            && face_of[t] != NONE
            && face_of[u] != NONE
        {
            edges.push(Edge { vertices: [a, b], faces: [face_of[t] as u32, face_of[u] as u32] });
        }
    }
    (faces, edges)
}

/// The convex polygon around `corners` seen against `normal`, counter-clockwise (Andrew's monotone chain).
fn ring(vertices: &[Vec3], normal: Vec3, corners: &[u32]) -> Vec<u32> {
    let (u, v) = normal.any_orthonormal_pair();
    let flat = |i: u32| Vec2::new(u.dot(vertices[i as usize]), v.dot(vertices[i as usize]));
    let mut sorted = corners.to_vec();
    sorted.sort_by(|&a, &b| {
        let (p, q) = (flat(a), flat(b));
        p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y))
    });
    let half = |points: &mut dyn Iterator<Item = u32>| {
        let mut chain: Vec<u32> = Vec::new();
        for p in points {
            while chain.len() >= 2 {
                let (a, b) = (flat(chain[chain.len() - 2]), flat(chain[chain.len() - 1]));
                if (b - a).perp_dot(flat(p) - a) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut lower = half(&mut sorted.iter().copied());
    lower.extend(half(&mut sorted.iter().rev().copied()));
    lower
}

/// Leaves out the corners that cost the polygon the least area until an outline can go round it.
fn thin(vertices: &[Vec3], normal: Vec3, mut corners: Vec<u32>) -> Vec<u32> {
    while corners.len() > MAX_LINES {
        let n = corners.len();
        let at = |i: usize| vertices[corners[i % n] as usize];
        let loss = |i: usize| normal.dot((at(i) - at(i + n - 1)).cross(at(i + 1) - at(i))).abs();
        let least = (0..n).min_by(|&a, &b| loss(a).total_cmp(&loss(b))).unwrap_or(0);
        corners.remove(least);
    }
    corners
}

/// Cuts a polygon, from its first corner, into polygons of at most `MAX_FACE_VERTICES`.
fn pieces(ring: &[u32]) -> Vec<Vec<u32>> {
    let mut pieces = Vec::new();
    let mut rest = ring.to_vec();
    while rest.len() > MAX_FACE_VERTICES {
        pieces.push(rest[..MAX_FACE_VERTICES].to_vec());
        rest.drain(1..MAX_FACE_VERTICES - 1);
    }
    pieces.push(rest);
    pieces
}
