//! How an object stands: how far it has turned, how far it leans, and how it would stand upright.

use crate::scene::Pose;
use glam::{DQuat, DVec3};
use std::ops::Range;

/// Angle between two poses, rad; accurate for small ones.
pub(super) fn angle(a: &Pose, b: &Pose) -> f64 {
    let d = a.rotation.conjugate() * b.rotation;
    2.0 * d.xyz().length().atan2(d.w.abs())
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

/// The pose turned about `center` so that the axis of the mesh which is nearest to the vertical is vertical; none if
/// its lean, rad, is not within the range.
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
