//! The check of the result: one more simulation with the settings of a candidate, and what moved in it.

use super::config::VerifySettings;
use super::settle::{flow, in_portions, steps, usable};
use super::tolerances::{FARTHER, TURNED};
use crate::world::{Backend, BackendError, Pose, SimSettings, World, angle_between};
use std::sync::atomic::AtomicBool;

/// What one body did during the check.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motion {
    /// Distance between start and end, m.
    pub drift: f64,
    /// Angle between start and end, rad.
    pub turn: f64,
    /// Peak speed of the centre of mass, m/s.
    pub peak_speed: f64,
    /// Peak angular speed, rad/s.
    pub peak_spin: f64,
}

impl Motion {
    /// True if the body counts as stable.
    pub fn is_still(&self, limits: &VerifySettings) -> bool {
        self.is_within(1.0, limits)
    }

    /// True if the body moved hardly farther than in `other`.
    pub fn is_like(&self, other: &Self) -> bool {
        self.drift <= other.drift + FARTHER && self.turn <= other.turn + TURNED
    }

    /// True if the body moved by no more than this share of what is allowed.
    pub fn is_within(&self, share: f64, limits: &VerifySettings) -> bool {
        self.drift <= share * f64::from(limits.max_drift) && self.turn <= share * f64::from(limits.max_turn)
    }
}

/// Result of the check of one or several candidates.
#[derive(Clone, Debug)]
pub(super) struct Verified {
    /// Which candidates could be simulated.
    pub usable: Vec<bool>,
    /// One entry a body, candidate-major.
    pub motions: Vec<Motion>,
    /// Pose of every body at the end.
    pub poses: Vec<Pose>,
}

/// Simulates from `starts`, candidate-major. Once `stop` is true it ends, and the result means nothing.
pub(super) fn verify(
    backend: &dyn Backend,
    world: &World,
    simulation: &SimSettings,
    settings: &VerifySettings,
    starts: &[Pose],
    stop: &AtomicBool,
) -> Result<Verified, BackendError> {
    let simulation = SimSettings { steps: steps(settings.seconds, simulation.dt), ..simulation.clone() };
    let mut motions = vec![Motion::default(); starts.len()];
    let mut poses = starts.to_vec();
    let mut statuses = Vec::new();
    in_portions(backend, world, starts, &mut |portion| {
        let (poses, motions) = (&mut poses[portion.clone()], &mut motions[portion.clone()]);
        motions.fill(Motion::default());
        statuses.extend(backend.simulate(world, &simulation, &starts[portion], &mut |_, now, velocities| {
            poses.copy_from_slice(now);
            for (motion, velocity) in motions.iter_mut().zip(velocities) {
                motion.peak_speed = motion.peak_speed.max(velocity.linear.length().into());
                motion.peak_spin = motion.peak_spin.max(velocity.angular.length().into());
            }
            flow(stop)
        })?);
        Ok(())
    })?;
    for ((motion, start), end) in motions.iter_mut().zip(starts).zip(&poses) {
        motion.drift = end.translation.distance(start.translation).into();
        motion.turn = angle_between(end.rotation, start.rotation).into();
    }
    Ok(Verified { usable: usable(&statuses, &poses), motions, poses })
}
