//! The independent geometry: distance, depth and axis of a hull pair from parry's GJK and EPA.
//!
//! parry's tolerances are absolute (1e-6 for GJK, 1e-5 for EPA) and its depths can fail on flat or aligned hulls, so
//! each query is scaled to hulls of about unit size around their own centres, its answer is checked against the hulls'
//! extents along the answer's axis, and a failed query is asked again from other directions.

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

    /// True if parry's first answer for this pair contradicts itself or is missing although the hulls are within
    /// `margin`; for statistics.
    pub fn first_attempt_fails(&self, pair: &HullPair, margin: f32) -> bool {
        Query::new(pair).is_some_and(|query| {
            let first = query.ask(query.directions()[0], margin);
            !first.is_some_and(|a| a.consistent || a.along > margin * query.scale)
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

    /// One call of parry.
    fn ask(&self, direction: Vec3, margin: f32) -> Option<Answer> {
        let mut simplex = VoronoiSimplex::new();
        let result = contact_support_map_support_map_with_params(
            &self.relative,
            &self.a,
            &self.b,
            margin * self.scale,
            &mut simplex,
            Some(direction),
        );
        match result {
            GJKResult::ClosestPoints(on_a, on_b, axis) => {
                let axis = axis.try_normalize()?;
                let extents = self.extents(axis);
                let consistent = ((on_b - on_a).dot(axis) - extents.along).abs() <= CONSISTENT;
                Some(if consistent { Answer { on_a, on_b, consistent, ..extents } } else { extents })
            }
            GJKResult::NoIntersection(axis) | GJKResult::Proximity(axis) => Some(self.extents(axis)),
            GJKResult::Intersection => None,
        }
    }

    /// The answer within `margin`, from as many attempts as it takes; if none is consistent, the one whose axis shows
    /// the least overlap, which is never less than the true one.
    fn solve(&self, margin: f32) -> Option<Answer> {
        let mut best: Option<Answer> = None;
        for direction in self.directions() {
            let Some(answer) = self.ask(direction, margin) else { continue };
            if answer.along > margin * self.scale {
                return None;
            }
            let better = best.as_ref().is_none_or(|b| (answer.consistent, answer.along) > (b.consistent, b.along));
            if answer.consistent {
                return Some(answer);
            }
            if better {
                best = Some(answer);
            }
        }
        best
    }
}
