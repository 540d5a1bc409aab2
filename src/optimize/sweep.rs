//! How far one convex part has to go along a direction to leave another.

use glam::Vec3;
use parry3d::math::Pose as Isometry;
use parry3d::query::{ShapeCastOptions, cast_shapes};
use parry3d::shape::ConvexPolyhedron;

/// Room between the places from which two parts are moved towards each other, m.
const CLEAR: f32 = 0.01;

/// The shifts along the unit vector `along`, from the shift `from` on, at which `a` overlaps `b`, m: one interval, found by
/// moving `a` towards `b` from either side; none if they pass each other.
pub(super) fn overlap_interval(
    a: &ConvexPolyhedron,
    from: Vec3,
    b: &ConvexPolyhedron,
    along: Vec3,
) -> Option<[f32; 2]> {
    let ([low_a, high_a], [low_b, high_b]) = (extent(a, along), extent(b, along));
    let ahead = from.dot(along);
    let (above, below) = (high_b - low_a - ahead + CLEAR, low_b - high_a - ahead - CLEAR);
    let travel = above - below;
    let cast = |at: f32, direction: f32| {
        let start = Isometry::from_translation(from + along * at);
        let options = ShapeCastOptions { max_time_of_impact: travel, ..Default::default() };
        let hit = cast_shapes(&start, along * direction, a, &Isometry::IDENTITY, Vec3::ZERO, b, options);
        hit.ok().flatten().map(|hit| hit.time_of_impact)
    };
    Some([below + cast(below, 1.0)?, above - cast(above, -1.0)?])
}

/// The lowest and the highest point along a direction, m.
fn extent(solid: &ConvexPolyhedron, along: Vec3) -> [f32; 2] {
    let heights = solid.points().iter().map(|point| point.dot(along));
    heights.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], height| [low.min(height), high.max(height)])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn cube(center: Vec3) -> ConvexPolyhedron {
        let corners = (0..8).map(|i| center + Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5);
        ConvexPolyhedron::from_convex_hull(&corners.collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn cubes_overlap_while_less_than_a_side_apart() {
        for along in [Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::Z] {
            let beside = along.any_orthonormal_vector() * 0.2;
            let [low, high] = overlap_interval(&cube(beside), along * 3.0, &cube(Vec3::ZERO), along).unwrap();
            assert!((low + 4.0).abs() < 1e-3 && (high + 2.0).abs() < 1e-3, "{along}: {low} … {high}");
            assert!(overlap_interval(&cube(beside), beside * 5.0, &cube(Vec3::ZERO), along).is_none());
        }
    }
}
