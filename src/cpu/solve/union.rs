//! The contacts of several candidates side by side.
//!
//! A patch of the union is the `k`-th of a body pair in every candidate that has so many there. A candidate's patches
//! keep their order in the union, and it keeps still while patches that it lacks are solved: so its bits do not depend
//! on its company.
//!
//! Patches that share no body that moves may be solved in any order, with the same bits. They come one after the other,
//! so that the processor begins with the next while it waits for one.

use super::lanes::{MOST_LANES, Mask, Number, Vector, splat};
use crate::cpu::contacts::{Contact, ContactSet, GROUND, Patch};
use crate::cpu::narrow_phase::tangents;
use crate::world::{Body, constants::MAX_MANIFOLD_POINTS};
use fearless_simd::prelude::*;
use glam::Vec3;

/// Where a sweep has the points of a patch of so many: the `i`-th point's turn.
pub const TURNS: [[usize; MAX_MANIFOLD_POINTS]; MAX_MANIFOLD_POINTS + 1] = turns();

/// Every third, so that points across the patch follow one another and its lean is settled first.
const fn turns() -> [[usize; MAX_MANIFOLD_POINTS]; MAX_MANIFOLD_POINTS + 1] {
    let mut turns = [[0; MAX_MANIFOLD_POINTS]; MAX_MANIFOLD_POINTS + 1];
    let mut count = 1;
    while count <= MAX_MANIFOLD_POINTS {
        let mut turn = 0;
        while turn < count {
            turns[count][if count.is_multiple_of(3) { turn } else { 3 * turn % count }] = turn;
            turn += 1;
        }
        count += 1;
    }
    turns
}

/// A patch of the union.
#[derive(Clone, Copy, Debug)]
pub struct WidePatch<S: Simd> {
    pub a: u32,
    pub b: u32,
    /// One more than the highest level of the patches before it that move one of its bodies.
    level: u32,
    /// Its points, in the order of a sweep: the first among the union's, and among the solver's rows.
    pub found: u32,
    pub first: u32,
    pub count: u32,
    /// The number of points.
    pub counts: Number<S>,
    /// Index of the patch among the candidate's own.
    pub own: [u32; MOST_LANES],
    pub normal: Vector<S>,
    /// Where the patch carries its load.
    pub center: Vector<S>,
    pub friction: Vector<S>,
    pub twist: Number<S>,
}

impl<S: Simd> WidePatch<S> {
    /// The candidates that have it.
    #[inline(always)]
    pub fn present(&self) -> Mask<S> {
        self.counts.simd_gt(0.0)
    }

    /// The candidates that have it: lane, index of the patch there, order of its points in the union's rows.
    #[inline(always)]
    pub fn owners(&self) -> impl Iterator<Item = (usize, usize, &'static [usize])> {
        let counts = self.counts.as_slice().iter().map(|&count| count as usize);
        let lanes = counts.zip(self.own).enumerate().filter(|(_, (count, _))| *count > 0);
        lanes.map(|(lane, (count, own))| (lane, own as usize, &TURNS[count][..count]))
    }

    /// Tangents of the normals.
    #[inline(always)]
    pub fn tangents(&self) -> [Vector<S>; 2] {
        let mut both = [self.normal; 2];
        for (lane, ..) in self.owners() {
            let [u, v] = tangents(self.normal.lane(lane));
            both[0].set_lane(lane, u);
            both[1].set_lane(lane, v);
        }
        both
    }

    #[inline(always)]
    pub fn found_points(&self) -> std::ops::Range<usize> {
        self.found as usize..(self.found + self.count) as usize
    }

