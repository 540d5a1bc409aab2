//! Convex parts for every object of a scene, with progress.

use super::{Failure, progress, say};
use glam::Vec3;
use rayon::prelude::*;
use rest3d_gpu::optimize::shape_requests;
use rest3d_gpu::scene::Scene;
use rest3d_gpu::shape::{Cache, Mesh, Shape, ShapeSettings, build_shapes, scaled_mesh};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Where there is no terminal for a bar, a line is written at most so often.
const TOLD_EVERY: Duration = Duration::from_secs(10);

/// Makes or finds the shapes, in the scene's order; with the alternatives that an optimization needs, if they are
/// wanted.
pub fn make(scene: &Scene, alternatives: bool) -> Result<Vec<Shape>, Failure> {
    let settings = ShapeSettings { alternatives, ..Default::default() };
    let requests = shape_requests(scene);
    let clock = Instant::now();
    let cache = Cache::default_location();
    if let Some(Err(warning)) = cache.as_ref().map(Cache::check) {
        say(format_args!("warning: {warning}"));
    }
    let bar = progress::bar(requests.len() as u64, progress::SHORT);
    let told = Mutex::new(clock);
    let shapes = build_shapes(&requests, &settings, cache.as_ref(), &|done, total, name| {
        bar.set_position(done as u64);
        bar.set_message(format!("shapes {done}/{total}: {name}"));
        if let Ok(mut told) = told.lock()
            && bar.is_hidden()
            && told.elapsed() >= TOLD_EVERY
        {
            say(format_args!("cutting meshes into convex parts, once for all runs: {done} of {total} done"));
            *told = Instant::now();
        }
    });
    bar.finish_and_clear();
    let shapes = shapes.map_err(|error| Failure::Input(format!("{}: {error}", scene.file.display())))?;
    for (i, shape) in shapes.iter().enumerate() {
        let [low, high] = shape.bounds;
        scene.check_size(i, (high - low).max_element().into())?;
    }
    let parts: usize = shapes.iter().map(|shape| shape.parts.len()).sum();
    let seconds = clock.elapsed().as_secs_f64();
    say(format_args!("shapes: {} objects, {parts} convex parts, {seconds:.1} s", shapes.len()));
    Ok(shapes)
}

/// Reads the meshes, in the scene's order, scaled to metres.
pub fn meshes(scene: &Scene) -> Result<Vec<Mesh>, Failure> {
    let meshes: Result<Vec<Mesh>, _> = shape_requests(scene).par_iter().map(scaled_mesh).collect();
    let meshes = meshes.map_err(|error| Failure::Input(format!("{}: {error}", scene.file.display())))?;
    for (i, mesh) in meshes.iter().enumerate() {
        let corners = || mesh.triangles.iter().flatten().map(|&i| mesh.vertices[i as usize]);
        let (low, high) = (corners().fold(Vec3::INFINITY, Vec3::min), corners().fold(Vec3::NEG_INFINITY, Vec3::max));
        scene.check_size(i, (high - low).max_element().into())?;
    }
    Ok(meshes)
}
