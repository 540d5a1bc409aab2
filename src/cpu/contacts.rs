//! Contacts of one candidate: hull manifolds gathered and merged per body pair, matched to the last substep.
//!
//! A compound makes one manifold per hull pair, thousands of redundant points that jitter. What supports a body is the
//! convex polygon of its contact area, so the points of a body pair are grouped by direction into patches, and each
//! patch keeps the few points that span it.

use super::narrow_phase::{ManifoldPoint, reduce};
use crate::world::{
    Pose,
    constants::{
        JOINING_COSINE, LOAD_LOSS, MATCH_COSINE, MATCH_DISTANCE, MAX_GATHERED_POINTS, MAX_PATCHES, PATCH_COSINE,
    },
};
use glam::Vec3;
use std::ops::Range;

/// `Patch::a` of a contact with the ground.
pub const GROUND: u32 = u32::MAX;

/// Contact points of two bodies in about one direction; friction acts on all of them together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Index into `World::pairs`; past its end, the body's contact with the ground.
    pub pair: u32,
    /// First body, or `GROUND`.
    pub a: u32,
    /// Second body.
    pub b: u32,
    /// First of its points.
    pub first: u32,
    /// Number of its points.
    pub count: u32,
    /// Unit normal from `a` to `b` at the deepest point, world.
    pub normal: Vec3,
    /// Tangential impulse on `b` of the last small step, world, N s.
    pub friction: Vec3,
    /// Angular impulse about the normal on `b` of the last small step, N m s.
    pub twist: f32,
}

/// A contact point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Unit normal from the first body to the second, world.
    pub normal: Vec3,
    /// Middle between the two surfaces, world, m.
    pub point: Vec3,
    /// Distance of the surfaces along the normal, m; negative: overlap.
    pub separation: f32,
    /// The same when the point was found.
    pub found: f32,
    /// The point in the frame of the first body (the world for the ground) and of the second, m: what matching
    /// compares.
    pub anchors: [Vec3; 2],
    /// Normal impulse of the last small step, N s.
    pub impulse: f32,
    /// Load that the contact has carried on average lately, N s a small step: where its spring is at rest.
    pub load: f32,
    /// Separation less the rest offset at which its spring is at rest, m; 0 before the first substep.
    pub rest: f32,
}

/// Patches and points of one candidate.
#[derive(Debug, Default)]
pub struct ContactSet {
    /// In the order of `World::pairs`, then the ground's.
    pub patches: Vec<Patch>,
    /// Points, patch by patch.
    pub points: Vec<Contact>,
}

impl ContactSet {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.patches.clear();
        self.points.clear();
    }

    /// Points of a patch.
    pub fn points_of(&self, patch: &Patch) -> &[Contact] {
        &self.points[patch.first as usize..][..patch.count as usize]
    }

    /// Adds patches of a pair of bodies that hardly moved since the last substep's set `old` was made, as they were
    /// there.
    pub fn keep(&mut self, bodies: [u32; 2], poses: &[Pose], old: &Self, patches: Range<usize>) {
        for patch in &old.patches[patches] {
            self.patches.push(Patch { first: self.points.len() as u32, ..*patch });
            self.points.extend(old.points_of(patch).iter().map(|contact| contact.followed(bodies, poses)));
        }
    }

    /// Adds a patch of a pair. `old` is the last substep's set and `candidates` its patches of the same pair: the
    /// best-aligned one hands over its friction, and its points their impulses, each once.
    pub fn push(
        &mut self,
        pair: u32,
        [a, b]: [u32; 2],
        poses: &[Pose],
        gathered: &[Gathered],
        old: &mut Self,
        candidates: Range<usize>,
    ) {
        let normal = gathered[0].normal;
        let aligned = |patch: &Patch| patch.normal.dot(normal);
        let matching = old.patches[candidates]
            .iter()
            .filter(|patch| aligned(patch) > MATCH_COSINE)
            .max_by(|p, q| aligned(p).total_cmp(&aligned(q)))
            .copied();
        let old_points = match &matching {
            Some(patch) => &mut old.points[patch.first as usize..][..patch.count as usize],
            None => &mut [],
        };
        self.patches.push(Patch {
            pair,
            a,
            b,
            first: self.points.len() as u32,
            count: gathered.len() as u32,
            normal,
            friction: matching.map_or(Vec3::ZERO, |patch| patch.friction),
            twist: matching.map_or(0.0, |patch| patch.twist),
        });
        for Gathered { normal, point } in gathered {
            let middle = 0.5 * (point.on_a + point.on_b);
            let on_a = if a == GROUND { middle } else { poses[a as usize].inverse_point(middle) };
            let anchors = [on_a, poses[b as usize].inverse_point(middle)];
            let old = take_nearest(old_points, anchors);
            self.points.push(Contact {
                normal: *normal,
                point: middle,
                separation: point.separation,
                found: point.separation,
                anchors,
                impulse: old.map_or(0.0, |old| old.impulse),
                load: old.map_or(0.0, |old| old.load),
                rest: old.map_or(0.0, |old| old.rest),
            });
        }
    }
}

