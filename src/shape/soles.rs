//! Flat soles: where an object can stand, its parts end in one plane.
//!
//! The foot of a scanned vase is a dozen small triangles a few tenths of a millimetre apart, and it stands on three of
//! their corners. That is stable, but engines that make contacts between one face of each part (PhysX does) see it
//! stand on one triangle, then on another, and let it rock away. What lies that little above the plane on which an
//! object rests is let down onto it: a lower corner bears the object already, so it stands where it stood.

use super::hull::Hull;
use super::tolerances::soles::{DEPTH, DIRECTIONS, FLAT, HALVINGS, SLOPE};
use glam::{Vec2, Vec3, Vec4};
use std::f32::consts::TAU;

/// The parts of an object whose centre of mass is at `center`, with their vertices let down onto the planes on which it
/// can rest, those first that are nearest to the centre.
pub(super) fn flattened(hulls: Vec<Hull>, center: Vec3) -> Vec<Hull> {
    let mut parts: Vec<Vec<Vec3>> = hulls.iter().map(|hull| hull.vertices.clone()).collect();
    let Some(whole) = Hull::new(&parts.concat()) else { return hulls };
    let mut moved: Vec<Vec<bool>> = parts.iter().map(|part| vec![false; part.len()]).collect();
    let mut planes = whole.planes;
    let height = |plane: &Vec4| plane.w - plane.truncate().dot(center);
    planes.sort_by(|a, b| height(a).total_cmp(&height(b)));
    for plane in planes {
        let above = |vertex: Vec3| plane.w - plane.truncate().dot(vertex);
        // Another plane has taken what this one would go through.
        if parts.iter().flatten().any(|&vertex| above(vertex) < -FLAT) {
            continue;
        }
        let depths = (0..=HALVINGS).map(|halvings| DEPTH * 0.5_f32.powi(halvings));
        let sole = |depth: f32| parts.iter().flatten().copied().filter(move |&vertex| above(vertex) <= depth);
        let Some(depth) = depths.into_iter().find(|&depth| depth <= SLOPE * reach(sole(depth), plane, center)) else {
            continue;
        };
        for (vertex, moved) in parts.iter_mut().flatten().zip(moved.iter_mut().flatten()) {
            let above = above(*vertex);
            if above > FLAT && above <= depth && !*moved {
                *vertex += above * plane.truncate();
                *moved = true;
            }
        }
    }
    let flattened = |((hull, part), moved): ((Hull, Vec<Vec3>), Vec<bool>)| match moved.contains(&true) {
        true => Hull::new(&part).filter(|flat| flat.vertices.len() <= hull.vertices.len()).unwrap_or(hull),
        false => hull,
    };
    hulls.into_iter().zip(parts).zip(moved).map(flattened).collect()
}

/// How far points in a plane reach around the point of it below the centre, in the direction in which they reach least,
/// m; negative if it lies outside.
fn reach(points: impl Iterator<Item = Vec3>, plane: Vec4, center: Vec3) -> f32 {
    let (u, v) = plane.truncate().any_orthonormal_pair();
    let mut supports = [f32::NEG_INFINITY; DIRECTIONS];
    for point in points {
        let offset = Vec2::new(u.dot(point - center), v.dot(point - center));
        for (i, support) in supports.iter_mut().enumerate() {
            *support = support.max(Vec2::from_angle(TAU * i as f32 / DIRECTIONS as f32).dot(offset));
        }
    }
    supports.into_iter().fold(f32::INFINITY, f32::min)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const SIDES: usize = 12;

    /// A pot of 8 cm, 10 cm high, whose foot is uneven by `rough` (m) and stands on three of its corners.
    fn pot(rough: f32) -> Hull {
        let ring = |height: fn(usize, f32) -> f32| {
            (0..SIDES).map(move |i| {
                let around = 0.04 * Vec2::from_angle(TAU * i as f32 / SIDES as f32);
                Vec3::new(around.x, height(i, rough), around.y)
            })
        };
        let foot = ring(|i, rough| if i % 4 == 0 { 0.0 } else { rough * (1 + i % 3) as f32 / 3.0 });
        Hull::new(&foot.chain(ring(|_, _| 0.1)).collect::<Vec<_>>()).unwrap()
    }

    fn lowest(hull: &Hull, within: f32) -> usize {
        hull.vertices.iter().filter(|vertex| vertex.y.abs() <= within).count()
    }

    #[test]
    fn a_rough_foot_becomes_flat_and_keeps_its_height() {
        let pot = pot(0.4e-3);
        assert_eq!(lowest(&pot, 1e-5), 3, "the pot stands on three corners");
        let flat = flattened(vec![pot], Vec3::Y * 0.05).remove(0);
        assert_eq!(lowest(&flat, 1e-5), SIDES);
        let (low, high) = flat.bounds();
        assert!(low.y.abs() < 1e-6 && (high.y - 0.1).abs() < 1e-6, "{low} to {high}");
    }

    #[test]
    fn a_foot_that_is_rougher_stays() {
        let pot = pot(1.8e-3);
        let flat = flattened(vec![pot.clone()], Vec3::Y * 0.05).remove(0);
        assert!(flat.vertices == pot.vertices, "it has changed");
    }

    #[test]
    fn a_ball_stays_round() {
        // Evenly spread (Fibonacci's spiral).
        let point = |i: i32| {
            let y = 1.0 - (2.0 * i as f32 + 1.0) / 200.0;
            let around = (1.0 - y * y).sqrt() * Vec2::from_angle(2.399_963 * i as f32);
            0.04 * Vec3::new(around.x, y, around.y)
        };
        let ball = Hull::new(&(0..200).map(point).collect::<Vec<_>>()).unwrap();
        let flat = flattened(vec![ball.clone()], Vec3::ZERO).remove(0);
        let change =
            |vertex: &Vec3| ball.vertices.iter().map(|was| was.distance(*vertex)).fold(f32::INFINITY, f32::min);
        let most = flat.vertices.iter().map(change).fold(0.0, f32::max);
        assert!(flat.vertices.len() > 190 && most < 0.15e-3, "{} vertices, {most} m", flat.vertices.len());
    }
}
