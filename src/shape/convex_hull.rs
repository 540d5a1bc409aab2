//! Convex hulls of points that may be very thin.

use glam::{DVec3, Vec3};
use parry3d::transformation::try_convex_hull;

/// Corners and outward triangles of the convex hull; `None` for points without volume.
///
/// parry's hull takes a plate whose thickness is a thousandth of its length for a flat polygon. A linear map keeps
/// convexity, so the hull is taken of points whose covariance has been made the identity.
pub fn convex_hull(points: &[Vec3]) -> Option<(Vec<Vec3>, Vec<[u32; 3]>)> {
    let mean = points.iter().map(|p| p.as_dvec3()).sum::<DVec3>() / points.len().max(1) as f64;
    let mut covariance = [[0.0; 3]; 3];
    for d in points.iter().map(|p| (p.as_dvec3() - mean).to_array()) {
        for (i, row) in covariance.iter_mut().enumerate() {
            (0..3).for_each(|j| row[j] += d[i] * d[j] / points.len() as f64);
        }
    }
    // Cholesky: covariance = L Lᵀ. Below f32's resolution there is no volume.
    let mut l = [[0.0; 3]; 3];
    let flat = (f64::from(f32::EPSILON) * f64::from(points.iter().map(|p| p.length()).fold(0.0, f32::max))).powi(2);
    for i in 0..3 {
        for j in 0..=i {
            let rest = covariance[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            if i == j && (rest <= flat || rest.is_nan()) {
                return None;
            }
            l[i][j] = if i == j { rest.sqrt() } else { rest / l[j][j] };
        }
    }
    let white: Vec<Vec3> = points
        .iter()
        .map(|p| {
            let d = p.as_dvec3() - mean;
            let x = d.x / l[0][0];
            let y = (d.y - l[1][0] * x) / l[1][1];
            let z = (d.z - l[2][0] * x - l[2][1] * y) / l[2][2];
            DVec3::new(x, y, z).as_vec3()
        })
        .collect();
    let (vertices, triangles) = try_convex_hull(&white).ok()?;
    let original = |v: &Vec3| white.iter().position(|w| w == v).map(|i| points[i]);
    let vertices: Vec<Vec3> = vertices.iter().map(original).collect::<Option<_>>()?;
    (vertices.len() >= 4 && triangles.len() >= 4).then_some((vertices, triangles))
}
