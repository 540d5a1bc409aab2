//! One population on one backend: warm up, repeat, take the median.

use crate::world::{
    Backend, BackendError, CemSettings, KernelTime, Pose, Rollouts, SearchSettings, SimSettings, Status, World,
};
use serde::Serialize;
use std::time::Instant;

/// Candidates of the warm-up: enough for every thread and for compiling every kernel.
const WARM_UP: usize = 64;

/// How much is simulated.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Candidates in the population.
    pub candidates: u32,
    /// Names the noise on their starts.
    pub seed: u64,
    /// Runs are repeated until they took so long together, s; there is always one.
    pub seconds: f64,
}

/// Speed and quality of one backend on one scene. The keys are those of `bench --json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measurement {
    /// `cpu` or `gpu`.
    pub backend: String,
    /// Its processor.
    pub adapter: String,
    /// Candidates simulated together.
    pub candidates: u32,
    /// Bodies that move.
    pub bodies: usize,
    /// Hulls of all bodies.
    pub hulls: usize,
    /// Mean contact points of a candidate; none where the backend does not count them.
    pub contacts_per_substep: Option<f64>,
    /// Candidates simulated to their end, per second.
    pub candidates_per_s: f64,
    /// The same times the substeps of a candidate, per second.
    pub env_substeps_per_s: f64,
    /// The same times the bodies that move, per second.
    pub body_substeps_per_s: f64,
    /// ms of a run that each kernel takes; empty where that is not known.
    #[serde(serialize_with = "KernelTime::by_name")]
    pub kernels_ms: Vec<KernelTime>,
    /// About how many bytes a search with so many candidates holds.
    pub bytes_resident: u64,
    /// Mean distance between start and end of what moves, over all usable candidates, m; none if no candidate is
    /// usable.
    pub mean_drift_m: Option<f64>,
    /// Candidates with any bit of `Status`.
    pub flagged_candidates: usize,
}

/// Simulates the population of `world` again and again. `on_run` sees the seconds of every run.
///
/// # Errors
/// If nothing in the world moves, the population does not fit into memory, or the backend failed.
pub fn measure(
    backend: &dyn Backend,
    world: &World,
    settings: &SimSettings,
    effort: Effort,
    on_run: &mut dyn FnMut(f64),
) -> Result<Measurement, BackendError> {
    let Effort { candidates, seed, seconds } = effort;
    let cem = CemSettings { candidates, ..CemSettings::default() };
    let bytes_resident = backend.memory(world, &SearchSettings { cem, ..Default::default() }).bytes;
    if world.units.is_empty() {
        return Err(BackendError::Capacity("nothing in the scene moves; make an object movable".into()));
    }
    if let Some(free) = backend.free_bytes().filter(|free| bytes_resident > *free) {
        let [needed, free] = [bytes_resident, free].map(|bytes| bytes / 1_000_000);
        return Err(BackendError::Capacity(format!(
            "memory: {candidates} candidates take about {needed} MB, but {free} MB are free; take fewer candidates"
        )));
    }
    let starts = super::starts(world, candidates, seed);
    let few = starts.len().min(WARM_UP * world.bodies.len());
    backend.rollouts(world, settings, &starts[..few])?;
    let mut runs = Vec::new();
    let rollouts = loop {
        let clock = Instant::now();
        let rollouts = backend.rollouts(world, settings, &starts)?;
        runs.push(clock.elapsed().as_secs_f64());
        on_run(runs[runs.len() - 1]);
        if runs.iter().sum::<f64>() >= seconds {
            break rollouts;
        }
    };
    let described = backend.describe();
    let (kind, adapter) = described.split_once(", ").unwrap_or((&described, ""));
    let bodies = world.bodies.iter().filter(|body| !body.is_static()).count();
    let candidates_per_s = f64::from(candidates) / median(&mut runs);
    let env_substeps_per_s = candidates_per_s * f64::from(settings.steps * settings.substeps.max(1));
    Ok(Measurement {
        backend: kind.to_lowercase(),
        adapter: adapter.into(),
        candidates,
        bodies,
        hulls: world.hulls.hulls.len(),
        contacts_per_substep: rollouts.contacts_per_substep,
        candidates_per_s,
        env_substeps_per_s,
        body_substeps_per_s: env_substeps_per_s * bodies as f64,
        kernels_ms: backend.kernel_times(world, settings, &starts)?,
        bytes_resident,
        mean_drift_m: mean_drift(world, &starts, &rollouts),
        flagged_candidates: rollouts.statuses.iter().filter(|status| **status != Status::default()).count(),
    })
}

