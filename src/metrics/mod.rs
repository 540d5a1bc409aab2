//! What a scene is worth: the paper's metrics (REST3D, evaluation section) and stricter ones beside them.
//!
//! `stability` simulates, `collision` tests the triangle meshes, `geometry` compares with a reference scene after
//! alignment (`alignment`, `surface`), `detection` compares instance masks.

mod alignment;
mod collision;
mod detection;
mod geometry;
mod stability;
mod surface;

pub use collision::{Collision, CollisionRate, Overlap, collision};
pub use detection::{Detection, DetectionError, detection};
pub use geometry::{Geometry, Layout, geometry, layout};
pub use stability::{Means, ObjectMotion, Stability, stability};

pub use crate::optimize::FALLEN;

use crate::scene::Scene;
use crate::shape::Mesh;
use glam::DVec3;

/// Steps of 1/60 s after which an object is looked at (L of the paper).
pub const STEPS: u32 = 60;
/// An object that moved farther is unstable, m.
pub const MAX_DRIFT: f64 = 0.1;
/// An object that turned farther is unstable, rad.
pub const MAX_TURN: f64 = 0.1;
/// Overlap of meshes that is told apart from touching, m.
pub const TOUCHING: f64 = 1e-3;
/// Distance within which a point counts as matched in the F-score, m.
pub const MATCHED: f64 = 0.05;
/// What the box around a flat object is taken to be thick, m.
const THICKNESS: f64 = 1e-6;
/// Intersection over union from which a mask is found.
pub const FOUND: f64 = 0.5;

/// Corners of every triangle of an object where it stands, m.
fn placed(scene: &Scene, object: usize, mesh: &Mesh) -> Vec<[DVec3; 3]> {
    let pose = &scene.objects[object].pose;
    let vertices: Vec<DVec3> = mesh.vertices.iter().map(|v| pose.point(v.as_dvec3())).collect();
    mesh.triangles.iter().map(|t| t.map(|i| vertices[i as usize])).collect()
}

/// Corners of the box around points, m; empty if there are none.
fn bounds(points: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    points.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

/// Share in %; 0 of nothing.
pub fn percent(count: usize, of: usize) -> f64 {
    100.0 * count as f64 / of.max(1) as f64
}

/// Arithmetic mean; 0 of nothing.
pub fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), value| (sum + value, count + 1));
    sum / count.max(1) as f64
}
