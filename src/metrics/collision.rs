//! Which objects' meshes are in one another, and how deep.

use super::surface::{Surface, spread};
use super::{TOUCHING, bounds, percent, placed};
use crate::scene::Scene;
use crate::shape::{Inside, Mesh};
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

/// Points on each surface, besides corners and middles of triangles, at which depth is measured.
const SAMPLES: usize = 4000;

/// Collisions of the triangle meshes where the objects stand.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Collision {
    /// Surfaces that meet, or one mesh inside another: touching counts (paper: collision rate).
    pub strict: CollisionRate,
    /// Those in which one mesh is deeper than [`TOUCHING`] inside the other.
    pub deeper_than_1mm: CollisionRate,
    /// Deepest of all, m.
    pub max_depth_m: f64,
    /// Deepest point below the ground of any object, m.
    pub max_ground_depth_m: f64,
    /// Every pair that collides, in the scene's order.
    pub pairs: Vec<Overlap>,
}

/// How many collide.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CollisionRate {
    /// Share of the scene's objects, %.
    pub collision_rate_pct: f64,
    /// Objects.
    pub objects: usize,
    /// Pairs of objects.
    pub pairs: usize,
}

/// Two objects that collide.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Overlap {
    /// Names.
    pub a: String,
    /// The later one in the scene.
    pub b: String,
    /// Deepest point of one surface inside the other mesh, m; 0 where surfaces only touch.
    pub depth_m: f64,
    /// One is wholly inside the other: their surfaces do not meet.
    pub contained: bool,
}

/// An object's mesh where it stands.
struct Solid {
    bounds: [DVec3; 2],
    surface: Surface,
    inside: Inside,
    /// Where its depth in others is measured, m.
    points: Vec<DVec3>,
}

/// Tests all pairs of a scene's objects, static ones included; `meshes` are theirs, in metres.
pub fn collision(scene: &Scene, meshes: &[Mesh]) -> Collision {
    let solids: Vec<Option<Solid>> =
        (0..meshes.len()).into_par_iter().map(|i| Solid::new(placed(scene, i, &meshes[i]))).collect();
    let near = |a: &Solid, b: &Solid| a.bounds[0].cmple(b.bounds[1]).all() && b.bounds[0].cmple(a.bounds[1]).all();
    let pairs: Vec<(usize, usize)> = (0..solids.len())
        .flat_map(|i| (i + 1..solids.len()).map(move |j| (i, j)))
        .filter(|&(i, j)| matches!((&solids[i], &solids[j]), (Some(a), Some(b)) if near(a, b)))
        .collect();
    let overlap = |&(i, j): &(usize, usize)| {
        let (a, b) = (solids[i].as_ref()?, solids[j].as_ref()?);
        let meet = a.surface.meets(&b.surface);
        let depth_m = a.depth_in(b).max(b.depth_in(a));
        (meet || depth_m > TOUCHING).then_some((i, j, depth_m, !meet))
    };
    let found: Vec<(usize, usize, f64, bool)> = pairs.par_iter().filter_map(overlap).collect();
    let rate = |beyond: f64| {
        let of: Vec<_> = found.iter().filter(|(_, _, depth, _)| *depth >= beyond).collect();
        let objects = (0..meshes.len()).filter(|k| of.iter().any(|(i, j, ..)| i == k || j == k)).count();
        CollisionRate { collision_rate_pct: percent(objects, meshes.len()), objects, pairs: of.len() }
    };
    let name = |i: usize| scene.objects[i].name.clone();
    let below = solids.iter().flatten().map(|solid| -solid.bounds[0].y);
    Collision {
        strict: rate(0.0),
        deeper_than_1mm: rate(TOUCHING),
        max_depth_m: found.iter().map(|(.., depth, _)| *depth).fold(0.0, f64::max),
        max_ground_depth_m: below.fold(0.0, f64::max),
        pairs: (found.iter())
            .map(|&(i, j, depth_m, contained)| Overlap { a: name(i), b: name(j), depth_m, contained })
            .collect(),
    }
}

impl Solid {
    /// None if all triangles are degenerate.
    fn new(triangles: Vec<[DVec3; 3]>) -> Option<Self> {
        let surface = Surface::new(&triangles)?;
        let middles = triangles.iter().map(|[a, b, c]| (*a + *b + *c) / 3.0);
        let points = triangles.iter().flatten().copied().chain(middles).chain(spread(&triangles, SAMPLES)).collect();
        Some(Self {
            bounds: bounds(triangles.iter().flatten().copied()),
            surface,
            points,
            inside: Inside::new(triangles),
        })
    }

    /// Deepest of its points inside `other`, m.
    fn depth_in(&self, other: &Self) -> f64 {
        let [low, high] = other.bounds;
        let within = |p: &&DVec3| p.cmpge(low).all() && p.cmple(high).all() && other.inside.contains(**p);
        let deep: Vec<DVec3> = self.points.iter().filter(within).copied().collect();
        other.surface.distances(&deep).into_iter().fold(0.0, f64::max)
    }
}
