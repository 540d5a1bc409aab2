//! Chooses the few of many contact points that support a body as well as all of them.

use super::MAX_MANIFOLD_POINTS;
use crate::world::constants::{CLIP_TOLERANCE, LINEAR_SLOP};
use glam::{Vec2, Vec3};

/// Chosen points, as indices into what was offered.
#[derive(Clone, Copy, Debug, Default)]
pub struct Selection {
    count: usize,
    indices: [u16; MAX_MANIFOLD_POINTS],
}

impl Selection {
    /// The indices: the deepest point first, then counter-clockwise against the normal.
    pub fn indices(&self) -> &[u16] {
        &self.indices[..self.count]
    }

    fn insert(&mut self, slot: usize, index: usize) {
        self.indices.copy_within(slot..self.count, slot + 1);
        self.indices[slot] = index as u16;
        self.count += 1;
    }
}

/// Chooses at most `max` (≤ `MAX_MANIFOLD_POINTS`) of `count` points, each given as position and separation (m), by their
/// footprint across `normal`: the deepest point; the point farthest from it; then, each time, the point that adds most
/// area to the polygon of those chosen, until none adds any. Of points above each other the deeper one is chosen, of
/// equals the one first offered. Points closer than the slop to a chosen one are left out.
pub fn reduce(count: usize, point: impl Fn(usize) -> (Vec3, f32), normal: Vec3, max: usize) -> Selection {
    let mut chosen = Selection::default();
    if count == 0 {
        return chosen;
    }
    let max = max.min(MAX_MANIFOLD_POINTS);
    let (u, v) = normal.any_orthonormal_pair();
    let flat = |i: usize| {
        let p = point(i).0;
        Vec2::new(u.dot(p), v.dot(p))
    };
    // The index of the largest score; scores closer than `tolerance` are decided by depth.
    let best = |score: &dyn Fn(usize) -> f32, tolerance: f32| {
        let (mut winner, mut high) = (0, f32::NEG_INFINITY);
        for i in 0..count {
            let s = score(i);
            let deeper = s > high - tolerance && point(i).1 < point(winner).1 - CLIP_TOLERANCE;
            if s > high + tolerance || deeper {
                (winner, high) = (i, s);
            }
        }
        (winner, high)
    };
    // Equal depths are decided by the position across the normal, so that rounding does not move the first choice.
    let depth = best(&|i| -point(i).1, 0.0).1;
    let first =
        best(&|i| if -point(i).1 >= depth - CLIP_TOLERANCE { flat(i).dot(FIRST) } else { f32::NEG_INFINITY }, 0.0).0;
    chosen.insert(0, first);
    let origin = flat(first);
    let (second, reach) = best(&|i| flat(i).distance(origin), CLIP_TOLERANCE);
    if max < 2 || reach < LINEAR_SLOP {
        return chosen;
    }
    chosen.insert(1, second);
    let axis = (flat(second) - origin).normalize_or_zero();
    let (third, height) = best(&|i| axis.perp_dot(flat(i) - origin).abs(), CLIP_TOLERANCE);
    if max < 3 || height < LINEAR_SLOP {
        return chosen;
    }
    // Kept counter-clockwise from here on.
    chosen.insert(if axis.perp_dot(flat(third) - origin) > 0.0 { 2 } else { 1 }, third);
    while chosen.count < max {
        let (mut gain, mut depth, mut slot, mut index) = (0.0, 0.0, 0, 0);
        for k in 0..chosen.count {
            let a = flat(chosen.indices[k] as usize);
            let b = flat(chosen.indices[(k + 1) % chosen.count] as usize);
            let along = b - a;
            let tolerance = CLIP_TOLERANCE * along.length();
            for i in 0..count {
                let (p, s) = (flat(i), point(i).1);
                let area = -along.perp_dot(p - a);
                let far = p.distance(a).min(p.distance(b)) > LINEAR_SLOP && area > tolerance;
                let more = area > gain + tolerance || (area > gain - tolerance && s < depth - CLIP_TOLERANCE);
                if far && more {
                    (gain, depth, slot, index) = (area, s, k + 1, i);
                }
            }
        }
        if slot == 0 {
            break;
        }
        chosen.insert(slot, index);
    }
    chosen
}

/// A direction across the normal that no box is likely to be aligned with.
const FIRST: Vec2 = Vec2::new(0.8, 0.6);
