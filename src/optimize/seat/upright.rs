//! Objects that lean a little: set upright, or put back to where they were after they have righted themselves.

use super::tolerances::{ASIDE, ROLLS};
use super::{Rest, Seat};
use crate::optimize::{posture::upright, tolerances::LEAN};
use crate::scene::Pose;
use crate::world::BackendError;

impl Seat<'_> {
    /// Where the object rests with its centre where it was reconstructed: a wardrobe that leans rights itself about its
    /// lower edge, and its top goes aside by twice the error of the reconstruction. As it came to rest if it does not
    /// rest there.
    pub(super) fn put_back(&self, object: usize, rest: &Rest, layout: &[Pose]) -> Result<Pose, BackendError> {
        if rest.shift < ASIDE {
            return Ok(rest.pose);
        }
        let back = self.set_down(object, rest.pose.rotation, layout);
        let again = self.rests(object, &[], layout, &[back])?.remove(0);
        let way = |pose: &Pose| {
            let center = |pose| self.rigs[object].center_of(pose).with_y(0.0);
            center(pose).distance(center(&layout[object]))
        };
        let better = again.filter(|again| {
            let rests = again.turn < ROLLS && again.stays() && self.is_borne(object, Some(again), layout);
            rests && way(&again.pose) < way(&rest.pose)
        });
        Ok(better.map_or(rest.pose, |again| again.pose))
    }

    /// A leaning object upright, at the height at which it rests on its parent; none if it does not lean like one.
    pub(super) fn upright(&self, object: usize, layout: &[Pose]) -> Option<Pose> {
        let upright = upright(&layout[object], self.rigs[object].center_of(&layout[object]), LEAN)?;
        Some(self.set_down(object, upright.rotation, layout))
    }

    /// Sets a leaning object upright if it stays there and has turned less than the `fall` that it would take
    /// otherwise, rad: a round fruit rolls to rest by itself. False if it was left as it was.
    pub(super) fn set_upright(&self, object: usize, fall: f32, layout: &mut [Pose]) -> Result<bool, BackendError> {
        let leaning = layout.to_vec();
        let Some(upright) = self.upright(object, layout) else {
            return Ok(false);
        };
        self.carry(object, upright, layout);
        let lean = upright.rotation.angle_between(leaning[object].rotation) as f32;
        let rest = self.rest(object, layout)?.filter(|rest| rest.stays() && lean + rest.turn < fall);
        match &rest {
            Some(rest) => self.carry(object, rest.pose, layout),
            None => layout.copy_from_slice(&leaning),
        }
        Ok(rest.is_some())
    }
}
