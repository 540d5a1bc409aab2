//! The independent geometry: distance, depth and axis of a hull pair from parry's GJK and EPA.
//!
//! parry's tolerances are absolute (1e-6 for GJK, 1e-5 for EPA) and its depths can fail on flat or aligned hulls, so
//! each query is scaled to hulls of about unit size around their own centres, its answer is checked against the hulls'
//! extents along the answer's axis, a depth must be found twice, and a failed query is asked again from other
//! directions and with the hulls exchanged.

use super::{Feature, HullPair, Separation};
use crate::world::{Hull, HullTables};
use glam::{Quat, Vec3, Vec4};
use parry3d::math::Pose3;
use parry3d::query::details::contact_support_map_support_map_with_params;
use parry3d::query::gjk::{GJKResult, VoronoiSimplex};
use parry3d::shape::SupportMap;

/// Sum of the radii to which a query is scaled.
const QUERY_SIZE: f32 = 4.0;

/// How much the axis may contradict the witness points, in units of the scaled query: ten times EPA's tolerance.
const CONSISTENT: f32 = 1e-4;

/// Queries through parry. Has no state: hulls are read from the tables.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reference;

/// A hull scaled about its centre, as parry asks for it.
struct Cloud<'a> {
    vertices: &'a [Vec4],
    center: Vec3,
    scale: f32,
}

impl<'a> Cloud<'a> {
    fn new(tables: &'a HullTables, hull: &Hull, scale: f32) -> Self {
        Self { vertices: tables.vertices_of(hull), center: hull.center, scale }
    }
}

impl SupportMap for Cloud<'_> {
    fn local_support_point(&self, dir: Vec3) -> Vec3 {
        let dir = dir.extend(0.0);
        let (mut best, mut high) = (0, f32::NEG_INFINITY);
        for (i, v) in self.vertices.iter().enumerate() {
            let along = dir.dot(*v);
            if along > high {
                (best, high) = (i, along);
            }
        }
        (self.vertices[best].truncate() - self.center) * self.scale
    }
}

/// An answer in the scaled frame of A.
struct Answer {
    axis: Vec3,
    on_a: Vec3,
    on_b: Vec3,
    /// Separation along the axis, from the hulls' extents.
    along: f32,
    consistent: bool,
}

impl Reference {
    /// See `Separator::separation`.
    pub fn separation(&self, pair: &HullPair, margin: f32) -> Option<Separation> {
        let query = Query::new(pair)?;
        let answer = query.solve(margin)?;
        let world = |p: Vec3| pair.poses[0].point(p / query.scale + query.a.center);
        Some(Separation {
            distance: answer.along / query.scale,
            normal: pair.poses[0].rotation * answer.axis,
            feature: Feature::Points { on_a: world(answer.on_a), on_b: world(answer.on_b) },
        })
    }

    /// See `Separator::depth`.
    pub fn depth(&self, pair: &HullPair, ignored: f32) -> f32 {
        let depth = self.separation(pair, 0.0).map_or(0.0, |s| -s.distance);
        if depth > ignored { depth } else { 0.0 }
    }

    /// True if parry's first answer for this pair contradicts itself, is missing although the hulls are within
    /// `margin`, or is beaten by a later one; for statistics.
    pub fn first_attempt_fails(&self, pair: &HullPair, margin: f32) -> bool {
        Query::new(pair).is_some_and(|query| {
            let first = query.ask(query.directions()[0], false, margin);
            let least = query.solve(margin).map_or(f32::NEG_INFINITY, |a| a.along) - 2.0 * CONSISTENT;
            !first.is_some_and(|a| a.along > margin * query.scale || (a.consistent && a.along >= least))
        })
    }
}

/// Both hulls, scaled, and B's place in the frame of A.
struct Query<'a> {
    a: Cloud<'a>,
    b: Cloud<'a>,
    relative: Pose3,
    scale: f32,
}