    #[inline(always)]
    pub fn points(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// A contact point of a patch of the union; zeros for candidates whose patch has no such point.
#[derive(Clone, Copy, Debug)]
pub struct WidePoint<S: Simd> {
    pub normal: Vector<S>,
    pub point: Vector<S>,
    pub separation: Number<S>,
    pub impulse: Number<S>,
    pub load: Number<S>,
    pub rest: Number<S>,
}

/// The patches and points of up to `MOST_LANES` candidates.
#[derive(Debug)]
pub struct Union<S: Simd> {
    simd: S,
    pub patches: Vec<WidePatch<S>>,
    pub points: Vec<WidePoint<S>>,
    /// Of every body, the level of its last patch.
    levels: Vec<u32>,
}

impl<S: Simd> Union<S> {
    pub fn new(simd: S) -> Self {
        Self { simd, patches: Vec::new(), points: Vec::new(), levels: Vec::new() }
    }

    /// Takes over what the candidates have. The ground becomes the body after the last.
    #[inline(always)]
    pub fn gather<'a>(&mut self, sets: impl Iterator<Item = &'a ContactSet>, bodies: &[Body]) {
        let Self { simd, patches, points, levels } = self;
        levels.clear();
        levels.resize(bodies.len(), 0);
        patches.clear();
        points.clear();
        let mut cursors = [const { None }; MOST_LANES];
        cursors.iter_mut().zip(sets).for_each(|(cursor, set)| *cursor = Some(Cursor::new(set)));
        let zero = splat(*simd, 0.0);
        let origin = Vector::splat(*simd, Vec3::ZERO);
        while let Some(key) = cursors.iter().flatten().filter_map(Cursor::key).min() {
            let mut wide = WidePatch {
                a: 0,
                b: 0,
                level: 0,
                found: points.len() as u32,
                first: 0,
                count: 0,
                counts: zero,
                own: [u32::MAX; MOST_LANES],
                normal: origin,
                center: origin,
                friction: origin,
                twist: zero,
            };
            for (lane, cursor) in cursors.iter_mut().enumerate() {
                let Some(cursor) = cursor.as_mut().filter(|cursor| cursor.key() == Some(key)) else { continue };
                let (own, patch) = cursor.take();
                let count = patch.count as usize;
                if wide.count < patch.count {
                    wide.count = patch.count;
                    let blank = WidePoint {
                        normal: origin,
                        point: origin,
                        separation: zero,
                        impulse: zero,
                        load: zero,
                        rest: zero,
                    };
                    points.resize(wide.found_points().end, blank);
                }
                wide.a = if patch.a == GROUND { bodies.len() as u32 } else { patch.a };
                (wide.b, wide.own[lane]) = (patch.b, own);
                wide.counts[lane] = count as f32;
                let own_points = cursor.set.points_of(patch);
                wide.normal.set_lane(lane, patch.normal);
                wide.center.set_lane(lane, center_of_pressure(own_points));
                wide.friction.set_lane(lane, patch.friction);
                wide.twist[lane] = patch.twist;
                for (contact, turn) in own_points.iter().zip(TURNS[count]) {
                    let point = &mut points[wide.found as usize + turn];
                    point.normal.set_lane(lane, contact.normal);
                    point.point.set_lane(lane, contact.point);
                    point.separation[lane] = contact.separation;
                    point.impulse[lane] = contact.impulse;
                    point.load[lane] = contact.load;
                    point.rest[lane] = contact.rest;
                }
            }
            let moved = [wide.a, wide.b].map(|body| body as usize);
            let moved = || moved.into_iter().filter(|&body| bodies.get(body).is_some_and(|body| !body.is_static()));
            wide.level = 1 + moved().map(|body| levels[body]).max().unwrap_or(0);
            moved().for_each(|body| levels[body] = wide.level);
            patches.push(wide);
        }
        patches.sort_unstable_by_key(|patch| (patch.level, patch.found));
    }
}

/// The next patch of a candidate.
struct Cursor<'a> {
    set: &'a ContactSet,
    at: usize,
    /// How many patches of the same pair came before it.
    ordinal: u32,
}

impl<'a> Cursor<'a> {
    fn new(set: &'a ContactSet) -> Self {
        Self { set, at: 0, ordinal: 0 }
    }

    /// Its place in the union.
    fn key(&self) -> Option<(u32, u32)> {
        self.set.patches.get(self.at).map(|patch| (patch.pair, self.ordinal))
    }

    /// Gives the patch and goes on to the next.
    fn take(&mut self) -> (u32, &'a Patch) {
        let patch = &self.set.patches[self.at];
        let own = self.at as u32;
        self.at += 1;
        let same = self.set.patches.get(self.at).is_some_and(|next| next.pair == patch.pair);
        self.ordinal = if same { self.ordinal + 1 } else { 0 };
        (own, patch)
    }
}

/// Where the patch carries its load: the mean of its points, weighted by their last impulses; unweighted at first.
fn center_of_pressure(points: &[Contact]) -> Vec3 {
    let total: f32 = points.iter().map(|p| p.impulse).sum();
    if total > 0.0 {
        points.iter().map(|p| p.impulse * p.point).sum::<Vec3>() / total
    } else {
        points.iter().map(|p| p.point).sum::<Vec3>() / points.len() as f32
    }
}
