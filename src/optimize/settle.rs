//! The last descent: the winner is simulated with damping and a slow push-out until everything is at rest.
//!
//! What is shipped is where things rest, not where the search placed them: a candidate may overlap a little or hang a
//! millimetre in the air, and every other engine would turn that into motion.

use super::config::SettleSettings;
use crate::world::{Backend, BackendError, Flow, Pose, SimSettings, Status, Velocity, World};

/// How long everything must be slow before it counts as at rest, s.
const REST_SECONDS: f32 = 0.5;

/// Where the bodies of one or several candidates came to rest.
#[derive(Clone, Debug)]
pub(super) struct Settled {
    /// Which candidates could be simulated.
    pub usable: Vec<bool>,
    /// Pose of every body, candidate-major.
    pub poses: Vec<Pose>,
    /// Simulated time, s.
    pub seconds: f64,
    /// False if something still moved when the time was up.
    pub at_rest: bool,
}

/// Simulates from `starts`, candidate-major, until all are at rest.
pub(super) fn settle(
    backend: &dyn Backend,
    world: &World,
    simulation: &SimSettings,
    settings: &SettleSettings,
    starts: &[Pose],
) -> Result<Settled, BackendError> {
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
    let usable = usable(&status, &poses);
    let seconds = f64::from(taken) * f64::from(damped.dt);
    Ok(Settled { usable, poses, seconds, at_rest: quiet >= quiet_steps })
}

/// Which candidates have results that mean something.
pub(super) fn usable(statuses: &[Status], poses: &[Pose]) -> Vec<bool> {
    let bodies = (poses.len() / statuses.len().max(1)).max(1);
    let finite = poses.chunks_exact(bodies).map(|poses| poses.iter().all(Pose::is_finite));
    statuses.iter().zip(finite).map(|(status, finite)| status.is_usable() && finite).collect()
}

/// Steps that so many seconds take.
pub(super) fn steps(seconds: f32, dt: f32) -> u32 {
    (seconds / dt).round() as u32
}
