//! The last descent: the winner is simulated with damping and a slow push-out until everything is at rest.
//!
//! What is shipped is where things rest, not where the search placed them: a candidate may overlap a little or hang a
//! millimetre in the air, and every other engine would turn that into motion.

use super::config::SettleSettings;
use crate::world::{Backend, BackendError, Flow, Pose, SimSettings, Velocity, World};

/// How long everything must be slow before it counts as at rest, s.
const REST_SECONDS: f32 = 0.5;

/// Where the bodies came to rest.
#[derive(Clone, Debug)]
pub(super) struct Settled {
    /// Pose of every body.
    pub poses: Vec<Pose>,
    /// Simulated time, s.
    pub seconds: f64,
    /// False if something still moved when the time was up.
    pub at_rest: bool,
}

/// Simulates from `starts` to rest; none if the simulation failed.
pub(super) fn settle(
    backend: &dyn Backend,
    world: &World,
    simulation: &SimSettings,
    settings: &SettleSettings,
    starts: &[Pose],
) -> Result<Option<Settled>, BackendError> {
    let damped = SimSettings {
        steps: steps(settings.max_seconds, simulation.dt),
        linear_damping: settings.damping,
        angular_damping: settings.damping,
        max_push_out: settings.max_push_out,
        ..simulation.clone()
    };
    let quiet_steps = steps(REST_SECONDS, damped.dt);
    let (mut quiet, mut taken) = (0, 0);
    let mut poses = starts.to_vec();
    let status = backend.simulate(world, &damped, starts, &mut |_, now, velocities| {
        poses.copy_from_slice(now);
        taken += 1;
        let slow = |v: &Velocity| v.linear.length().max(v.angular.length()) <= settings.rest_speed;
        quiet = if velocities.iter().all(slow) { quiet + 1 } else { 0 };
        if quiet >= quiet_steps { Flow::Stop } else { Flow::Continue }
    })?;
    let usable = status.iter().all(|s| s.is_usable()) && poses.iter().all(Pose::is_finite);
    let seconds = f64::from(taken) * f64::from(damped.dt);
    Ok(usable.then_some(Settled { poses, seconds, at_rest: quiet >= quiet_steps }))
}

/// Steps that so many seconds take.
pub(super) fn steps(seconds: f32, dt: f32) -> u32 {
    (seconds / dt).round() as u32
}
