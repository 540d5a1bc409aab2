//! Directions that are tried where none is better than another.

use super::tolerances::DIRECTIONS;
use glam::DVec3;
use std::f64::consts::TAU;

/// Horizontal unit vectors all round.
pub(super) fn directions() -> impl Iterator<Item = DVec3> + Clone {
    (0..DIRECTIONS).map(|i| {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(DIRECTIONS)).sin_cos();
        DVec3::new(cos, 0.0, sin)
    })
}
