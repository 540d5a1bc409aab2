//! The height at which an object rests on its bearer: on the surface under its feet that is nearest to them and has
//! room.
//!
//! In every column of the footprint the shifts at which the object would reach into its bearer are known; where, going
//! up, the last column but a few gets free, the object rests. That is the top of a desk below its hutch, the seat of a
//! chair in front of its backrest, and the board of a shelf that something stands on inside. (REST3D's stage 2b takes
//! the bearer's highest point.)

use super::columns::{Footprint, Surface};
use super::tolerances::{CLEARED, TOLERATED};
use glam::{DVec2, Vec3Swizzles};

/// Where an object rests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rest {
    /// How far the object has to be raised, m.
    pub raise: f64,
    /// How far the object is beside its bearer, m; 0 if it is above it.
    pub beside: f64,
}

/// Where `object` rests on `bearer`; none if the bearer has nothing to stand on. What is beside its bearer gets the
/// height that it would have on the nearest place of it.
pub(super) fn rest(object: &Surface, bearer: &Surface) -> Option<Rest> {
    let footprint = Footprint::new(object);
    if let Some(raise) = raise(&footprint.blocked(bearer, DVec2::ZERO)) {
        return Some(Rest { raise, beside: 0.0 });
    }
    // Into the bearer's box, or where it is too small for that, to its middle.
    let gap = |axis: usize| {
        let (low, high) = (bearer.low - object.low, bearer.high - object.high);
        let (low, high) = (low.xz()[axis], high.xz()[axis]);
        if low <= high { 0.0_f64.clamp(low, high) } else { 0.5 * (low + high) }
    };
    let aside = DVec2::new(gap(0), gap(1));
    let raise = raise(&footprint.blocked(bearer, aside))?;
    Some(Rest { raise, beside: aside.length() })
}

/// The smallest shift at which all columns but a few are free, and no longer were below it.
fn raise(columns: &[Vec<[f64; 2]>]) -> Option<f64> {
    let touching = columns.iter().filter(|column| !column.is_empty()).count();
    // A tenth of the footprint may be all that is above the bearer; it must not pass for the few that are tolerated.
    let few = (TOLERATED * columns.len().min(2 * touching) as f64) as usize;
    let mut ends: Vec<(f64, bool)> =
        columns.iter().flatten().flat_map(|&[low, high]| [(low, true), (high, false)]).collect();
    // At the same height one column begins before another ends: they leave no room between them.
    ends.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
    let mut blocked = 0;
    let mut best: Option<f64> = None;
    for (shift, begins) in ends {
        blocked = if begins { blocked + 1 } else { blocked - 1 };
        if !begins && blocked == few && best.is_none_or(|best| shift.abs() < best.abs()) {
            best = Some(shift);
        }
    }
    let least = best?;
    let cleared = columns.iter().flatten().map(|[_, high]| *high).filter(|high| *high <= least + CLEARED);
    Some(cleared.fold(least, f64::max))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn cuboid(low: [f64; 3], high: [f64; 3]) -> Vec<[DVec3; 3]> {
        let corner =
            |i: usize| DVec3::from_array(std::array::from_fn(|a| if i >> a & 1 == 1 { high[a] } else { low[a] }));
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        faces.iter().flat_map(|f| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]]).map(|t| t.map(corner)).collect()
    }

    /// Raise of a box of 10 cm whose bottom is at `y`, its middle at `x` in depth.
    fn raised(bearer: &Surface, x: f64, y: f64) -> f64 {
        let object = Surface::new(cuboid([x - 0.05, y, -0.05], [x + 0.05, y + 0.1, 0.05]));
        rest(&object, bearer).map_or(f64::NAN, |rest| rest.raise)
    }

    #[test]
    fn the_nearest_surface_with_room_bears() {
        // A top, a wall behind it, and two boards over its back half, the gap between them too low for the box.
        let parts = [
            cuboid([-0.5, 0.7, -0.3], [0.5, 0.73, 0.3]),
            cuboid([0.45, 0.73, -0.3], [0.5, 1.3, 0.3]),
            cuboid([0.0, 1.0, -0.3], [0.45, 1.02, 0.3]),
            cuboid([0.0, 1.07, -0.3], [0.45, 1.09, 0.3]),
        ];
        let desk = Surface::new(parts.concat());
        for (x, y, bottom) in [
            (-0.3, 0.75, 0.73),
            (-0.3, 1.2, 0.73),
            (-0.3, 0.68, 0.73),
            (0.2, 0.8, 0.73),
            (0.2, 1.04, 1.09),
            (0.2, 1.01, 1.09),
            // A centimetre into the wall behind, which is no reason to stand on top of it.
            (0.41, 0.74, 0.73),
        ] {
            let raise = raised(&desk, x, y);
            assert!((y + raise - bottom).abs() < 1e-9, "at {x}, {y}: raised by {raise}");
        }
    }

    #[test]
    fn what_is_beside_its_bearer_gets_its_height() {
        let table = Surface::new(cuboid([-0.5, 0.0, -0.5], [0.5, 0.7, 0.5]));
        let cup = Surface::new(cuboid([0.55, 0.75, 0.0], [0.65, 0.85, 0.1]));
        let found = rest(&cup, &table);
        assert!(found.is_some_and(|r| (r.raise + 0.05).abs() < 1e-9 && (r.beside - 0.15).abs() < 1e-9), "{found:?}");
        assert_eq!(rest(&cup, &Surface::new(Vec::new())), None);
    }
}
