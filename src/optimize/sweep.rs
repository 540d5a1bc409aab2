//! Convex bodies that are shifted along a direction: at which shifts they overlap.

use glam::Vec3;
use parry3d::math::Pose as Isometry;
use parry3d::query::{ShapeCastOptions, cast_shapes};
use parry3d::shape::ConvexPolyhedron;

/// The shifts of `a` along the unit vector `axis` at which it is nearer to `b` than `clearance`, m: one interval, found
/// by bringing `a` up from either side. None if it passes by.
pub(super) fn overlap_interval(
    (at_a, a): (&Isometry, &ConvexPolyhedron),
    (at_b, b): (&Isometry, &ConvexPolyhedron),
    axis: Vec3,
    clearance: f32,
) -> Option<[f32; 2]> {
    let bounds = |at: &Isometry, solid: &ConvexPolyhedron| {
        let along = |v: &Vec3| (at.rotation * *v + at.translation).dot(axis);
        solid.points().iter().map(along).fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)))
    };
    let ((low_a, high_a), (low_b, high_b)) = (bounds(at_a, a), bounds(at_b, b));
    // Clear of each other by a centimetre more on either side.
    let spare = 0.01 + clearance;
    let (above, below) = (high_b - low_a + spare, low_b - high_a - spare);
    let travel = above - below;
    let cast = |from: f32, direction: f32| {
        let start = Isometry::from_parts(at_a.translation + axis * from, at_a.rotation);
        let options = ShapeCastOptions { max_time_of_impact: travel, target_distance: clearance, ..Default::default() };
        let hit = cast_shapes(&start, axis * direction, a, at_b, Vec3::ZERO, b, options);
        hit.ok().flatten().map(|hit| hit.time_of_impact)
    };
    Some([below + cast(below, 1.0)?, above - cast(above, -1.0)?])
}

/// The first shift from nought on that lies in none of the intervals, m; where two meet there is none between them.
pub(super) fn first_gap(mut intervals: Vec<[f64; 2]>) -> f64 {
    intervals.sort_by(|a, b| a[0].total_cmp(&b[0]));
    intervals.into_iter().fold(0.0, |at, [low, high]| if low <= at { high.max(at) } else { at })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn cube() -> ConvexPolyhedron {
        let corners = (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5);
        ConvexPolyhedron::from_convex_hull(&corners.collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn cubes_overlap_while_less_than_a_side_apart() {
        let (cube, origin) = (cube(), Isometry::IDENTITY);
        let interval = |at: Vec3, axis: Vec3, clearance: f32| {
            overlap_interval((&Isometry::from_translation(at), &cube), (&origin, &cube), axis, clearance)
        };
        let near = |found: Option<[f32; 2]>, [low, high]: [f32; 2]| {
            let [l, h] = found.unwrap();
            assert!((l - low).abs() < 1e-3 && (h - high).abs() < 1e-3, "{l} … {h}");
        };
        near(interval(Vec3::new(0.2, 3.0, 0.0), Vec3::Y, 0.0), [-4.0, -2.0]);
        near(interval(Vec3::new(3.0, 0.0, 0.2), Vec3::X, 0.1), [-4.1, -1.9]);
        assert!(interval(Vec3::new(2.0, 3.0, 0.0), Vec3::Y, 0.0).is_none());
    }

    #[test]
    fn the_first_gap_is_behind_all_that_meets_nought() {
        assert_eq!(first_gap(vec![[0.1, 0.2]]), 0.0);
        assert_eq!(first_gap(vec![[0.3, 0.5], [-1.0, 0.1], [0.1, 0.2], [0.0, 0.05]]), 0.2);
    }
}
