//! The scene that the benchmarks share.

use rest3d_gpu::bench::Subject;
use rest3d_gpu::optimize::shape_requests;
use rest3d_gpu::scene::Scene;
use rest3d_gpu::shape::{Cache, ShapeSettings, build_shapes};
use std::path::Path;

/// The throughput scene beside the project or, where that is absent, the shipped one.
pub fn subject(project: &str) -> Subject {
    let project = Path::new(project);
    let mut folder = project.join("../shared/scenes/bench12");
    if !folder.is_dir() {
        eprintln!("shared/scenes/bench12 is not there: scenes/study instead, numbers are not those of the docs");
        folder = project.join("scenes/study");
    }
    let scene = Scene::read(&folder).expect("a scene");
    let cache = Cache::default_location();
    let shapes = build_shapes(&shape_requests(&scene), &ShapeSettings::default(), cache.as_ref(), &|_, _, _| ());
    let subject = Subject::new(&scene, &shapes.expect("shapes"));
    let hulls: usize = subject.bodies.iter().map(|body| body.parts.len()).sum();
    eprintln!("{}: {} bodies, {hulls} hulls", scene.name, subject.movable());
    subject
}