impl<'a> Query<'a> {
    fn new(pair: &HullPair<'a>) -> Option<Self> {
        let (hull_a, hull_b) = (pair.hull(0), pair.hull(1));
        let scale = QUERY_SIZE / (hull_a.radius + hull_b.radius);
        let back = pair.poses[0].rotation.conjugate();
        let rotation: Quat = back * pair.poses[1].rotation;
        let offset =
            back * (pair.poses[1].translation - pair.poses[0].translation) + rotation * hull_b.center - hull_a.center;
        (offset.is_finite() && rotation.is_finite()).then(|| Self {
            a: Cloud::new(pair.tables, hull_a, scale),
            b: Cloud::new(pair.tables, hull_b, scale),
            relative: Pose3::from_parts(offset * scale, rotation),
            scale,
        })
    }

    /// Start directions of the attempts: centre to centre, then the axes and diagonals.
    fn directions(&self) -> [Vec3; 8] {
        let center = self.relative.translation.try_normalize().unwrap_or(Vec3::X);
        let turned = center.any_orthonormal_vector();
        [
            center,
            turned,
            center.cross(turned),
            Vec3::Y,
            -Vec3::Y,
            Vec3::new(0.6, 0.8, 0.1),
            Vec3::new(-0.3, 0.2, 0.9),
            Vec3::new(0.5, -0.7, -0.6),
        ]
    }

    /// What the hulls' extents say of a unit axis.
    fn extents(&self, axis: Vec3) -> Answer {
        let on_a = self.a.local_support_point(axis);
        let on_b = self.b.support_point(&self.relative, -axis);
        Answer { axis, on_a, on_b, along: axis.dot(on_b - on_a), consistent: false }
    }

    /// One call of parry, with the roles of A and B exchanged if `swapped`.
    fn ask(&self, direction: Vec3, swapped: bool, margin: f32) -> Option<Answer> {
        let mut simplex = VoronoiSimplex::new();
        let mut contact = |relative: &Pose3, a: &Cloud, b: &Cloud| {
            let (margin, start) = (margin * self.scale, Some(direction));
            contact_support_map_support_map_with_params(relative, a, b, margin, &mut simplex, start)
        };
        let result = if swapped {
            contact(&self.relative.inverse(), &self.b, &self.a)
        } else {
            contact(&self.relative, &self.a, &self.b)
        };
        let axis_here = |axis: Vec3| if swapped { -(self.relative.rotation * axis) } else { axis };
        match result {
            GJKResult::ClosestPoints(first, second, axis) => {
                let [first, second] =
                    if swapped { [second, first].map(|p| self.relative * p) } else { [first, second] };
                let extents = self.extents(axis_here(axis.try_normalize()?));
                let consistent = ((second - first).dot(extents.axis) - extents.along).abs() <= CONSISTENT;
                Some(if consistent { Answer { on_a: first, on_b: second, consistent, ..extents } } else { extents })
            }
            GJKResult::NoIntersection(axis) | GJKResult::Proximity(axis) => Some(self.extents(axis_here(axis))),
            GJKResult::Intersection => None,
        }
    }

    /// The answer within `margin`, from as many attempts as it takes.
    ///
    /// For hulls apart one consistent answer is proof: the witness points are as near as the axis allows. A depth has
    /// no such proof, and EPA at times stops at a local minimum three times too deep, so it must be found twice. The
    /// overlap along any axis is never less than the true one: otherwise the least found is taken.
    fn solve(&self, margin: f32) -> Option<Answer> {
        let mut best: Option<Answer> = None;
        for attempt in 0..2 * self.directions().len() {
            let direction = self.directions()[attempt / 2];
            let Some(answer) = self.ask(direction, attempt % 2 == 1, margin) else { continue };
            if answer.along > margin * self.scale {
                return None;
            }
            if answer.consistent && answer.along > CONSISTENT {
                return Some(answer);
            }
            let rank = |a: &Answer| a.along + if a.consistent { CONSISTENT } else { 0.0 };
            let Some(other) = best.take() else {
                best = Some(answer);
                continue;
            };
            let agree = answer.consistent && other.consistent && (answer.along - other.along).abs() <= CONSISTENT;
            let better = if rank(&answer) > rank(&other) { answer } else { other };
            if agree {
                return Some(better);
            }
            best = Some(better);
        }
        best
    }
}
