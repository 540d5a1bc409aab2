//! The CPU backend: one file per kernel, named as the shaders will be; candidates in parallel over all cores.

mod broad_phase;
mod contacts;
#[allow(missing_docs)]
pub mod narrow_phase;
mod simulate;
mod solve;

pub use simulate::Workspace;

use crate::world::{
    Backend, BackendError, Flow, Pose, Search, SearchSettings, SimSettings, Status, Stream, Velocity, World,
};
use narrow_phase::Narrow;
use rayon::prelude::*;

/// Simulates on the processor's cores.
#[derive(Clone, Copy, Debug, Default)]
pub struct CpuBackend;

impl Backend for CpuBackend {
    fn describe(&self) -> String {
        format!("CPU, {} threads", rayon::current_num_threads())
    }

    fn simulate(
        &self,
        world: &World,
        settings: &SimSettings,
        starts: &[Pose],
        on_step: &mut dyn FnMut(u32, &[Pose], &[Velocity]) -> Flow,
    ) -> Result<Vec<Status>, BackendError> {
        let bodies = world.bodies.len();
        if bodies == 0 {
            return Ok(Vec::new());
        }
        let narrow = Narrow::new(settings.narrow_phase, &world.hulls);
        let mut candidates: Vec<Workspace> = starts
            .chunks_exact(bodies)
            .map(|poses| {
                let mut workspace = Workspace::new(world);
                workspace.poses.copy_from_slice(poses);
                workspace
            })
            .collect();
        let mut poses = starts.to_vec();
        let mut velocities = vec![Velocity::default(); starts.len()];
        for step in 0..settings.steps {
            candidates
                .par_iter_mut()
                .zip(poses.par_chunks_exact_mut(bodies))
                .zip(velocities.par_chunks_exact_mut(bodies))
                .for_each(|((workspace, poses), velocities)| {
                    workspace.step(world, settings, &narrow);
                    poses.copy_from_slice(&workspace.poses);
                    velocities.copy_from_slice(&workspace.velocities);
                });
            if on_step(step, &poses, &velocities) == Flow::Stop {
                break;
            }
        }
        Ok(candidates.iter().map(|workspace| workspace.status).collect())
    }

    fn search<'a>(
        &'a self,
        _world: &'a World,
        _settings: &'a SearchSettings,
        _stream: Stream,
    ) -> Result<Box<dyn Search + 'a>, BackendError> {
        Err(BackendError::Device("joined from the search branch".into()))
    }
}
