//! What rolls is set down in the pose of rest that is nearest to its reconstruction: a pear that is let go comes to lie
//! anywhere, often on its other side.

use super::edge::directions;
use super::finish::{FALLEN, angle};
use super::seat::{MAX_SLIDE, Rest, Seat};
use crate::scene;
use crate::world::BackendError;
use glam::{DQuat, DVec3};

/// How far the object is tilted to all sides before it is let go, rad.
const TILTS: [f64; 5] = [0.05, 0.1, 0.2, 0.3, 0.45];

/// Poses nearer to each other than this are one, rad.
const APART: f64 = 0.04;

/// How many of the nearest poses of rest are looked at.
const NEAREST: usize = 12;

/// The tilt, to four sides, from which an object shall come back, rad (1.1°): other engines and other decompositions have
/// such errors.
const NUDGE: f64 = 0.02;

/// What a radian costs that it ends away from there, on average over all decompositions, in radians from the
/// reconstruction.
const UNSTEADY: f64 = 3.0;

impl Seat<'_> {
    /// Turns an object, with everything on it, to the pose of rest on its parent that is near to its own and that it keeps
    /// with all decompositions. Left as it was if that takes it farther than the `fall` that it would take otherwise, rad, or
    /// if it would have fallen over.
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