/// Mean distance between start and end of the bodies that move in the usable candidates, m.
pub fn mean_drift(world: &World, starts: &[Pose], rollouts: &Rollouts) -> Option<f64> {
    let bodies = world.bodies.len().max(1);
    let rows = starts.chunks_exact(bodies).zip(rollouts.settled.chunks_exact(bodies)).zip(&rollouts.statuses);
    let usable = rows.filter(|(_, status)| status.is_usable()).map(|(row, _)| row);
    let drifts: Vec<f64> = usable
        .flat_map(|(starts, ends)| starts.iter().zip(ends).zip(&world.bodies))
        .filter(|(_, body)| !body.is_static())
        .map(|((start, end), _)| f64::from(start.translation.distance(end.translation)))
        .collect();
    (!drifts.is_empty()).then(|| drifts.iter().sum::<f64>() / drifts.len() as f64)
}

/// The middle value, or the mean of the two in the middle; sorts. NaN without values.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => f64::NAN,
        n if n.is_multiple_of(2) => 0.5 * (values[middle - 1] + values[middle]),
        _ => values[middle],
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::cpu::CpuBackend;
    use crate::shape::box_corners;
    use crate::world::{BodyDef, STATIC};
    use glam::{Quat, Vec3};

    /// A brick 1 mm above the ground, and something that is held.
    fn world() -> World {
        let body = |x: f32, unit: u32| {
            let start = Pose::new(Quat::IDENTITY, Vec3::new(x, 0.101, 0.0));
            let parts = vec![box_corners(Vec3::splat(0.1))];
            BodyDef { parts, mass: 1.0, inertia: Vec3::splat(0.0067), unit, start, reference: start }
        };
        World::new(&[body(0.0, 0), body(5.0, STATIC)], &[0])
    }

    #[test]
    fn the_middle_counts() {
        assert_eq!(median(&mut [3.0, 1.0, 200.0]), 3.0);
        assert_eq!(median(&mut [4.0, 1.0]), 2.5);
        assert!(median(&mut []).is_nan());
    }

    #[test]
    fn drift_is_that_of_what_moves_in_usable_candidates() {
        let world = world();
        let starts = world.start.repeat(3);
        let mut settled = starts.clone();
        settled[0].translation.x += 0.3;
        settled[1].translation.x += 9.0;
        settled[2].translation.x = f32::NAN;
        settled[4].translation.y -= 0.1;
        let statuses = vec![Status::default(), Status::NOT_FINITE, Status::default()];
        let rollouts = Rollouts { settled, statuses, contacts_per_substep: None };
        assert!((mean_drift(&world, &starts, &rollouts).unwrap() - 0.2).abs() < 1e-6);
        let failed = Rollouts { statuses: vec![Status::NOT_FINITE; 3], ..rollouts };
        assert_eq!(mean_drift(&world, &starts, &failed), None);
    }

    #[test]
    fn rates_follow_from_one_another_and_kernels_fill_the_run() {
        let settings = SimSettings { steps: 5, ..Default::default() };
        let effort = Effort { candidates: 300, seed: 0, seconds: 0.0 };
        let mut runs = Vec::new();
        let measured = measure(&CpuBackend, &world(), &settings, effort, &mut |seconds| runs.push(seconds)).unwrap();
        assert_eq!((runs.len(), measured.bodies, measured.hulls, measured.flagged_candidates), (1, 1, 2, 0));
        assert!((measured.candidates_per_s * runs[0] - 300.0).abs() < 1e-6);
        assert!((measured.env_substeps_per_s / measured.candidates_per_s - 10.0).abs() < 1e-9);
        assert_eq!(measured.body_substeps_per_s, measured.env_substeps_per_s);
        assert_eq!(measured.kernels_ms.len(), 5);
        // There is no pair of hulls: only the narrow phase has nothing to do.
        let busy = measured.kernels_ms.iter().filter(|kernel| kernel.milliseconds > 0.0).count();
        assert_eq!(busy, 4, "{:?}", measured.kernels_ms);
        assert!(measured.contacts_per_substep.unwrap() > 0.0 && measured.mean_drift_m.unwrap() < 0.02);
    }

    #[test]
    fn what_cannot_be_measured_says_what_to_do() {
        let refused = |world: &World, candidates: u32| {
            let effort = Effort { candidates, seed: 0, seconds: 0.0 };
            let result = measure(&CpuBackend, world, &SimSettings::default(), effort, &mut |_| ());
            result.unwrap_err().to_string()
        };
        let mut still = world();
        still.units.clear();
        assert!(refused(&still, 1).contains("make an object movable"));
        assert!(refused(&world(), u32::MAX).contains("fewer candidates"));
    }
}
