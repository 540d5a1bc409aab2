//! How much the objects move when the scene is left to itself.

use super::{MAX_DRIFT, MAX_TURN, mean, percent};
use crate::optimize::{Rig, standing};
use crate::scene::Scene;
use crate::world::{Backend, BackendError, Flow, Pose, SimSettings, Velocity};
use serde::Serialize;

/// How the objects that can move do.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stability {
    /// Steps simulated, of 1/60 s.
    pub steps: u32,
    /// Objects that can move.
    pub movable: usize,
    /// All of them together; absent if there are none.
    #[serde(flatten)]
    pub means: Option<Means>,
    /// The simulation ran to its end with finite numbers and room for all contacts.
    pub valid: bool,
    /// One entry for each of them, in the scene's order.
    pub objects: Vec<ObjectMotion>,
}

/// Stable rate, drift and peak speeds (paper: stable rate, position drift, linear and angular velocity).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Means {
    /// Share of the objects that stay within [`MAX_DRIFT`] and [`MAX_TURN`], %.
    pub stable_rate_pct: f64,
    /// Mean distance of the centre of mass between placed and settled, m.
    pub mean_position_drift_m: f64,
    /// Mean angle between placed and settled, rad.
    pub mean_rotation_drift_rad: f64,
    /// Mean of the objects' highest speeds, m/s.
    pub mean_peak_linear_velocity_mps: f64,
    /// Mean of the objects' highest spins, rad/s.
    pub mean_peak_angular_velocity_radps: f64,
}

/// The same of one object.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectMotion {
    /// Its name.
    pub name: String,
    /// Within both limits.
    pub stable: bool,
    /// m.
    pub drift_m: f64,
    /// rad.
    pub rotation_rad: f64,
    /// m/s.
    pub peak_linear_velocity_mps: f64,
    /// rad/s.
    pub peak_angular_velocity_radps: f64,
}

/// Simulates the scene as it stands for `steps`. `rigs` are its objects' bodies.
///
/// # Errors
/// If the scene does not fit into memory, or the backend failed.
pub fn stability(scene: &Scene, rigs: &[Rig], backend: &dyn Backend, steps: u32) -> Result<Stability, BackendError> {
    let world = standing(scene, rigs);
    let settings = SimSettings { steps, ..SimSettings::default() };
    let start = world.start.clone();
    let mut last = start.clone();
    let mut peaks = vec![[0.0f32; 2]; start.len()];
    let status = backend.simulate(&world, &settings, &start, &mut |_, poses, velocities| {
        last.copy_from_slice(poses);
        for (peak, velocity) in peaks.iter_mut().zip(velocities) {
            *peak = faster(*peak, velocity);
        }
        Flow::Continue
    })?;
    let objects: Vec<ObjectMotion> = (0..rigs.len())
        .filter(|&i| !scene.is_static(i))
        .map(|i| motion(&scene.objects[i].name, &start[i], &last[i], peaks[i]))
        .collect();
    Ok(Stability {
        steps,
        movable: objects.len(),
        means: (!objects.is_empty()).then(|| Means::of(&objects)),
        valid: status.iter().all(|status| status.is_usable()),
        objects,
    })
}

impl Means {
    fn of(objects: &[ObjectMotion]) -> Self {
        let over = |value: fn(&ObjectMotion) -> f64| mean(objects.iter().map(value));
        Self {
            stable_rate_pct: percent(objects.iter().filter(|object| object.stable).count(), objects.len()),
            mean_position_drift_m: over(|object| object.drift_m),
            mean_rotation_drift_rad: over(|object| object.rotation_rad),
            mean_peak_linear_velocity_mps: over(|object| object.peak_linear_velocity_mps),
            mean_peak_angular_velocity_radps: over(|object| object.peak_angular_velocity_radps),
        }
    }
}

fn faster(peak: [f32; 2], velocity: &Velocity) -> [f32; 2] {
    [peak[0].max(velocity.linear.length()), peak[1].max(velocity.angular.length())]
}

fn motion(name: &str, start: &Pose, end: &Pose, [linear, angular]: [f32; 2]) -> ObjectMotion {
    let drift_m = f64::from(start.translation.distance(end.translation));
    let rotation_rad = start.rotation.as_dquat().normalize().angle_between(end.rotation.as_dquat().normalize());
    ObjectMotion {
        name: name.to_owned(),
        stable: drift_m <= MAX_DRIFT && rotation_rad <= MAX_TURN,
        drift_m,
        rotation_rad,
        peak_linear_velocity_mps: linear.into(),
        peak_angular_velocity_radps: angular.into(),
    }
}
