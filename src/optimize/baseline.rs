//! The paper's baseline without a search: a projection onto what does not overlap, then simulation.

use super::OptimizeError;
use super::config::{Config, SettleSettings};
use super::groups;
use super::projection::{Projection, Scope, project};
use super::rig::Rig;
use super::settle::{settle, to_rest};
use crate::scene::{Pose, Scene};
use crate::shape::Shape;
use crate::world::Backend;

/// What the baseline came to.
#[derive(Clone, Debug)]
pub struct Baseline {
    /// What was done before the simulation.
    pub projection: Projection,
    /// Pose of every object where the simulation ended; none if it failed.
    pub layout: Option<Vec<Pose>>,
}

/// Projects a scene and simulates what comes of it: to rest as the configuration says, or if it asks for no last
/// descent, as long and as undamped as a candidate. `shapes` are in the scene's order.
///
/// # Errors
/// A configuration that makes no sense, or a backend that cannot go on.
pub fn project_and_settle(
    scene: &Scene,
    shapes: &[Shape],
    backend: &dyn Backend,
    config: &Config,
    scope: Scope,
) -> Result<Baseline, OptimizeError> {
    config.validate()?;
    let rigs: Vec<Rig> = shapes.iter().map(Rig::new).collect();
    let mut layout: Vec<Pose> = scene.objects.iter().map(|object| object.pose).collect();
    let projection = project(scene, shapes, &mut layout, scope);
    let plan = groups::plan(scene, true, &[]);
    let Some(all) = plan.last() else { return Ok(Baseline { projection, layout: Some(layout) }) };
    let simulation = config.fine();
    let settings = match config.settle.max_seconds > 0.0 {
        true => config.settle.clone(),
        false => SettleSettings {
            max_seconds: simulation.steps as f32 * simulation.dt,
            max_push_out: simulation.max_push_out,
            damping: simulation.linear_damping,
            ..config.settle.clone()
        },
    };
    let world = all.world(&rigs, &[], &layout, &layout);
    let settled = settle(backend, &world, &simulation, &settings, &world.start, &to_rest)?;
    let layout = settled.usable[0].then(|| {
        all.adopt(&rigs, &world.start, &settled.poses, &mut layout);
        layout
    });
    Ok(Baseline { projection, layout })
}
