//! Which objects are set upright, how, and why not the others.

use super::stance::{Stance, nearest};
use super::tolerances::{LEVEL, MAX_LEAN, TURN_OVER, UPSIDE_DOWN};
use crate::scene::Pose;
use glam::{DQuat, DVec3};
use std::f64::consts::PI;

/// What is to be done with an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Verdict {
    /// It stands on a flat base.
    Upright,
    /// It leans on a flat base and is turned onto it by this rotation of the world.
    Leans(DQuat),
    /// It is upside down on next to nothing and is turned over by this rotation of the world.
    TurnedOver(DQuat),
    /// It is upside down, but stands well that way.
    UpsideDown,
    /// No flat base is near enough below it.
    NoBase,
}

/// Looks at an object. `trusted`: the mesh's own +Y is its up.
pub(super) fn judge(stances: &[Stance], pose: &Pose, trusted: bool) -> Verdict {
    let up = pose.rotation.conjugate() * DVec3::Y;
    let now = nearest(stances, up, MAX_LEAN);
    if trusted && up.angle_between(DVec3::NEG_Y) < UPSIDE_DOWN {
        // Turned over about its own front, so that it faces where it faced.
        let front = (pose.rotation * DVec3::Z).with_y(0.0).try_normalize().unwrap_or(DVec3::Z);
        let over = DQuat::from_axis_angle(front, PI);
        let up_then = (over * pose.rotation).conjugate() * DVec3::Y;
        return match nearest(stances, up_then, MAX_LEAN) {
            Some(then) if now.is_none_or(|now| then.area > TURN_OVER * now.area) => {
                Verdict::TurnedOver(raise(over * pose.rotation * then.up) * over)
            }
            _ => Verdict::UpsideDown,
        };
    }
    match now {
        None => Verdict::NoBase,
        Some(stance) if stance.up.angle_between(up) < LEVEL => Verdict::Upright,
        Some(stance) => Verdict::Leans(raise(pose.rotation * stance.up)),
    }
}

/// The shortest turn that makes `axis` vertical: it keeps the yaw.
fn raise(axis: DVec3) -> DQuat {
    DQuat::from_rotation_arc(axis.normalize(), DVec3::Y)
}