impl Contact {
    /// The same contact after its bodies moved by little.
    fn followed(&self, [a, b]: [u32; 2], poses: &[Pose]) -> Self {
        let on_a = if a == GROUND { self.anchors[0] } else { poses[a as usize].point(self.anchors[0]) };
        let on_b = poses[b as usize].point(self.anchors[1]);
        let separation = self.found + self.normal.dot(on_b - on_a);
        Self { point: 0.5 * (on_a + on_b), separation, ..*self }
    }

    /// What it carries beyond its load, as far as it can be one: less the deeper it is. N s a small step.
    pub fn excess(&self) -> f32 {
        let share = (1.0 + LOAD_LOSS * self.separation.min(0.0)).max(0.0);
        share * self.impulse - self.load
    }
}

/// The nearest old point, which is used up: an impulse must not be counted twice.
fn take_nearest(old: &mut [Contact], anchors: [Vec3; 2]) -> Option<&Contact> {
    let mut nearest = (MATCH_DISTANCE * MATCH_DISTANCE, None);
    for (index, point) in old.iter().enumerate() {
        // A body that slides keeps its point in one of the two frames.
        let distance = point.anchors[0].distance_squared(anchors[0]).min(point.anchors[1].distance_squared(anchors[1]));
        if distance < nearest.0 {
            nearest = (distance, Some(index));
        }
    }
    nearest.1.map(|index| {
        old[index].anchors = [Vec3::INFINITY; 2];
        &old[index]
    })
}

/// A manifold point with its normal.
#[derive(Clone, Copy, Debug)]
pub struct Gathered {
    /// Unit normal from the first body to the second.
    pub normal: Vec3,
    /// Where.
    pub point: ManifoldPoint,
}

/// Gathers the points of one body pair and merges them into patches.
#[derive(Debug, Default)]
pub struct Gatherer {
    points: Vec<Gathered>,
    merged: Vec<Gathered>,
    patch: Vec<Gathered>,
    seeds: Vec<Gathered>,
    ends: Vec<usize>,
}

/// True if a point looks about the way of a patch's deepest point.
fn belongs(point: &Gathered, seed: &Gathered) -> bool {
    point.normal.dot(seed.normal) >= PATCH_COSINE
}

/// Number of the patch that a point is part of: the first that it belongs to, or else the best aligned.
fn owner(point: &Gathered, seeds: &[Gathered]) -> Option<usize> {
    let aligned = |seed: &Gathered| point.normal.dot(seed.normal);
    seeds.iter().position(|seed| belongs(point, seed)).or_else(|| {
        let nearest = seeds.iter().enumerate().rev().max_by(|(_, p), (_, q)| aligned(p).total_cmp(&aligned(q)));
        nearest.filter(|(_, seed)| aligned(seed) >= JOINING_COSINE).map(|(number, _)| number)
    })
}

impl Gatherer {
    /// Empties the list for the next pair.
    pub fn clear(&mut self) {
        self.points.clear();
    }

    /// Adds a manifold's points; merges what is there when the list would overflow.
    pub fn add(&mut self, normal: Vec3, points: &[ManifoldPoint]) {
        if self.points.len() + points.len() > MAX_GATHERED_POINTS {
            self.merge();
            std::mem::swap(&mut self.points, &mut self.merged);
        }
        self.points.extend(points.iter().map(|&point| Gathered { normal, point }));
    }

    /// Merges to at most `MAX_PATCHES` patches of at most `MAX_MANIFOLD_POINTS` points, the deepest first; empties the
    /// list. A patch is what looks about the way of its deepest point; when there can be no more patches, what is left
    /// joins the one that looks most its way.
    pub fn merge(&mut self) {
        self.merged.clear();
        self.ends.clear();
        self.seeds.clear();
        while self.seeds.len() < MAX_PATCHES {
            let free = self.points.iter().filter(|p| self.seeds.iter().all(|seed| !belongs(p, seed)));
            let depth = |p: &Gathered| p.point.separation;
            let Some(deepest) = free.min_by(|p, q| depth(p).total_cmp(&depth(q))) else { break };
            self.seeds.push(*deepest);
        }
        for (number, seed) in self.seeds.iter().enumerate() {
            self.patch.clear();
            self.patch.extend(self.points.iter().filter(|p| owner(p, &self.seeds) == Some(number)));
            let offered = |i: usize| (self.patch[i].point.on_b, self.patch[i].point.separation);
            let kept = reduce(self.patch.len(), offered, seed.normal);
            self.merged.extend(kept.indices().iter().map(|&i| self.patch[i as usize]));
            self.ends.push(self.merged.len());
        }
        self.points.clear();
    }

    /// The patches that `merge` made.
    pub fn patches(&self) -> impl Iterator<Item = &[Gathered]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| &self.merged[start..end])
    }
}
