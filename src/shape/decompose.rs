//! From a mesh to at most a given number of convex parts.
//!
//! Two ways lead to pieces: cutting the whole surface, or cutting each connected component for itself (furniture is
//! modelled as boards and legs). Both are merged down to the budget and the one that bulges less is kept.

use super::ShapeSettings;
use super::hull::Hull;
use super::merge::merge;
use super::reduce::{Levels, reduce};
use super::solid::Solid;
use super::split::{Piece, components, split};
use glam::Vec3;

/// A mesh whose hull has at most this share of free space is its own hull.
const CONVEX: f32 = 0.005;

/// Convex parts of the triangles (scaled, m), at most `budget`; their hulls cover the surface up to the reduction.
pub(super) fn decompose(
    triangles: &[[Vec3; 3]],
    solid: &Solid,
    levels: &Levels,
    budget: usize,
    settings: &ShapeSettings,
) -> Vec<Hull> {
    let Some(whole) = Piece::new(triangles.to_vec(), solid) else {
        return Vec::new();
    };
    let finish = |hull: &Hull| reduce(hull, levels, settings.soft_vertices, settings.max_vertices);
    if solid.protrusion(&whole.hull).1 <= CONVEX * whole.hull.volume() {
        return vec![finish(&whole.hull)];
    }
    // A layer of this depth over the whole hull, shared by the parts.
    let layer = 0.5 * settings.accuracy * settings.accuracy * whole.hull.area();
    let enough = layer / budget as f32;
    let most = ((settings.oversplit * budget as f32) as usize).min(settings.max_pieces).max(budget);
    let mut best: Option<(f32, Vec<Hull>)> = None;
    let mut consider = |pieces: Vec<Piece>| {
        let pieces = split(pieces, solid, levels.up, most, enough);
        let (groups, bulge) = merge(&pieces, solid, budget, enough);
        if best.as_ref().is_none_or(|b| bulge < b.0) {
            let hulls = groups
                .iter()
                .filter_map(|members| {
                    let points: Vec<Vec3> =
                        members.iter().flat_map(|&m| pieces[m].hull.vertices.iter().copied()).collect();
                    Hull::new(&points)
                })
                .collect();
            best = Some((bulge, hulls));
        }
    };
    let shells = components(triangles);
    if shells.len() > 1 && shells.len() <= settings.max_components {
        consider(shells.into_iter().filter_map(|s| Piece::new(s, solid)).collect());
    }
    consider(vec![whole]);
    best.map(|b| without_hidden(b.1).iter().map(finish).collect()).unwrap_or_default()
}

/// Leaves out parts that lie wholly within another part.
fn without_hidden(mut hulls: Vec<Hull>) -> Vec<Hull> {
    hulls.sort_by(|a, b| b.volume().total_cmp(&a.volume()));
    let mut kept: Vec<Hull> = Vec::new();
    for hull in hulls {
        if !kept.iter().any(|k| hull.vertices.iter().all(|v| k.excess(*v) <= 1e-5)) {
            kept.push(hull);
        }
    }
    kept
}
