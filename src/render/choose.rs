//! The view that shows most of a scene, found by looking from all sides at little pictures.

use super::camera::AUTO_ELEVATION;
use super::scan::project;
use super::{Camera, Size, Stage};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Degrees between the views that are tried.
const STEP: usize = 15;
/// Size of a little picture, px.
const SMALL: Size = Size { width: 128, height: 96 };
/// Triangles that are drawn in it; of more, every n-th.
const ENOUGH: usize = 30_000;
/// Points that decide how near it is taken from.
const POINTS: usize = 10_000;
/// How much a wall seen straight from behind counts against a view, in shares of the objects.
const BEHIND: f64 = 0.4;
/// How much a view from the front (+Z) counts for itself: that is where most pictures are taken from.
const FRONT: f64 = 0.04;
/// How much a view along an axis counts against it: corners show depth.
const STRAIGHT: f64 = 0.06;

/// Degrees around the vertical.
pub fn azimuth(stage: &Stage) -> f64 {
    let points: Vec<DVec3> = stage.framed.iter().copied().step_by(stage.framed.len().div_ceil(POINTS).max(1)).collect();
    let scores: Vec<(f64, f64)> = (0..360 / STEP)
        .into_par_iter()
        .map(|i| {
            let azimuth = (i * STEP) as f64;
            (azimuth, score(stage, azimuth, &points))
        })
        .collect();
    scores.into_iter().fold((0.0, f64::NEG_INFINITY), |best, now| if now.1 > best.1 + 1e-9 { now } else { best }).0
}

fn score(stage: &Stage, azimuth: f64, points: &[DVec3]) -> f64 {
    let camera = Camera::framing(azimuth, AUTO_ELEVATION, points, SMALL.aspect());
    let back = camera.toward_viewer();
    let behind: f64 = stage.walls.iter().map(|normal| (-normal.dot(back) - 0.1).max(0.0)).sum();
    // 0 along an axis, 1 from a corner; a third of the way to the corner is enough.
    let turned = (2.0 * azimuth.to_radians()).sin().abs().min(0.8) / 0.8;
    visible(stage, &camera) - BEHIND * behind - STRAIGHT * (1.0 - turned) + FRONT * back.z
}

/// Mean over the objects of the share that no other object hides.
fn visible(stage: &Stage, camera: &Camera) -> f64 {
    let near = 1e-3 * f64::from(stage.radius);
    let clip = camera.clip(stage.origin, near);
    let pixels = (SMALL.width * SMALL.height) as usize;
    let (mut depths, mut owners) = (vec![0.0_f32; pixels], vec![u32::MAX; pixels]);
    // Where an object was last counted, so that each of its pixels counts once.
    let (mut touched, mut alone) = (vec![u32::MAX; pixels], vec![0_u32; stage.objects.len()]);
    let every = stage.casters.triangles.len().div_ceil(ENOUGH).max(1);
    for (object, range) in stage.objects.array_windows().map(|&[from, to]| from..to).enumerate() {
        for triangle in stage.casters.triangles[range].iter().step_by(every) {
            let corners = triangle.map(|i| clip * stage.casters.positions[i as usize].as_dvec4());
            project(corners, near, SMALL, |screen| {
                screen.scan(screen.rows(SMALL.height), SMALL.width, &[DVec2::splat(0.5)], |x, y, _, depth| {
                    let at = (y * SMALL.width + x) as usize;
                    if touched[at] != object as u32 {
                        touched[at] = object as u32;
                        alone[object] += 1;
                    }
                    if depth > depths[at] {
                        (depths[at], owners[at]) = (depth, object as u32);
                    }
                });
            });
        }
    }
    let mut seen = vec![0_u32; alone.len()];
    for owner in owners.into_iter().filter(|owner| *owner != u32::MAX) {
        seen[owner as usize] += 1;
    }
    let shares = seen.iter().zip(&alone).filter(|(_, alone)| **alone > 0);
    let (sum, count) = shares.fold((0.0, 0.0), |(sum, n), (s, a)| (sum + f64::from(*s) / f64::from(*a), n + 1.0));
    sum / f64::max(count, 1.0)
}
