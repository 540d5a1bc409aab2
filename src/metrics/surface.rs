//! Triangles as a surface: points spread over it, and the nearest points on it.

use crate::shape::triangle::meet;
use glam::{DVec3, Vec3};
use parry3d::partitioning::BvhNode;
use parry3d::query::PointQuery;
use parry3d::shape::TriMesh;
use rayon::prelude::*;

/// Steps of the additive recurrence whose points fill the unit square evenly (Roberts 2018, the R2 sequence).
const EVEN: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];

/// Relative error of f32 boxes around f64 triangles, with some room.
const ROUNDING: f32 = 1e-6;

/// A surface that can be asked for its nearest points.
pub(super) struct Surface {
    /// In world coordinates, in the order of `mesh`.
    triangles: Vec<[DVec3; 3]>,
    mesh: TriMesh,
    /// Distances are measured from here, so that f32 is as fine far from the origin as near it, m.
    center: DVec3,
}

impl Surface {
    /// The surface of these triangles, m; none if all of them are degenerate.
    pub(super) fn new(triangles: &[[DVec3; 3]]) -> Option<Self> {
        let triangles: Vec<[DVec3; 3]> = triangles.iter().filter(|t| area(t) > 0.0).copied().collect();
        let [low, high] = super::bounds(triangles.iter().flat_map(|t| t.iter().copied()));
        let center = 0.5 * (low + high);
        let vertices: Vec<Vec3> = triangles.iter().flat_map(|t| t.map(|p| (p - center).as_vec3())).collect();
        let indices = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Some(Self { mesh: TriMesh::new(vertices, indices).ok()?, triangles, center })
    }

    /// The nearest point of the surface to each of `points`.
    pub(super) fn nearest(&self, points: &[DVec3]) -> Vec<DVec3> {
        let nearest = |p: &DVec3| {
            let found = self.mesh.project_local_point((*p - self.center).as_vec3(), false);
            found.point.as_dvec3() + self.center
        };
        points.par_iter().map(nearest).collect()
    }

    /// True if the two surfaces meet; touching counts. Decided in f64: what rests a micrometre above something is
    /// clear.
    pub(super) fn meets(&self, other: &Self) -> bool {
        let shift = (other.center - self.center).as_vec3();
        let near = |a: &BvhNode, b: &BvhNode| {
            let (a, b) = (a.aabb(), b.aabb());
            let slack = Vec3::splat(
                ROUNDING * (a.maxs.abs() + b.maxs.abs() + a.mins.abs() + b.mins.abs() + shift.abs()).max_element(),
            );
            (a.mins - slack).cmple(b.maxs + shift).all() && (b.mins + shift).cmple(a.maxs + slack).all()
        };
        let pairs = self.mesh.bvh().leaf_pairs(other.mesh.bvh(), near);
        pairs.into_iter().any(|(i, j)| meet(&self.triangles[i as usize], &other.triangles[j as usize]))
    }

    /// Distance of each of `points` from the surface, m.
    pub(super) fn distances(&self, points: &[DVec3]) -> Vec<f64> {
        self.nearest(points).iter().zip(points).map(|(a, b)| a.distance(*b)).collect()
    }
}

/// `count` points spread over the triangles by area, always the same ones; none if there is no area.
pub(super) fn spread(triangles: &[[DVec3; 3]], count: usize) -> Vec<DVec3> {
    let total: f64 = triangles.iter().map(area).sum();
    let mut points = Vec::with_capacity(count);
    let mut passed = 0.0;
    for triangle in triangles {
        passed += area(triangle);
        // Point k stands for the k-th of `count` equal shares of the area.
        while points.len() < count && (points.len() as f64 + 0.5) * total <= passed * count as f64 && total > 0.0 {
            let k = points.len() as f64 + 1.0;
            let [mut u, mut v] = EVEN.map(|step| (k * step).fract());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let [a, b, c] = *triangle;
            points.push(a + u * (b - a) + v * (c - a));
        }
    }
    points
}

/// m².
fn area([a, b, c]: &[DVec3; 3]) -> f64 {
    0.5 * (*b - *a).cross(*c - *a).length()
}
