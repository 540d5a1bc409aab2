//! The outline of an object seen from above: which way its sides look, and the rectangle around it.

use super::tolerances::{FLAT, MAX_YAW, SAME_SIDE};
use crate::shape::convex_polygon;
use glam::{DVec2, DVec3, Vec3Swizzles};
use std::f64::consts::{FRAC_PI_2, TAU};

/// A convex polygon in x and z, m.
pub(super) struct Outline {
    corners: Vec<DVec2>,
    center: DVec2,
}

/// The smallest rectangle around an outline.
pub(super) struct Rectangle {
    /// Yaw of one of its sides, in [0, 90°), rad.
    pub yaw: f64,
    /// Longer side, m.
    pub length: f64,
    /// Share of it that the outline fills.
    pub filled: f64,
}

/// A straight side of an outline.
struct Side {
    /// Yaw of the direction that it looks in, rad.
    yaw: f64,
    /// m.
    length: f64,
}

impl Outline {
    pub fn new(points: impl Iterator<Item = DVec3>) -> Self {
        let corners = convex_polygon(points.map(|p| p.xz()).collect());
        let center = corners.iter().sum::<DVec2>() / corners.len().max(1) as f64;
        Self { corners, center }
    }

    /// How far the object has to be turned about +Y for its flat side that is nearest to facing `toward` to face it,
    /// rad; none if no flat side is within 25° of it.
    pub fn turn_to(&self, toward: DVec3) -> Option<f64> {
        let target = yaw(toward.xz());
        let across = toward.xz().perp();
        let width = self.extent(across.try_normalize()?);
        let sides: Vec<Side> = self.sides().collect();
        let candidates = sides.iter().filter_map(|side| {
            let off = wrapped(target - side.yaw, TAU);
            let alike = || sides.iter().map(|other| (wrapped(other.yaw - side.yaw, TAU), other.length));
            let one = || alike().filter(|(apart, _)| apart.abs() < SAME_SIDE);
            let length: f64 = one().map(|(_, length)| length).sum();
            let mean = one().map(|(apart, length)| apart * length).sum::<f64>() / length;
            // Of two flat sides the one that needs less of a turn is preferred.
            let score = length * (1.0 - off.abs() / MAX_YAW);
            (off.abs() < MAX_YAW && length >= FLAT * width).then_some((score, wrapped(off - mean, TAU)))
        });
        candidates.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, turn)| turn)
    }

    /// The smallest rectangle that holds the outline; none for one without area.
    pub fn rectangle(&self) -> Option<Rectangle> {
        let area = self.area();
        let around = self.sides().map(|side| {
            let along = DVec2::new(side.yaw.sin(), side.yaw.cos());
            let [a, b] = [self.extent(along), self.extent(along.perp())];
            Rectangle { yaw: side.yaw.rem_euclid(FRAC_PI_2), length: a.max(b), filled: area / (a * b) }
        });
        around.filter(|rectangle| rectangle.filled.is_finite()).max_by(|a, b| a.filled.total_cmp(&b.filled))
    }

    fn sides(&self) -> impl Iterator<Item = Side> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(next).filter(|_| self.corners.len() > 2).filter_map(|(a, b)| {
            let across = (b - a).perp();
            let outward = if across.dot(0.5 * (a + b) - self.center) < 0.0 { -across } else { across };
            let length = (b - a).length();
            (length > 0.0).then(|| Side { yaw: yaw(outward), length })
        })
    }

    fn extent(&self, along: DVec2) -> f64 {
        let spans = self.corners.iter().map(|p| p.dot(along));
        let [low, high] = spans.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
        (high - low).max(0.0)
    }

    fn area(&self) -> f64 {
        let next = self.corners.iter().cycle().skip(1);
        0.5 * self.corners.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>().abs()
    }
}

/// Yaw of a direction in x and z: a turn about +Y adds to it, rad.
pub(super) fn yaw(direction: DVec2) -> f64 {
    direction.x.atan2(direction.y)
}

/// An angle brought into [−period / 2, period / 2), rad.
pub(super) fn wrapped(angle: f64, period: f64) -> f64 {
    (angle + 0.5 * period).rem_euclid(period) - 0.5 * period
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use glam::DQuat;

    fn turned(points: &[[f64; 2]], angle: f64) -> Outline {
        Outline::new(points.iter().map(|[x, z]| DQuat::from_rotation_y(angle) * DVec3::new(*x, 0.0, *z)))
    }

    const PICTURE: [[f64; 2]; 5] = [[-0.5, 0.0], [0.5, 0.0], [0.5, 0.04], [-0.5, 0.04], [0.1, 0.02]];

    #[test]
    fn a_flat_back_is_turned_to_its_wall_and_only_from_nearby() {
        for angle in [-0.4, -0.1, 0.0, 0.3] {
            let turn = turned(&PICTURE, angle).turn_to(DVec3::NEG_Z).unwrap();
            assert!((turn + angle).abs() < 1e-9, "turned by {angle}, back by {turn}");
        }
        assert!(turned(&PICTURE, 0.5).turn_to(DVec3::NEG_Z).is_none());
    }

    #[test]
    fn what_is_round_has_no_back() {
        let round: Vec<[f64; 2]> = (0..48).map(|i| (TAU * f64::from(i) / 48.0).sin_cos().into()).collect();
        assert!(turned(&round, 0.1).turn_to(DVec3::X).is_none());
        assert!(turned(&round, 0.1).rectangle().unwrap().filled < 0.8);
        assert!(Outline::new([DVec3::X, DVec3::Z].into_iter()).rectangle().is_none());
    }

    #[test]
    fn a_rectangle_knows_its_yaw() {
        let rectangle = turned(&PICTURE, 0.3).rectangle().unwrap();
        assert!((rectangle.yaw - 0.3).abs() < 1e-9 && (rectangle.length - 1.0).abs() < 1e-9);
        assert!((rectangle.filled - 1.0).abs() < 1e-9);
    }
}
