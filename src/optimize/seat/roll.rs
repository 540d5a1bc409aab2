//! What rolls is set down in the pose of rest that is nearest to its reconstruction: a pear that is let go comes to lie
//! anywhere, often on its other side. What still fails after the search is looked for a place among the others, where it
//! may lean on them.

use super::tolerances::{
    APART, MAX_SLIDE, NEAREST, NUDGE, OVERLAP, PLACE_SHIFTS, PLACE_TILTS, PLACES_APART, ROLL_WITHIN, TILTS, UNSTEADY,
    WAY,
};
use super::{Rest, Seat, height::Solid};
use crate::optimize::{directions::directions, posture::angle, support::Placed, tolerances::FALLEN};
use crate::scene;
use crate::world::BackendError;
use glam::{DQuat, DVec3, Vec3};
use rayon::prelude::*;
use std::iter::once;

impl Seat<'_> {
    /// Turns an object, with everything on it, to the pose of rest on its parent that is near to its own and that it
    /// keeps with all decompositions. Left as it was if that takes it farther than the `fall` that it would take
    /// otherwise, rad, or if it would have fallen over.
    pub(super) fn set_at_rest(&self, object: usize, fall: f32, layout: &mut [scene::Pose]) -> Result<(), BackendError> {
        let bearer = self.bearer(object, layout);
        let tilts = TILTS.iter().flat_map(|&tilt| directions().map(move |axis| axis * tilt));
        let starts: Vec<scene::Pose> =
            tilts.map(|tilt| self.tilted(object, tilt, &layout[object], bearer.as_ref())).collect();
        self.keep_nearest_rest(object, &[], fall, &starts, layout)?;
        Ok(())
    }

    /// Sets an object down nearby, leaning on what is there if need be, in the pose of rest that it keeps best. False, and
    /// left as it was, if there is none.
    pub fn set_down_among_others(&self, object: usize, layout: &mut [scene::Pose]) -> Result<bool, BackendError> {
        let others = self.others_near(object, &vec![true; layout.len()], layout);
        let placed = |i: usize, pose: &scene::Pose| Placed::new(&self.rigs[i], &self.rigs[i].body(pose));
        let beside: Vec<Placed> = others.iter().map(|&other| placed(other, &layout[other])).collect();
        let around = |&size: &f64| directions().map(move |along| along * size);
        let shifts: Vec<DVec3> = once(DVec3::ZERO).chain(PLACE_SHIFTS.iter().flat_map(around)).collect();
        let tilts: Vec<DVec3> = once(DVec3::ZERO).chain(PLACE_TILTS.iter().flat_map(around)).collect();
        let bearer = self.bearer(object, layout);
        let start = |&shift: &DVec3, &tilt: &DVec3| {
            let here = scene::Pose { translation: layout[object].translation + shift, ..layout[object] };
            let start = self.tilted(object, tilt, &here, bearer.as_ref());
            let body = placed(object, &start);
            // What starts inside another is thrown.
            (!beside.iter().any(|other| other.overlaps(Vec3::ZERO, &body, OVERLAP))).then_some(start)
        };
        let starts = shifts.par_iter().flat_map_iter(|shift| tilts.iter().filter_map(|tilt| start(shift, tilt)));
        let starts: Vec<scene::Pose> = starts.collect();
        self.keep_nearest_rest(object, &others, f32::INFINITY, &starts, layout)
    }

    /// Of the poses in which an object comes to rest from `starts`, with its parent and these others held, takes the
    /// cheapest, with everything on it. False, and left as it was, if none costs less than its `fall`, rad.
    fn keep_nearest_rest(
        &self,
        object: usize,
        others: &[usize],
        fall: f32,
        starts: &[scene::Pose],
        layout: &mut [scene::Pose],
    ) -> Result<bool, BackendError> {
        let was = layout[object];
        let way = |pose: &scene::Pose| self.rigs[object].center_of(pose) - self.rigs[object].center_of(&was);
        let far = |pose: &scene::Pose| angle(pose, &was) + WAY * way(pose).with_y(0.0).length();
        let near = |pose: &scene::Pose| {
            angle(pose, &was) < FALLEN
                && way(pose).with_y(0.0).length() < ROLL_WITHIN
                && way(pose).y.abs() < f64::from(MAX_SLIDE)
        };
        // What rolls on its parent alone does not go aside for that.
        let set_down = |rest: Rest| match others {
            [] => self.set_down(object, rest.pose.rotation, layout),
            _ => rest.pose,
        };
        let mut rests: Vec<scene::Pose> =
            (self.rests(object, &self.held(others, layout), layout, starts)?.into_iter().flatten())
                .filter(|rest| self.is_borne(object, Some(rest), layout))
                .map(set_down)
                .filter(near)
                .collect();
        rests.sort_by(|a, b| far(a).total_cmp(&far(b)));
        let rests = distinct(rests);
        let unsteady = self.unsteady(object, others, &rests, layout)?;
        let costs = rests.iter().zip(unsteady).map(|(pose, unsteady)| (pose, far(pose) + UNSTEADY * unsteady));
        let cheapest = costs.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, cost)| *cost < f64::from(fall));
        if let Some((pose, _)) = cheapest {
            self.carry(object, *pose, layout);
        }
        Ok(cheapest.is_some())
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
        let rotation = DQuat::from_scaled_axis(tilt) * pose.rotation;
        self.at_height(object, self.rigs[object].turned(pose, rotation), bearer)
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
