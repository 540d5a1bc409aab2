//! What rolls is set down in the pose of rest that is nearest to its reconstruction: a pear that is let go comes to lie
//! anywhere, often on its other side. What still fails after the search is looked for a place among the others, where it
//! may lean on them.

use super::tolerances::{
    APART, ASTRAY, MAX_SLIDE, NEAREST, NUDGE, OVERLAP, PLACE_SHIFTS, PLACE_TILTS, PLACES_APART, ROLL_WITHIN, TILTS,
    UNSTEADY,
};
use super::{Rest, Seat, height::Solid};
use crate::optimize::{directions::directions, posture::angle, support::Placed, tolerances::NEARLY_FALLEN};
use crate::scene;
use crate::world::BackendError;
use glam::{DQuat, DVec3, Vec3};
use rayon::prelude::*;
use std::iter::once;

impl Seat<'_> {
    /// Turns an object, with everything on it, to the pose of rest on its parent that is near to its own and that it
    /// keeps with all decompositions. Left as it was if that takes it farther than the `fall` that it would take
    /// otherwise, rad, or if it would nearly have fallen over.
    pub(super) fn set_at_rest(&self, object: usize, fall: f32, layout: &mut [scene::Pose]) -> Result<(), BackendError> {
        let (here, bearer) = (layout[object], self.bearer(object, layout));
        let tilts = || TILTS.iter().flat_map(|&tilt| directions().map(move |axis| axis * tilt));
        let starts = |_| tilts().map(|tilt| self.tilted(object, tilt, &here, bearer.as_ref())).collect();
        let rests = self.nearest_rests(object, &[], fall, &[0.0], starts, layout)?;
        if let Some(pose) = rests.first() {
            self.carry(object, *pose, layout);
        }
        Ok(())
    }

    /// The poses of rest nearby that an object keeps best, leaning on what is there if need be, the cheapest first.
    pub fn rests_among_others(&self, object: usize, layout: &[scene::Pose]) -> Result<Vec<scene::Pose>, BackendError> {
        let others = self.others_near(object, &vec![true; layout.len()], layout);
        let placed = |i: usize, pose: &scene::Pose| Placed::new(&self.rigs[i], &self.rigs[i].body(pose));
        let beside: Vec<Placed> = others.iter().map(|&other| placed(other, &layout[other])).collect();
        let around = |size: f64| directions().map(move |along| along * size);
        let bearer = self.bearer(object, layout);
        let turned = |tilt: DVec3| {
            let pose = self.turned(object, tilt, &layout[object]);
            (pose, bearer.as_ref().map(|_| self.footprint(object, &pose)))
        };
        let turned: Vec<_> = once(DVec3::ZERO).chain(PLACE_TILTS.into_iter().flat_map(around)).map(turned).collect();
        let start = |aside: DVec3, (pose, footprint): &(scene::Pose, Option<Solid>)| {
            let start = self.aside_at_height(object, pose, footprint.as_ref(), aside, bearer.as_ref());
            let body = placed(object, &start);
            // What starts inside another is thrown.
            (!beside.iter().any(|other| other.overlaps(Vec3::ZERO, &body, OVERLAP))).then_some(start)
        };
        let starts = |size: f64| {
            let asides: Vec<DVec3> = if size == 0.0 { vec![DVec3::ZERO] } else { around(size).collect() };
            let starts = |aside: DVec3| turned.iter().filter_map(|turned| start(aside, turned)).collect::<Vec<_>>();
            asides.into_par_iter().flat_map_iter(starts).collect()
        };
        self.nearest_rests(object, &others, f32::INFINITY, &PLACE_SHIFTS, starts, layout)
    }

    /// The poses in which an object comes to rest from `starts`, which are so far `aside` (m, the nearest first), with its
    /// parent and these others held, the cheapest first. Only what costs less than its `fall`, rad.
    fn nearest_rests(
        &self,
        object: usize,
        others: &[usize],
        fall: f32,
        asides: &[f64],
        starts: impl Fn(f64) -> Vec<scene::Pose>,
        layout: &[scene::Pose],
    ) -> Result<Vec<scene::Pose>, BackendError> {
        let was = layout[object];
        let way = |pose: &scene::Pose| self.rigs[object].center_of(pose) - self.rigs[object].center_of(&was);
        let far = |pose: &scene::Pose| angle(pose, &was) + self.position * way(pose).with_y(0.0).length();
        let within = |pose: &scene::Pose, limit: f64| {
            angle(pose, &was) < limit * NEARLY_FALLEN
                && way(pose).with_y(0.0).length() < limit * ROLL_WITHIN
                && way(pose).y.abs() < limit * f64::from(MAX_SLIDE)
        };
        // What rolls on its parent alone does not go aside for that.
        let set_down = |rest: Rest| match others {
            [] => self.set_down(object, rest.pose.rotation, layout),
            _ => rest.pose,
        };
        let held = self.held(others, layout);
        let mut rests: Vec<scene::Pose> = Vec::new();
        for &aside in asides {
            // From farther away it comes to rest farther away.
            if rests.len() == NEAREST && rests.last().is_some_and(|last| far(last) < self.position * aside) {
                break;
            }
            let ends = self.rests_within(&|pose| within(pose, ASTRAY), object, &held, layout, &starts(aside))?;
            let borne = ends.into_iter().flatten().filter(|rest| self.is_borne(object, Some(rest), layout));
            rests.extend(borne.map(set_down).filter(|pose| within(pose, 1.0)));
            rests.sort_by(|a, b| far(a).total_cmp(&far(b)));
            rests = distinct(rests);
        }
        let unsteady = self.unsteady(object, others, &rests, layout)?;
        let costs = rests.iter().zip(unsteady).map(|(pose, unsteady)| far(pose) + UNSTEADY * unsteady);
        let mut costs: Vec<(f64, scene::Pose)> = costs.zip(rests.iter().copied()).collect();
        costs.retain(|(cost, _)| *cost < f64::from(fall));
        costs.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(costs.into_iter().map(|(_, pose)| pose).collect())
    }

    /// How far from poses of rest the object ends that is tilted a little from them, on average over four sides and all
    /// decompositions, rad.
    fn unsteady(
        &self,
        object: usize,
        others: &[usize],
        rests: &[scene::Pose],
        layout: &[scene::Pose],
    ) -> Result<Vec<f64>, BackendError> {
        let nudges: [DVec3; 4] = [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z].map(|axis| axis * NUDGE);
        let bearer = self.bearer(object, layout);
        let nudged = |rest: &scene::Pose| nudges.map(|nudge| self.tilted(object, nudge, rest, bearer.as_ref()));
        let nudged: Vec<scene::Pose> = rests.iter().flat_map(nudged).collect();
        let mut unsteady = vec![0.0; rests.len()];
        let seats = self.with_all_parts();
        for seat in &seats {
            let ends = seat.rests(object, &seat.held(others, layout), layout, &nudged)?;
            for ((rest, ends), unsteady) in rests.iter().zip(ends.chunks(nudges.len())).zip(&mut unsteady) {
                let away = |end: &Option<Rest>| end.as_ref().map_or(1.0, |end| angle(&end.pose, rest).min(1.0));
                *unsteady += ends.iter().map(away).sum::<f64>() / (nudges.len() * seats.len()) as f64;
            }
        }
        Ok(unsteady)
    }

    /// The object at a pose and tilted from it, at the height at which it rests on its parent.
    fn tilted(&self, object: usize, tilt: DVec3, pose: &scene::Pose, bearer: Option<&Solid>) -> scene::Pose {
        self.at_height(object, self.turned(object, tilt, pose), bearer)
    }

    /// The object at a pose and tilted from it.
    fn turned(&self, object: usize, tilt: DVec3, pose: &scene::Pose) -> scene::Pose {
        self.rigs[object].turned(pose, DQuat::from_scaled_axis(tilt) * pose.rotation)
    }

    /// The object turned so about its centre of mass, at the height at which it rests on its parent.
    pub(super) fn set_down(&self, object: usize, rotation: DQuat, layout: &[scene::Pose]) -> scene::Pose {
        let turned = self.rigs[object].turned(&layout[object], rotation);
        self.at_height(object, turned, self.bearer(object, layout).as_ref())
    }
}

/// The first poses, without those that are almost as an earlier one.
fn distinct(poses: Vec<scene::Pose>) -> Vec<scene::Pose> {
    let differ =
        |a: &scene::Pose, b: &scene::Pose| angle(a, b) > APART || a.translation.distance(b.translation) > PLACES_APART;
    let mut distinct: Vec<scene::Pose> = Vec::new();
    for pose in poses {
        if distinct.len() < NEAREST && distinct.iter().all(|other| differ(other, &pose)) {
            distinct.push(pose);
        }
    }
    distinct
}
