//! The bases on which a mesh could stand: faces of its convex hull that hold the centre of mass above them and are
//! flat.
//!
//! Feet of a chair, the rim of a plate and the bottom of a box all make such a face, and its direction is that of the
//! object's up, whatever frame the mesh was modelled in. The pole of something round makes one too, in any direction;
//! it is told by its area, which grows with the height at which it is cut.

use super::tolerances::{AGREEMENT, BASE_BAND, FLAT, MAX_BASES, MIN_MARGIN, ROUND_BAND, SAME_BASE, SPREAD, UNEVENNESS};
use crate::shape::{convex_polygon, solid_hull};
use glam::{DVec2, DVec3, Vec3};
use std::cmp::Reverse;

/// One way for a mesh to stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stance {
    /// Up when it stands so, mesh frame, unit.
    pub up: DVec3,
    /// Of the support polygon, m².
    pub area: f64,
    /// Share of the area that the base does not gain a little higher up: 1 for feet and boxes.
    pub flatness: f64,
}

impl Stance {
    /// What its direction counts for, from 0 to 1: the inverse of its variance, which falls with the length of the
    /// base.
    pub fn weight(&self) -> f64 {
        let spread = SPREAD * SPREAD;
        self.flatness * spread / (spread + UNEVENNESS * UNEVENNESS / self.area)
    }
}

/// The stances of a mesh (scaled, m), the largest faces first, and the centre of its convex hull.
pub(super) fn stances(vertices: &[Vec3]) -> (Vec<Stance>, DVec3) {
    let Some((corners, triangles)) = solid_hull(vertices) else {
        let sum: DVec3 = vertices.iter().map(|v| v.as_dvec3()).sum();
        return (Vec::new(), sum / vertices.len().max(1) as f64);
    };
    let corners: Vec<DVec3> = corners.iter().map(|v| v.as_dvec3()).collect();
    let center = centroid(&corners, &triangles);
    let diagonal = (corners.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max)
        - corners.iter().copied().fold(DVec3::INFINITY, DVec3::min))
    .length();
    let found = faces(&corners, &triangles)
        .into_iter()
        .filter_map(|(normal, at)| {
            let (x, y) = normal.any_orthonormal_pair();
            let base = |band: f64| {
                let near = corners.iter().filter(|v| normal.dot(at - **v) <= band * diagonal);
                convex_polygon(near.map(|v| DVec2::new(x.dot(*v), y.dot(*v))).collect())
            };
            let foot = base(BASE_BAND);
            let area = area(&foot);
            let flatness = area / self::area(&base(ROUND_BAND));
            let within = margin(&foot, DVec2::new(x.dot(center), y.dot(center)));
            (within >= MIN_MARGIN && flatness >= FLAT).then_some(Stance { up: -normal, area, flatness })
        })
        .collect();
    (found, center)
}

/// The stance whose up is nearest to `up` (mesh frame) within `limit` (rad), large bases preferred.
pub(super) fn nearest(stances: &[Stance], up: DVec3, limit: f64) -> Option<&Stance> {
    let reachable = stances.iter().filter(|stance| stance.up.angle_between(up) <= limit);
    let score = |stance: &Stance| support(stance.up, up) * stance.area.sqrt() * stance.flatness;
    reachable.max_by(|a, b| score(a).total_cmp(&score(b)))
}

/// Cauchy's weight of one direction for another, from 0 to 1.
pub(super) fn support(of: DVec3, other: DVec3) -> f64 {
    1.0 / (1.0 + of.distance_squared(other) / (AGREEMENT * AGREEMENT))
}

/// True if a line from the `center` of upright `vertices` (m) along `down` meets the base that they stand on.
pub(super) fn is_over_base(vertices: &[DVec3], center: DVec3, down: DVec3) -> bool {
    let [low, high] = vertices.iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[l, h], v| [l.min(*v), h.max(*v)]);
    let near = vertices.iter().filter(|v| v.y - low.y <= BASE_BAND * low.distance(high));
    let foot = convex_polygon(near.map(|v| DVec2::new(v.x, v.z)).collect());
    let at = center + down * ((low.y - center.y) / down.y);
    margin(&foot, DVec2::new(at.x, at.z)) >= 0.0
}

/// Outward normal and a corner of the largest faces, those of almost the same direction once.
fn faces(corners: &[DVec3], triangles: &[[u32; 3]]) -> Vec<(DVec3, DVec3)> {
    let mut all: Vec<(f64, DVec3, DVec3)> = (triangles.iter())
        .filter_map(|t| {
            let [a, b, c] = t.map(|i| corners[i as usize]);
            let cross = (b - a).cross(c - a);
            cross.try_normalize().map(|normal| (cross.length(), normal, a))
        })
        .collect();
    all.sort_by_key(|(area, ..)| Reverse(area.to_bits()));
    let mut kept: Vec<(DVec3, DVec3)> = Vec::new();
    for (_, normal, corner) in all {
        if kept.len() == MAX_BASES {
            break;
        }
        if kept.iter().all(|(other, _)| other.dot(normal) < SAME_BASE.cos()) {
            kept.push((normal, corner));
        }
    }
    kept
}

/// Centre of mass of a closed surface of outward triangles at uniform density.
fn centroid(corners: &[DVec3], triangles: &[[u32; 3]]) -> DVec3 {
    let origin = corners.iter().sum::<DVec3>() / corners.len().max(1) as f64;
    let (mut volume, mut moment) = (0.0, DVec3::ZERO);
    for t in triangles {
        let [a, b, c] = t.map(|i| corners[i as usize] - origin);
        let six = a.dot(b.cross(c));
        volume += six;
        moment += (a + b + c) * (six / 4.0);
    }
    if volume > 0.0 { origin + moment / volume } else { origin }
}

fn area(polygon: &[DVec2]) -> f64 {
    edges(polygon).map(|(a, b)| 0.5 * a.perp_dot(b)).sum()
}

/// Distance of a point from the nearest edge, m; negative outside, −∞ for fewer than three corners.
fn margin(polygon: &[DVec2], point: DVec2) -> f64 {
    if polygon.len() < 3 {
        return f64::NEG_INFINITY;
    }
    edges(polygon).map(|(a, b)| (b - a).normalize().perp_dot(point - a)).fold(f64::INFINITY, f64::min)
}

fn edges(polygon: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
    polygon.iter().copied().zip(polygon.iter().copied().cycle().skip(1))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn a_box_has_six_stances_and_a_ball_none() {
        let corners: Vec<Vec3> =
            (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 0.4).collect();
        let (found, center) = stances(&corners);
        assert_eq!(found.len(), 6);
        assert!(center.distance(DVec3::splat(0.2)) < 1e-6);
        assert!(found.iter().all(|stance| (stance.area - 0.16).abs() < 1e-6 && stance.flatness > 0.99));
        let up = DVec3::new(0.1, 1.0, 0.2);
        assert_eq!(nearest(&found, up, 0.5).unwrap().up.round(), DVec3::Y);

        let ball: Vec<Vec3> = (0..2000)
            .map(|i| {
                let y = 1.0 - (i as f32 + 0.5) / 1000.0;
                let (sin, cos) = (2.399_963_2 * i as f32).sin_cos();
                0.1 * Vec3::new(cos * (1.0 - y * y).sqrt(), y, sin * (1.0 - y * y).sqrt())
            })
            .collect();
        assert!(stances(&ball).0.is_empty());
    }
}
