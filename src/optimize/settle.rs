//! The last descent: the winner is simulated with damping and a slow push-out until everything is at rest.
//!
//! What is shipped is where things rest, not where the search placed them: a candidate may overlap a little or hang a
//! millimetre in the air, and every other engine would turn that into motion.

use super::config::SettleSettings;
use super::tolerances::REST_SECONDS;
use crate::world::{
    Backend, BackendError, CemSettings, Flow, Pose, SearchSettings, SimSettings, Status, Velocity, World,
};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

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

/// Simulates from `starts`, candidate-major, each candidate until it is at rest, or until `goes_on` stops it at poses of
/// its bodies: it does not depend on the others.
pub(super) fn settle(
    backend: &dyn Backend,
    world: &World,
    simulation: &SimSettings,
    settings: &SettleSettings,
    starts: &[Pose],
    goes_on: &dyn Fn(&[Pose]) -> Flow,
) -> Result<Settled, BackendError> {
    let damped = SimSettings {
        steps: steps(settings.max_seconds, simulation.dt),
        linear_damping: settings.damping,
        angular_damping: settings.damping,
        max_push_out: settings.max_push_out,
        ..simulation.clone()
    };
    let bodies = world.bodies.len();
    let mut all = Settled { usable: Vec::new(), poses: starts.to_vec(), seconds: 0.0, at_rest: true };
    in_portions(backend, world, starts, &mut |portion| {
        let (starts, poses) = (&starts[portion.clone()], &mut all.poses[portion]);
        poses.copy_from_slice(starts);
        let mut rest = Rest::new(starts.len() / bodies, damped.dt, settings.rest_speed);
        let statuses = backend.simulate_each(world, &damped, starts, &mut |candidate, now, velocities| {
            poses[candidate * bodies..(candidate + 1) * bodies].copy_from_slice(now);
            match goes_on(now) {
                Flow::Continue => rest.watch(candidate, velocities),
                Flow::Stop => Flow::Stop,
            }
        })?;
        all.usable.extend(usable(&statuses, poses));
        all.seconds = all.seconds.max(f64::from(rest.steps()) * f64::from(damped.dt));
        all.at_rest &= rest.all();
        Ok(())
    })?;
    Ok(all)
}

/// Nothing stops a candidate before it is at rest.
pub(super) fn to_rest(_: &[Pose]) -> Flow {
    Flow::Continue
}

/// What nothing stops.
pub(super) static GO_ON: AtomicBool = AtomicBool::new(false);

/// Whether to go on.
pub(super) fn flow(stop: &AtomicBool) -> Flow {
    if stop.load(Ordering::Relaxed) { Flow::Stop } else { Flow::Continue }
}

/// Tells which candidates have come to rest: all bodies slow for half a second.
pub(super) struct Rest {
    /// m/s and rad/s.
    speed: f32,
    /// Steps that it takes.
    enough: u32,
    /// Steps of each candidate since something in it was faster, and since its start.
    quiet: Vec<u32>,
    taken: Vec<u32>,
}

impl Rest {
    pub fn new(candidates: usize, dt: f32, speed: f32) -> Self {
        Self { speed, enough: steps(REST_SECONDS, dt), quiet: vec![0; candidates], taken: vec![0; candidates] }
    }

    /// Takes note of a candidate's next step; `Flow::Stop` once it is at rest.
    pub fn watch(&mut self, candidate: usize, velocities: &[Velocity]) -> Flow {
        let slow = |v: &Velocity| v.linear.length().max(v.angular.length()) <= self.speed;
        let quiet = &mut self.quiet[candidate];
        *quiet = if velocities.iter().all(slow) { *quiet + 1 } else { 0 };
        self.taken[candidate] += 1;
        if *quiet < self.enough { Flow::Continue } else { Flow::Stop }
    }

    /// Most steps that a candidate has taken.
    fn steps(&self) -> u32 {
        self.taken.iter().copied().max().unwrap_or(0)
    }

    /// True if all candidates are at rest.
    fn all(&self) -> bool {
        self.quiet.iter().all(|quiet| *quiet >= self.enough)
    }
}

/// Calls `simulate` with the ranges of poses of as many candidates at a time as the backend says that it simulates, and
/// of fewer from where it has too little room for their contacts. A range may come twice.
pub(super) fn in_portions(
    backend: &dyn Backend,
    world: &World,
    starts: &[Pose],
    simulate: &mut dyn FnMut(Range<usize>) -> Result<(), BackendError>,
) -> Result<(), BackendError> {
    let bodies = world.bodies.len().max(1);
    let candidates = starts.len() / bodies;
    let cem = CemSettings { candidates: candidates as u32, ..CemSettings::default() };
    let mut size = backend.memory(world, &SearchSettings { cem, ..Default::default() }).at_once.max(1) as usize;
    let mut first = 0;
    while first < candidates {
        let end = (first + size).min(candidates);
        match simulate(first * bodies..end * bodies) {
            Ok(()) => first = end,
            Err(BackendError::Capacity(_)) if size > 1 => size = (end - first).div_ceil(2),
            Err(error) => return Err(error),
        }
    }
    Ok(())
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
