//! Fewer vertices for a hull: the most telling ones first.
//!
//! Vertices are added where the hull so far falls short of the full one by most. What is left out makes the part
//! smaller, never larger. On the planes on which an object rests, or on which others rest on it, a shortfall tilts
//! and sinks things, so it counts several times there.

use super::hull::{Hull, directions, supports};
use super::tolerances::reduce::{BAND, BAND_SHARE, NEGLIGIBLE, SUPPORT_TOLERANCE, SUPPORT_WEIGHT, TOLERANCE};
use glam::Vec3;

/// The levels along `up` on which things stand: `low` under the object, `high` on top of it (m), with a tolerance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Levels {
    /// Unit vector.
    pub up: Vec3,
    /// Lowest point of the mesh along `up`, m.
    pub low: f32,
    /// Highest point of the mesh along `up`, m.
    pub high: f32,
}

impl Levels {
    /// Levels of a set of points.
    pub fn new(points: impl Iterator<Item = Vec3>, up: Vec3) -> Self {
        let (low, high) =
            points.map(|p| up.dot(p)).fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), a| (l.min(a), h.max(a)));
        Self { up, low, high }
    }

    /// Distance from the highest and lowest level within which a point counts as top or foot, m.
    pub fn band(&self) -> f32 {
        BAND.max(BAND_SHARE * (self.high - self.low))
    }

    /// Whether the point is one of the lowest of the mesh.
    pub fn is_foot(&self, p: Vec3) -> bool {
        self.up.dot(p) <= self.low + self.band()
    }

    /// Whether the point is one of the highest of the mesh.
    pub fn is_top(&self, p: Vec3) -> bool {
        self.up.dot(p) >= self.high - self.band()
    }
}

/// The hull of at most `hard` of the hull's vertices, of at most `soft` if that is accurate enough.
pub(super) fn reduce(hull: &Hull, levels: &Levels, soft: usize, hard: usize) -> Hull {
    let all = &hull.vertices;
    let mut probes = directions(8);
    probes.extend([levels.up, -levels.up]);
    let mut chosen = supports(all, &probes);
    chosen.sort_unstable();
    chosen.dedup();
    let bears: Vec<bool> = all.iter().map(|&v| levels.is_foot(v) || levels.is_top(v)).collect();
    let weighed =
        |i: usize, short: f32| if bears[i] && short > SUPPORT_TOLERANCE { SUPPORT_WEIGHT * short } else { short };
    loop {
        let points: Vec<Vec3> = chosen.iter().map(|&i| all[i as usize]).collect();
        let Some(reduced) = Hull::new(&points) else {
            return hull.clone();
        };
        let (worst, short) = (0..all.len())
            .filter(|i| chosen.binary_search(&(*i as u32)).is_err())
            .map(|i| (i as u32, weighed(i, reduced.excess(all[i]))))
            .fold((0, 0.0_f32), |best, next| if next.1 > best.1 { next } else { best });
        let enough = short <= if chosen.len() < soft { NEGLIGIBLE } else { TOLERANCE };
        if enough || chosen.len() >= hard {
            return reduced;
        }
        let at = chosen.partition_point(|&i| i < worst);
        chosen.insert(at, worst);
    }
}
