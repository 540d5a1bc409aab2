//! What rolls is set down in the pose of rest that is nearest to its reconstruction: a pear that is let go comes to lie
//! anywhere, often on its other side.

use super::tolerances::{APART, MAX_SLIDE, NEAREST, NUDGE, TILTS, UNSTEADY};
use super::{Rest, Seat};
use crate::optimize::{directions::directions, posture::angle, tolerances::FALLEN};
use crate::scene;
use crate::world::BackendError;
use glam::{DQuat, DVec3};

impl Seat<'_> {
    /// Turns an object, with everything on it, to the pose of rest on its parent that is near to its own and that it
    /// keeps with all decompositions. Left as it was if that takes it farther than the `fall` that it would take
    /// otherwise, rad, or if it would have fallen over.
    pub(super) fn set_at_rest(&self, object: usize, fall: f32, layout: &mut [scene::Pose]) -> Result<(), BackendError> {
        let was = layout[object];
        let center = |pose: &scene::Pose| self.rigs[object].center_of(pose);
        let tilted = |pose: &scene::Pose, tilt: DVec3| {
            self.set_down(object, DQuat::from_scaled_axis(tilt) * pose.rotation, layout)
        };
        let tilts = TILTS.iter().flat_map(|&tilt| directions().map(move |axis| axis * tilt));
        let starts: Vec<scene::Pose> = tilts.map(|tilt| tilted(&was, tilt)).collect();
        let mut rests: Vec<scene::Pose> = (self.rests(object, &[], layout, &starts)?.into_iter().flatten())
            .filter(|rest| self.is_borne(object, Some(rest), layout))
            .map(|rest| self.set_down(object, rest.pose.rotation, layout))
            .filter(|pose| angle(pose, &was) < FALLEN && center(pose).distance(center(&was)) < f64::from(MAX_SLIDE))
            .collect();
        rests.sort_by(|a, b| angle(a, &was).total_cmp(&angle(b, &was)));
        let rests = distinct(rests);

        let nudges: Vec<DVec3> = [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z].map(|axis| axis * NUDGE).into();
        let nudged = |pose| nudges.iter().map(move |&nudge| tilted(pose, nudge));
        let nudged: Vec<scene::Pose> = rests.iter().flat_map(nudged).collect();
        let mut unsteady = vec![0.0; rests.len()];
        let seats = self.with_all_parts();
        for seat in &seats {
            let ends = seat.rests(object, &[], layout, &nudged)?;
            for ((pose, ends), unsteady) in rests.iter().zip(ends.chunks(nudges.len())).zip(&mut unsteady) {
                let away = |end: &Option<Rest>| end.as_ref().map_or(1.0, |end| angle(&end.pose, pose).min(1.0));
                *unsteady += ends.iter().map(away).sum::<f64>() / (nudges.len() * seats.len()) as f64;
            }
        }
        let costs = rests.iter().zip(unsteady).map(|(pose, unsteady)| (pose, angle(pose, &was) + UNSTEADY * unsteady));
        let cheapest = costs.min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((pose, _)) = cheapest.filter(|(_, cost)| *cost < f64::from(fall)) {
            self.carry(object, *pose, layout);
        }
        Ok(())
    }

    /// The object turned so about its centre of mass, at the height at which it rests on its parent.
    pub(super) fn set_down(&self, object: usize, rotation: DQuat, layout: &[scene::Pose]) -> scene::Pose {
        let mut turned = layout.to_vec();
        turned[object] = self.rigs[object].turned(&layout[object], rotation);
        self.settle_height(object, &mut turned);
        turned[object]
    }
}

/// The first poses, without those that are almost as an earlier one.
fn distinct(poses: Vec<scene::Pose>) -> Vec<scene::Pose> {
    let mut distinct: Vec<scene::Pose> = Vec::new();
    for pose in poses {
        if distinct.len() < NEAREST && distinct.iter().all(|other| angle(other, &pose) > APART) {
            distinct.push(pose);
        }
    }
    distinct
}
