//! Convex hulls of points that may be very thin, or many of them in one plane.

use glam::{DVec3, Vec3};
use parry3d::transformation::try_convex_hull;

/// Triangles fold over if what they take twice is more than this share of the volume.
const FOLDED: f32 = 1e-3;
/// So far are points shaken if they do, as a share of the largest coordinate: well above the rounding of f32, and less than a
/// hundredth of a millimetre for a table.
const SHAKE: f32 = 4e-6;
const SHAKES: u32 = 8;
/// The multiples of this are spread evenly over the unit cube, but for their integers (Roberts's R3 sequence).
const SCATTER: Vec3 = Vec3::new(0.819_172_5, 0.671_043_6, 0.549_700_5);

/// Corners and outward triangles of a hull.
pub(super) type HullMesh = (Vec<Vec3>, Vec<[u32; 3]>);

/// Corners and outward triangles of the convex hull; `None` for points without volume.
///
/// parry's hull takes a plate whose thickness is a thousandth of its length for a flat polygon. A linear map keeps
/// convexity, so the hull is taken of points whose covariance has been made the identity.
pub fn convex_hull(points: &[Vec3]) -> Option<HullMesh> {
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
    let (vertices, triangles) = unfolded_hull(&white).or_else(|| try_convex_hull(&white).ok())?;
    let vertices = originals(&vertices, &white, points)?;
    (vertices.len() >= 4 && triangles.len() >= 4).then_some((vertices, triangles))
}

/// parry's hull of points, if its triangles do not fold over. Where many points lie in one plane they do now and then: a
/// piece of a round foot has lost 7 % of its volume. Points that are shaken a little lie in no plane.
pub(super) fn unfolded_hull(points: &[Vec3]) -> Option<HullMesh> {
    let plain = try_convex_hull(points).ok().filter(|hull| !is_folded(hull));
    plain.or_else(|| (1..=SHAKES).find_map(|round| shaken_hull(points, round).filter(|hull| !is_folded(hull))))
}

fn shaken_hull(points: &[Vec3], round: u32) -> Option<HullMesh> {
    let size = points.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
    let shaken = |(i, p): (usize, &Vec3)| {
        let noise = ((i as u32 * SHAKES + round) as f32 * SCATTER).fract() - 0.5;
        p + SHAKE * size * noise
    };
    let shaken: Vec<Vec3> = points.iter().enumerate().map(shaken).collect();
    let (vertices, triangles) = try_convex_hull(&shaken).ok()?;
    Some((originals(&vertices, &shaken, points)?, triangles))
}

/// The points that became these vertices when they were moved.
fn originals(vertices: &[Vec3], moved: &[Vec3], points: &[Vec3]) -> Option<Vec<Vec3>> {
    vertices.iter().map(|v| moved.iter().position(|m| m == v).map(|i| points[i])).collect()
}

/// True if vertices lie above triangles: what tetrahedra between them hold would be taken for volume.
fn is_folded((vertices, triangles): &HullMesh) -> bool {
    let origin = vertices.first().copied().unwrap_or_default();
    let (mut volume, mut folds) = (0.0, 0.0);
    for t in triangles {
        let [a, b, c] = t.map(|i| vertices[i as usize]);
        let normal = (b - a).cross(c - a);
        volume += (a - origin).dot(normal);
        folds += vertices.iter().map(|v| normal.dot(*v - a)).fold(0.0, f32::max);
    }
    folds > FOLDED * volume
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::split::clip;
    use super::*;
    use glam::Vec2;
    use std::f32::consts::TAU;

    /// Halves of the feet of lamps: many points in one plane, several of them in one line.
    fn halves() -> impl Iterator<Item = Vec<Vec3>> {
        (0..500).flat_map(|n| {
            let corner = |radius: f32, i: usize| radius * Vec2::from_angle(TAU * i as f32 / 16.0 + 0.3);
            let ring = |radius: f32, y: f32| {
                let corners = (0..16).map(move |i| corner(radius, i));
                corners.map(move |p| Vec3::new(p.x, y, p.y)).collect::<Vec<_>>()
            };
            let radius = 0.1 + 4e-4 * n as f32;
            let foot = [ring(radius, 0.0), ring(0.9 * radius, 0.02), ring(0.01, 0.04)].concat();
            let (vertices, triangles) = try_convex_hull(&foot).unwrap();
            let triangles: Vec<[Vec3; 3]> = triangles.iter().map(|t| t.map(|i| vertices[i as usize])).collect();
            let across = corner(radius, n % 8 + 8) - corner(radius, n % 8);
            let normal = Vec3::new(-across.y, 3e-7 * n as f32, across.x).normalize();
            clip(&triangles, normal, normal.dot(foot[n % 8])).map(|side| merged(side.as_flattened()))
        })
    }

    /// The points, one for each cell of a fine grid.
    fn merged(points: &[Vec3]) -> Vec<Vec3> {
        let cell = |p: &Vec3| (p * 5e6).round().to_array().map(|c| c as i64);
        let mut points = points.to_vec();
        points.sort_by_key(cell);
        points.dedup_by_key(|p| cell(p));
        points
    }

    #[test]
    fn no_triangle_folds_over() {
        let plain = halves().filter(|half| try_convex_hull(half).is_ok_and(|hull| is_folded(&hull))).count();
        let ours = halves().filter(|half| convex_hull(half).is_none_or(|hull| is_folded(&hull))).count();
        let unfolded = halves().filter(|half| unfolded_hull(half).is_none()).count();
        assert!(plain > 0, "parry folds none of these: they show nothing");
        assert_eq!((ours, unfolded), (0, 0), "of {plain} that parry folds");
    }
}
