//! Scenes on disk, and runs of the optimizer.

use rest3d_gpu::optimize::{Event, Observer, Rig, shape_requests, standing};
use rest3d_gpu::scene::Scene;
use rest3d_gpu::shape::{Cache, ShapeSettings, build_shapes};
use rest3d_gpu::world::{Flow, World};
use std::path::Path;

/// A scene as its file has it, with our own convex parts: a body for each object. `file` is seen from the project's
/// folder.
pub fn as_it_stands(file: &str) -> (Scene, World) {
    let scene = Scene::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap();
    let cache = Cache::default_location();
    let requests = shape_requests(&scene);
    let shapes = build_shapes(&requests, &ShapeSettings::default(), cache.as_ref(), &|_, _, _| ()).unwrap();
    let rigs: Vec<Rig> = shapes.iter().map(Rig::new).collect();
    let world = standing(&scene, &rigs);
    (scene, world)
}

/// Keeps all checkpoints.
#[derive(Default)]
pub struct Keep(pub Vec<String>);

impl Observer for Keep {
    fn event(&mut self, event: Event<'_>) -> Flow {
        if let Some(checkpoint) = event.checkpoint() {
            self.0.push(checkpoint.to_json());
        }
        Flow::Continue
    }
}
