//! From a mesh to at most a given number of convex parts.
//!
//! Three ways lead to pieces: cutting the whole surface, cutting each connected component for itself (furniture is
//! modelled as boards and legs), and cutting it like a cake first (no single cut opens a bowl, so the greedy search
//! would slice it into discs). All are merged down to the budget and the one that bulges least is kept.

use super::ShapeSettings;
use super::bearing::follow_tops;
use super::cover::fit;
use super::hull::Hull;
use super::merge::{Limits, merge};
use super::recut::recut;
use super::reduce::Levels;
use super::solid::Solid;
use super::split::{Piece, clip, components, split};
use glam::Vec3;

/// A mesh whose hull has at most this share of free space is its own hull.
const CONVEX: f32 = 0.005;
/// Bulge of a compartment that is worth a part beyond the budget, in units of the bounding box's volume^(4/3): the bay
/// of a shelf has twice that, the air between the legs of a table a quarter.
const COMPARTMENT: f32 = 0.004;

/// Meshes of more connected components than this are not cut like a cake: they are no bowls.
const CAKE_COMPONENTS: usize = 4;

/// Convex parts of the triangles (scaled, m) whose hulls cover the surface: at most `budget`, or more where so few do not
/// follow it, above all where things rest on it if it `bears` any.
pub(super) fn decompose(
    triangles: &[[Vec3; 3]],
    solid: &Solid,
    levels: &Levels,
    budget: usize,
    bears: bool,
    settings: &ShapeSettings,
    notes: &mut Vec<String>,
) -> Vec<Hull> {
    let mut fit = |pieces: Vec<Piece>| -> Vec<Hull> {
        let open = pieces.len();
        let pieces = if bears { follow_tops(pieces, solid, levels.up, settings.following_parts) } else { pieces };
        let hulls = fit(pieces, solid, levels, budget.max(settings.following_parts), settings);
        if hulls.len() > budget {
            let why = if open > budget { "keep compartments open" } else { "follow its surface" };
            notes.push(format!("{} parts, more than the {budget} of its category, to {why}", hulls.len()));
        }
        hulls
    };
    let Some(whole) = Piece::new(triangles.to_vec(), solid) else {
        return Vec::new();
    };
    if solid.protrusion(&whole.hull).1 <= CONVEX * whole.hull.volume() {
        return fit(vec![whole]);
    }
    // A layer of this depth over the whole hull, shared by the parts.
    let layer = 0.5 * settings.accuracy * settings.accuracy * whole.hull.area();
    let enough = layer / budget as f32;
    let most = ((settings.oversplit * budget as f32) as usize).min(settings.max_pieces).max(budget);
    let (low, high) = whole.hull.bounds();
    let compartment = COMPARTMENT * (high - low).element_product().powf(4.0 / 3.0);
    let limits =
        Limits { budget, extra: settings.extra_parts, free: enough, compartment, shared: layer / whole.hull.volume() };
    let mut best: Option<(f32, bool, Vec<Piece>)> = None;
    let mut consider = |pieces: Vec<Piece>| {
        let pieces = split(pieces, solid, levels.up, most, enough);
        let merged = merge(&pieces, solid, &limits);
        // A part has to be worth what a merge may cost for free.
        let score = merged.bulge + enough * merged.groups.len() as f32;
        if best.as_ref().is_none_or(|b| score < b.0) {
            let groups = merged.groups.iter();
            let joined = groups.filter_map(|members| Piece::joined(members.iter().map(|&m| &pieces[m])));
            best = Some((score, merged.closed, joined.collect()));
        }
    };
    let shells = components(triangles);
    let round = shells.len() <= CAKE_COMPONENTS;
    if shells.len() > 1 && shells.len() <= settings.max_components {
        consider(shells.into_iter().filter_map(|s| Piece::new(s, solid)).collect());
    }
    if round {
        consider(sectors(&whole, solid, levels.up, budget));
    }
    consider(vec![whole]);
    let Some((_, closed, pieces)) = best else {
        return Vec::new();
    };
    let pieces = recut(without_hidden(pieces), solid, limits.shared);
    let hulls = fit(pieces);
    if closed {
        notes.push(format!("a compartment is closed: {} parts are too few for it", hulls.len()));
    }
    hulls
}

/// The piece cut by vertical planes through its middle, as many as leave a part of the budget for the bottom.
fn sectors(whole: &Piece, solid: &Solid, up: Vec3, budget: usize) -> Vec<Piece> {
    let (low, high) = whole.hull.bounds();
    let center = 0.5 * (low + high);
    let (u, v) = up.any_orthonormal_pair();
    let planes = (budget / 2).saturating_sub(1).clamp(2, 7);
    let mut sectors = vec![whole.triangles.clone()];
    for i in 0..planes {
        let (sin, cos) = (std::f32::consts::PI * (i as f32 + 0.5) / planes as f32).sin_cos();
        let normal = u * cos + v * sin;
        sectors = sectors.iter().flat_map(|triangles| clip(triangles, normal, normal.dot(center))).collect();
    }
    sectors.into_iter().filter_map(|triangles| Piece::new(triangles, solid)).collect()
}

/// Leaves out parts that lie wholly within another part.
fn without_hidden(mut pieces: Vec<Piece>) -> Vec<Piece> {
    pieces.sort_by(|a, b| b.hull.volume().total_cmp(&a.hull.volume()));
    let mut kept: Vec<Piece> = Vec::new();
    for piece in pieces {
        if !kept.iter().any(|k| piece.hull.vertices.iter().all(|v| k.hull.excess(*v) <= 1e-5)) {
            kept.push(piece);
        }
    }
    kept
}
