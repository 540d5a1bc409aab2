//! Objects that lean a little: set upright, or put back to where they were after they have righted themselves.

use super::seat::{Rest, Seat};
use crate::scene::Pose;
use crate::world::BackendError;
use glam::{DQuat, DVec3};
use std::ops::Range;

/// An object that leans by less (1°) or by more (20°) than this is not taken for an upright one that leans, rad.
pub(super) const LEAN: Range<f64> = 0.017..0.35;

/// What has come to rest farther aside than this is put back there, m.
const ASIDE: f32 = 2e-3;

/// If it turns on there by more than this, it rolls, rad.
const ROLLS: f32 = 0.01;

impl Seat<'_> {
    /// Where the object rests with its centre where it was reconstructed: a wardrobe that leans rights itself about its lower
    /// edge, and its top goes aside by twice the error of the reconstruction. As it came to rest if it does not rest there.
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

    /// Sets a leaning object upright if it stays there and has turned less than the `fall` that it would take otherwise,
    /// rad: a round fruit rolls to rest by itself. False if it was left as it was.
    pub(super) fn set_upright(&self, object: usize, fall: f32, layout: &mut [Pose]) -> Result<bool, BackendError> {
        let leaning = layout.to_vec();
        let Some(upright) = upright(&leaning[object], self.rigs[object].center_of(&leaning[object]), LEAN) else {
            return Ok(false);
        };
        self.carry(object, upright, layout);
        self.settle_height(object, layout);
        let lean = upright.rotation.angle_between(leaning[object].rotation) as f32;
        let rest = self.rest(object, layout)?.filter(|rest| rest.stays() && lean + rest.turn < fall);
        match &rest {
            Some(rest) => self.carry(object, rest.pose, layout),
            None => layout.copy_from_slice(&leaning),
        }
        Ok(rest.is_some())
    }
}

/// The axis of the mesh that is nearest to the vertical, pointing up, in the world. Meshes are modelled upright.
pub(super) fn up_axis(pose: &Pose) -> DVec3 {
    let up = pose.rotation.conjugate() * DVec3::Y;
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let nearest = axes.into_iter().max_by(|a, b| a.dot(up).abs().total_cmp(&b.dot(up).abs())).unwrap_or(DVec3::Y);
    pose.rotation * (nearest * nearest.dot(up).signum())
}

/// Angle between the vertical and the axis of the mesh that is nearest to it, rad.
pub(super) fn lean(pose: &Pose) -> f64 {
    up_axis(pose).angle_between(DVec3::Y)
}

/// The pose turned about `center` so that the axis of the mesh which is nearest to the vertical is vertical; none if its
/// lean, rad, is not within the range.
pub(super) fn upright(pose: &Pose, center: DVec3, leans: Range<f64>) -> Option<Pose> {
    let axis = up_axis(pose);
    let turn = DQuat::from_rotation_arc(axis, DVec3::Y);
    leans.contains(&axis.angle_between(DVec3::Y)).then(|| Pose {
        rotation: (turn * pose.rotation).normalize(),
        translation: center + turn * (pose.translation - center),
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn a_leaning_object_is_set_upright_about_its_centre() {
        let tilt = DQuat::from_rotation_y(0.7) * DQuat::from_rotation_z(0.2);
        let pose = Pose { rotation: tilt, translation: DVec3::new(1.0, 2.0, 3.0) };
        assert!((lean(&pose) - 0.2).abs() < 1e-9);
        let center = pose.translation + tilt * DVec3::new(0.0, 0.5, 0.0);
        let set = upright(&pose, center, 0.1..0.3).unwrap();
        assert!((set.rotation * DVec3::Y).distance(DVec3::Y) < 1e-9);
        assert!((set.translation + set.rotation * DVec3::new(0.0, 0.5, 0.0)).distance(center) < 1e-9);
        let fallen = Pose { rotation: DQuat::from_rotation_z(0.7), ..pose };
        assert!(upright(&fallen, center, 0.1..0.3).is_none());
    }
}
