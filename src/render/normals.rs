//! Normals for meshes that come without: smooth over curved surfaces, sharp at edges.

use glam::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Cosine of the angle between two faces from which on their common edge is sharp: 40°.
const SHARP: f32 = 0.766;
/// Faces at a vertex beyond which its normals are those of the faces: fans of thousands would take squared time.
const CROWDED: usize = 64;

/// A unit normal for every corner, on the side of its triangle from which it is counter-clockwise. Vertices at the same
/// place count as one; neighbours that are turned the other way round are turned back. Triangles without area get
/// their edges' side or, failing that, up.
pub fn smooth(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Vec<[Vec3; 3]> {
    let welded = weld(vertices);
    let faces: Vec<Vec3> = triangles.iter().map(|t| area(t.map(|i| vertices[i as usize]))).collect();
    let units: Vec<Vec3> = faces.iter().map(|face| face.normalize_or(Vec3::Y)).collect();
    // Triangles at each vertex, one list after the other.
    let mut starts = vec![0_u32; vertices.len() + 1];
    for &i in triangles.as_flattened() {
        starts[welded[i as usize] as usize + 1] += 1;
    }
    for i in 0..vertices.len() {
        starts[i + 1] += starts[i];
    }
    let mut next = starts.clone();
    let mut around = vec![0_u32; 3 * triangles.len()];
    for (number, triangle) in triangles.iter().enumerate() {
        for &i in triangle {
            let place = &mut next[welded[i as usize] as usize];
            around[*place as usize] = number as u32;
            *place += 1;
        }
    }
    let corner = |triangle: usize, i: u32| {
        let own = units[triangle];
        let vertex = welded[i as usize] as usize;
        let neighbours = &around[starts[vertex] as usize..starts[vertex + 1] as usize];
        if neighbours.len() > CROWDED {
            return own;
        }
        let mut sum = Vec3::ZERO;
        for &other in neighbours {
            let side = units[other as usize].dot(own);
            if side.abs() >= SHARP {
                sum += faces[other as usize] * side.signum();
            }
        }
        sum.normalize_or(own)
    };
    triangles.par_iter().enumerate().map(|(number, t)| t.map(|i| corner(number, i))).collect()
}

/// Normal of a triangle, twice its area long.
pub fn area([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a)
}

/// For every vertex the first one at exactly its place.
fn weld(vertices: &[Vec3]) -> Vec<u32> {
    let mut first: HashMap<[u32; 3], u32> = HashMap::with_capacity(vertices.len());
    // Adding zero makes −0 the same as 0.
    let key = |v: &Vec3| (*v + Vec3::ZERO).to_array().map(f32::to_bits);
    vertices.iter().enumerate().map(|(i, v)| *first.entry(key(v)).or_insert(i as u32)).collect()
}

#[cfg(test)]
mod tests {
    use super::smooth;
    use glam::Vec3;

    /// Two squares that meet at an edge; the second is given from its back.
    fn bent(angle: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let far = Vec3::new(angle.cos(), angle.sin(), 0.0);
        let v = vec![Vec3::NEG_X, Vec3::NEG_X - Vec3::Z, Vec3::NEG_Z, Vec3::ZERO, far, far - Vec3::Z];
        (v, vec![[0, 3, 2], [0, 2, 1], [3, 2, 4], [2, 5, 4]])
    }

    #[test]
    fn gentle_bends_are_smooth_and_sharp_ones_are_not() {
        for (angle, smoothed) in [(0.3, true), (1.2, false)] {
            let (vertices, triangles) = bent(angle);
            let normals = smooth(&vertices, &triangles);
            let [at_edge, far] = [normals[0][1], normals[1][2]];
            assert!((normals[0][0] - Vec3::Y).length() < 0.3, "{normals:?}");
            assert_eq!((at_edge - far).length() > 0.05, smoothed, "{angle}: {normals:?}");
        }
    }

    #[test]
    fn triangles_without_area_have_a_normal() {
        let normals = smooth(&[Vec3::ZERO, Vec3::X], &[[0, 1, 1]]);
        assert!(normals[0].iter().all(|n| n.is_normalized()));
    }
}
