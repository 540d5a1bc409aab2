//! The direction that is up in a scene, by a robust vote of its objects.
//!
//! What rests on something votes for the up of the base that it stands on, and so do fixed objects; what hangs or is on
//! a wall votes for its mesh's own +Y, and so does what has no flat base, where the scene's meshes are modelled
//! upright. Objects are wrong by degrees one by one and some are quite wrong, so the vote starts at the direction with
//! the most support and is a mean that is reweighted by Cauchy's function, not one of least squares.

use super::stance::{Stance, support};
use super::tolerances::{AGREEMENT, AXIS_WEIGHT, BORNE_WEIGHT, ITERATIONS, LEVEL, MAX_TILT, MIN_TILT};
use crate::scene::{Object, Parent, Root};
use glam::DVec3;

/// The ups among which one object may decide, world frame, with what they count for.
pub(super) struct Vote {
    options: Vec<(DVec3, f64)>,
    /// True for an object that will be set upright.
    rests: bool,
}

/// What the objects say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Vertical {
    /// Unit vector; +Y if the objects give no reason for another.
    pub up: DVec3,
    /// Objects with a say.
    pub votes: usize,
    /// Weighted median of the angles between their ups and the result, rad.
    pub spread: f64,
    /// Angle between +Y and what the objects say, rad, even where it is too small for `up` to follow it.
    pub tilt: f64,
}

/// The vote of one object. `trusted`: the mesh's own +Y is its up; `rests`: it stands freely on something.
pub(super) fn vote(object: &Object, stances: &[Stance], rests: bool, trusted: bool) -> Option<Vote> {
    let grounded = matches!(object.parent, Parent::Root(Root::Ground | Root::GroundWall));
    let weight = if grounded { 1.0 } else { BORNE_WEIGHT };
    let fixed = matches!(object.parent, Parent::Root(Root::Wall | Root::Ceiling));
    let mut options: Vec<(DVec3, f64)> = match fixed {
        true => Vec::new(),
        false => stances.iter().map(|s| (object.pose.rotation * s.up, weight * s.weight())).collect(),
    };
    if options.is_empty() && trusted {
        options.push((object.pose.rotation * DVec3::Y, weight * AXIS_WEIGHT));
    }
    (!options.is_empty()).then_some(Vote { options, rests })
}

/// The scene's up.
pub(super) fn vertical(votes: &[Vote]) -> Vertical {
    let mut up = consensus(votes);
    for _ in 0..ITERATIONS {
        let sum: DVec3 =
            (votes.iter().map(|vote| vote.nearest(up))).map(|(axis, weight)| axis * weight * support(axis, up)).sum();
        up = sum.try_normalize().unwrap_or(up);
    }
    let found = up.angle_between(DVec3::Y);
    let tilt = if found > MAX_TILT || is_level(votes) { 0.0 } else { found };
    if tilt < MIN_TILT {
        up = DVec3::Y;
    }
    Vertical { up, votes: votes.len(), spread: spread(votes, up), tilt }
}

impl Vote {
    /// The option that supports `up` most, with its weight.
    fn nearest(&self, up: DVec3) -> (DVec3, f64) {
        let worth = |&(axis, weight): &(DVec3, f64)| weight * support(axis, up);
        self.options.iter().copied().max_by(|a, b| worth(a).total_cmp(&worth(b))).unwrap_or((up, 0.0))
    }
}

/// The option within reach of +Y that has the most support.
fn consensus(votes: &[Vote]) -> DVec3 {
    let mut best = (0.0, DVec3::Y);
    for &(candidate, _) in votes.iter().flat_map(|vote| &vote.options) {
        if candidate.angle_between(DVec3::Y) > MAX_TILT {
            continue;
        }
        let total: f64 = (votes.iter().map(|vote| vote.nearest(candidate)))
            .map(|(axis, weight)| weight * support(axis, candidate))
            .sum();
        if total > best.0 {
            best = (total, candidate);
        }
    }
    best.1
}

/// True if most of what rests stands exactly upright already: those objects have been canonicalized, and what hangs
/// crooked on a wall is no reason to turn them again.
fn is_level(votes: &[Vote]) -> bool {
    let resting = votes.iter().filter(|vote| vote.rests).map(|vote| vote.nearest(DVec3::Y));
    let (mut level, mut all) = (0.0, 0.0);
    for (axis, weight) in resting {
        all += weight;
        level += if axis.angle_between(DVec3::Y) < LEVEL { weight } else { 0.0 };
    }
    level > 0.5 * all
}

fn spread(votes: &[Vote], up: DVec3) -> f64 {
    let mut angles: Vec<(f64, f64)> =
        votes.iter().map(|vote| vote.nearest(up)).map(|(axis, weight)| (axis.angle_between(up), weight)).collect();
    angles.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * angles.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut passed = 0.0;
    let median = angles.iter().find(|(_, weight)| {
        passed += weight;
        passed >= half
    });
    median.map_or(0.0, |(angle, _)| *angle)
}

/// True if the meshes were modelled upright, so that their own +Y says what is up: most bases agree with it. Meshes in
/// the frame of the whole reconstruction share one rotation and say nothing.
pub(super) fn axes_are_up(objects: &[Object], stances: &[Vec<Stance>]) -> bool {
    let one_rotation =
        objects.windows(2).all(|pair| pair[0].pose.rotation.angle_between(pair[1].pose.rotation) < LEVEL);
    let own: Vec<bool> = (stances.iter().filter(|stances| !stances.is_empty()))
        .map(|stances| stances.iter().any(|stance| stance.up.angle_between(DVec3::Y) < AGREEMENT))
        .collect();
    let agreeing = own.iter().filter(|agrees| **agrees).count();
    objects.len() > 1 && !one_rotation && 2 * agreeing > own.len()
}
