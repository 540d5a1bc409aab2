//! From a mesh to at most a given number of convex parts.
//!
//! Four ways lead to pieces: cutting the whole surface, cutting each connected component for itself (furniture is
//! modelled as boards and legs), cutting it like a cake first (no single cut opens a bowl, so the greedy search
//! would slice it into discs), and cutting it along its largest faces first (none opens a shelf whose boards are one
//! mesh). All are merged down to the budget and the one that bulges least is kept.

use super::ShapeSettings;
use super::bearing::follow_tops;
use super::cluster::Cluster;
use super::cover::fit;
use super::hull::Hull;
use super::merge::{Limits, Merged, merge};
use super::planes::{best_cut, largest_face};
use super::recut::recut;
use super::reduce::Levels;
use super::slim::slim;
use super::solid::Solid;
use super::split::{Piece, components, split};
use super::tolerances::decompose::{CAKE_COMPONENTS, COMPARTMENT, CONVEX, SHARED};
use glam::Vec3;
use rayon::prelude::*;

/// Convex parts of the triangles (scaled, m) whose hulls cover the surface: at most `budget`, or more where so few do
/// not follow it, above all where things rest on it if it `bears` any.
pub(super) fn decompose(
    triangles: &[[Vec3; 3]],
    solid: &Solid,
    levels: &Levels,
    budget: usize,
    bears: bool,
    settings: &ShapeSettings,
    notes: &mut Vec<String>,
) -> Vec<Hull> {
    let mut fit = |clusters: Vec<Cluster>| -> Vec<Hull> {
        let open = clusters.len();
        let most = settings.following_parts;
        let clusters = if bears { follow_tops(clusters, solid, levels.up, most) } else { clusters };
        let hulls = fit(clusters, solid, levels, budget.max(most), settings);
        if hulls.len() > budget {
            let why = if open > budget { "leave free space open" } else { "follow its surface" };
            notes.push(format!("{} parts, more than the {budget} of its category, to {why}", hulls.len()));
        }
        hulls
    };
    let Some(whole) = Piece::new(triangles.to_vec(), solid) else {
        return Vec::new();
    };
    if solid.protrusion(&whole.hull).1 <= CONVEX * whole.hull.volume() {
        return fit(Cluster::new(vec![whole]).into_iter().collect());
    }
    // A layer of this depth over the whole hull, shared by the parts.
    let layer = 0.5 * settings.accuracy * settings.accuracy * whole.hull.area();
    let enough = layer / budget as f32;
    let most = ((settings.oversplit * budget as f32) as usize).min(settings.max_pieces).max(budget);
    let (low, high) = whole.hull.bounds();
    let compartment = COMPARTMENT * (high - low).element_product().powf(4.0 / 3.0);
    let shared = SHARED * layer / whole.hull.volume();
    let limits = Limits { budget, extra: settings.extra_parts, free: enough, compartment, shared };
    let shells = components(triangles);
    let round = shells.len() <= CAKE_COMPONENTS;
    let along_faces = |piece: &Piece| largest_face(&piece.triangles, &piece.hull, solid, levels.up);
    let mut ways: Vec<Vec<Piece>> = Vec::new();
    if shells.len() > 1 && shells.len() <= settings.max_components {
        ways.push(shells.into_iter().filter_map(|s| Piece::new(s, solid)).collect());
    }
    if round {
        ways.push(sectors(&whole, solid, levels.up, budget));
    }
    ways.push(split(vec![whole.clone()], solid, most, enough, along_faces));
    ways.push(vec![whole]);
    let tried = ways.into_par_iter().map(|pieces| {
        let pieces = split(pieces, solid, most, enough, |piece| {
            best_cut(&piece.triangles, &piece.hull, solid, levels.up, |hull| solid.protrusion(hull).0)
        });
        let merged = merge(&pieces, solid, &limits);
        // A part has to be worth what a merge may cost for free.
        let score = merged.bulge + enough * merged.groups.len() as f32;
        (score, merged, pieces)
    });
    let tried: Vec<(f32, Merged, Vec<Piece>)> = tried.collect();
    let best = tried.into_iter().reduce(|best, other| if other.0 < best.0 { other } else { best });
    let Some((_, Merged { groups, closed, .. }, pieces)) = best else {
        return Vec::new();
    };
    let joined = |members: &Vec<usize>| Cluster::new(members.iter().map(|&m| pieces[m].clone()).collect());
    let clusters = groups.iter().filter_map(joined).collect();
    let clusters = recut(without_hidden(clusters), solid, limits.shared);
    let clusters = match settings.covering {
        true => slim(clusters, solid, levels.up, settings.following_parts),
        false => clusters,
    };
    let closed = closed && clusters.iter().any(|cluster| solid.protrusion(&cluster.hull).0 > compartment);
    let hulls = fit(clusters);
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
    let mut sectors = vec![whole.clone()];
    for i in 0..planes {
        let (sin, cos) = (std::f32::consts::PI * (i as f32 + 0.5) / planes as f32).sin_cos();
        let normal = u * cos + v * sin;
        sectors = sectors.iter().flat_map(|piece| piece.sides(normal, normal.dot(center), solid)).flatten().collect();
    }
    sectors
}

/// Leaves out parts that lie wholly within another part.
fn without_hidden(mut clusters: Vec<Cluster>) -> Vec<Cluster> {
    clusters.sort_by(|a, b| b.hull.volume().total_cmp(&a.hull.volume()));
    let mut kept: Vec<Cluster> = Vec::new();
    for cluster in clusters {
        if !kept.iter().any(|k| cluster.hull.vertices.iter().all(|v| k.hull.excess(*v) <= 1e-5)) {
            kept.push(cluster);
        }
    }
    kept
}
