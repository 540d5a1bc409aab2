//! How well the parts stand for the mesh, in millimetres, in both directions.

use super::hull::Hull;
use super::reduce::Levels;
use super::solid::Solid;
use super::tolerances::measure::{COVER_SAMPLES, FACE_SAMPLES, MAX_RATIO};
use glam::Vec3;
use parry3d::query::PointQuery;
use parry3d::shape::TriMesh;
use serde::{Deserialize, Serialize};

/// Distances between parts and mesh. Outward: parts beyond the mesh; uncovered: mesh beyond the union of the parts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Number of convex parts.
    pub parts: usize,
    /// Vertices of all parts.
    pub vertices: usize,
    /// Volume of the union of the parts over what of it is not free space.
    pub volume_ratio: f32,
    /// 95th percentile of how far part vertices lie outside the mesh, mm.
    pub outward_p95_mm: f32,
    /// Farthest that a part vertex lies outside the mesh, mm.
    pub outward_max_mm: f32,
    /// 95th percentile, over the area of the parts' faces, of how far they reach into free space, mm.
    pub bulge_p95_mm: f32,
    /// Farthest that a face of a part reaches into free space, mm.
    pub bulge_max_mm: f32,
    /// Mean over the area of the parts' faces of how far they reach into free space, mm.
    pub bulge_mean_mm: f32,
    /// How far the lowest mesh vertices lie outside the parts, mm.
    pub uncovered_feet_mm: f32,
    /// How far the highest mesh vertices lie outside the parts, mm.
    pub uncovered_top_mm: f32,
    /// 95th percentile of how far mesh vertices lie outside the parts, mm.
    pub uncovered_p95_mm: f32,
    /// Farthest that a mesh vertex lies outside the parts, mm.
    pub uncovered_max_mm: f32,
}

/// Measures the parts against the triangles they stand for.
pub(super) fn measure(parts: &[Hull], triangles: &[[Vec3; 3]], solid: &Solid, levels: &Levels) -> Quality {
    let corners = triangles.as_flattened();
    let mut quality =
        Quality { parts: parts.len(), vertices: parts.iter().map(|p| p.vertices.len()).sum(), ..Quality::default() };
    let (open, all) = solid.union(parts);
    quality.volume_ratio = if all > 0.0 { (all / (all - open).max(all / MAX_RATIO)).min(MAX_RATIO) } else { 1.0 };

    let faces = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    if let Ok(surface) = TriMesh::new(corners.to_vec(), faces) {
        let mut outward: Vec<f32> =
            parts.iter().flat_map(|p| &p.vertices).map(|&v| 1e3 * beyond(v, &surface, triangles, solid)).collect();
        (quality.outward_p95_mm, quality.outward_max_mm) = tail(&mut outward);
        let mut bulge: Vec<f32> =
            face_samples(parts).into_iter().map(|p| 1e3 * beyond(p, &surface, triangles, solid)).collect();
        quality.bulge_mean_mm = bulge.iter().sum::<f32>() / bulge.len().max(1) as f32;
        (quality.bulge_p95_mm, quality.bulge_max_mm) = tail(&mut bulge);
    }

    let cover = Cover::new(parts);
    let mut seen: Vec<Vec3> = corners.to_vec();
    seen.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    seen.dedup();
    let stride = seen.len().div_ceil(COVER_SAMPLES).max(1);
    let mut uncovered: Vec<f32> = seen.iter().step_by(stride).map(|&p| 1e3 * cover.outside(p)).collect();
    let worst = |which: &dyn Fn(Vec3) -> bool| {
        seen.iter().filter(|p| which(**p)).map(|&p| 1e3 * cover.outside(p)).fold(0.0, f32::max)
    };
    quality.uncovered_feet_mm = worst(&|p| levels.is_foot(p));
    quality.uncovered_top_mm = worst(&|p| levels.is_top(p));
    (quality.uncovered_p95_mm, quality.uncovered_max_mm) = tail(&mut uncovered);
    quality
}

/// The union of the parts, for asking how far a point lies outside it.
struct Cover<'a> {
    parts: &'a [Hull],
    surfaces: Vec<Option<TriMesh>>,
}

impl<'a> Cover<'a> {
    fn new(parts: &'a [Hull]) -> Self {
        let surfaces = parts.iter().map(|p| TriMesh::new(p.vertices.clone(), p.triangles.clone()).ok()).collect();
        Self { parts, surfaces }
    }

    /// Distance from the union, m; zero within.
    fn outside(&self, point: Vec3) -> f32 {
        let mut nearest = f32::INFINITY;
        for (part, surface) in self.parts.iter().zip(&self.surfaces) {
            let excess = part.excess(point);
            if excess <= 1e-5 {
                return 0.0;
            }
            if excess < nearest {
                let distance = surface.as_ref().map_or(excess, |s| s.distance_to_local_point(point, false));
                nearest = nearest.min(distance);
            }
        }
        if nearest.is_finite() { nearest } else { 0.0 }
    }
}

/// Points spread by area over those faces of the parts that are not within another part.
fn face_samples(parts: &[Hull]) -> Vec<Vec3> {
    let faces: Vec<(usize, [Vec3; 3])> = parts
        .iter()
        .enumerate()
        .flat_map(|(i, p)| p.triangles.iter().map(move |t| (i, t.map(|c| p.vertices[c as usize]))))
        .collect();
    let area = |t: &[Vec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).length();
    let step = faces.iter().map(|f| area(&f.1)).sum::<f32>() / FACE_SAMPLES as f32;
    let (mut passed, mut next, mut samples) = (0.0, 0_u32, Vec::new());
    for (part, t) in &faces {
        passed += area(t);
        while (next as f32 + 0.5) * step < passed && samples.len() < 2 * FACE_SAMPLES {
            // Roberts' R2 sequence, folded into the triangle.
            let (u, v) = ((0.754_877_7 * next as f32).fract(), (0.569_840_3 * next as f32).fract());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let p = t[0] + (t[1] - t[0]) * u + (t[2] - t[0]) * v;
            if parts.iter().enumerate().all(|(i, other)| i == *part || other.excess(p) > -1e-4) {
                samples.push(p);
            }
            next += 1;
        }
    }
    samples
}

/// How far a point on a part lies from the mesh, m; zero inside the mesh and in hollows that nothing can get into.
fn beyond(point: Vec3, surface: &TriMesh, triangles: &[[Vec3; 3]], solid: &Solid) -> f32 {
    if !solid.is_free(solid.index(point)) {
        return 0.0;
    }
    let nearest = surface.project_local_point(point, false);
    let offset = point - nearest.point;
    let [a, b, c] = triangles[nearest.subshape as usize];
    if offset.dot((b - a).cross(c - a)) > 0.0 { offset.length() } else { 0.0 }
}

/// 95th percentile and maximum.
fn tail(values: &mut [f32]) -> (f32, f32) {
    values.sort_by(f32::total_cmp);
    let last = values.len().saturating_sub(1);
    match values.last() {
        // Adding zero turns −0 into 0.
        Some(&max) => (values[(last as f32 * 0.95).round() as usize] + 0.0, max + 0.0),
        None => (0.0, 0.0),
    }
}
