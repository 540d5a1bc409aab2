//! Grows a reduced hull until it covers what it stands for, and divides what a few dozen vertices cannot follow.
//!
//! A part of 64 vertices within a pear lies up to 5 mm below its skin: pears that rest on such parts sink into each
//! other by as much. So the faces of the reduced hull are pushed out to the full hull's support, and the vertices
//! follow them by the shortest way. Horizontal faces that are tight already stay where they are: they are feet, tops
//! and boards.

use super::ShapeSettings;
use super::cluster::Cluster;
use super::hull::Hull;
use super::reduce::{Levels, reduce};
use super::solid::Solid;
use super::tolerances::cover::{
    BLIND_CUTS, FAR_OUT, GROWTH, HORIZONTAL, LEAST_GROWTH, MOST_GROWTH, ROUNDS, SHORT, SPIKE, SWEEPS, WORTH,
};
use glam::{Vec3, Vec4};

/// A piece and what its hull has become with the vertices that a part may have.
struct Fitted {
    cluster: Cluster,
    part: Hull,
    /// How far the part stands out beyond the piece's hull, m, and how far it may.
    growth: f32,
    tolerated: f32,
    /// Cuts in a row that did not help.
    blind: u32,
    /// No cut helps.
    done: bool,
}

impl Fitted {
    fn new(cluster: Cluster, levels: &Levels, settings: &ShapeSettings) -> Self {
        let (part, growth) = covering(&cluster.hull, levels, settings);
        let (low, high) = cluster.hull.bounds();
        let stands = cluster.hull.vertices.iter().any(|&vertex| levels.is_foot(vertex));
        let most = if stands { LEAST_GROWTH } else { MOST_GROWTH };
        let tolerated = (GROWTH * low.distance(high)).clamp(LEAST_GROWTH, most);
        Self { cluster, part, growth, tolerated, blind: 0, done: false }
    }

    /// Its two sides, cut across the middle of that side of its box which leaves them standing out least, if that
    /// helps.
    fn halves(&self, solid: &Solid, levels: &Levels, settings: &ShapeSettings) -> Option<[Self; 2]> {
        let growth = |halves: &[Self; 2]| halves[0].growth.max(halves[1].growth);
        let cuts = Vec3::AXES.into_iter().filter_map(|axis| match self.cluster.halves(axis, solid) {
            [Some(one), Some(other)] => Some([one, other].map(|half| Self::new(half, levels, settings))),
            _ => None,
        });
        let mut halves = cuts.min_by(|a, b| growth(a).total_cmp(&growth(b)))?;
        for half in &mut halves {
            half.blind = if half.growth < WORTH * self.growth { 0 } else { self.blind + 1 };
        }
        let most = if self.growth > FAR_OUT * self.tolerated { BLIND_CUTS } else { 0 };
        halves.iter().all(|half| half.blind <= most).then_some(halves)
    }
}

/// A hull of at most so many vertices as a part may have that covers `full`, and how far it stands out, m.
pub(super) fn covering(full: &Hull, levels: &Levels, settings: &ShapeSettings) -> (Hull, f32) {
    let most = settings.max_vertices;
    let fitted = |soft: usize| {
        let part = cover(&reduce(full, levels, soft, most), full, levels, most);
        let growth = part.vertices.iter().map(|v| full.excess(*v)).fold(0.0, f32::max);
        (part, growth)
    };
    let (part, growth) = fitted(settings.soft_vertices.min(most));
    if growth > LEAST_GROWTH && part.vertices.len() < most { fitted(most) } else { (part, growth) }
}

/// The pieces' hulls with at most so many vertices as a part may have. A convex object of no more is its own part. If
/// parts are to cover what they stand for, pieces whose hulls would grow most are cut while there are fewer than `most`
/// parts.
pub(super) fn fit(
    clusters: Vec<Cluster>,
    solid: &Solid,
    levels: &Levels,
    most: usize,
    settings: &ShapeSettings,
) -> Vec<Hull> {
    if let [cluster] = &clusters[..]
        && cluster.hull.vertices.len() <= settings.max_vertices
    {
        return vec![cluster.hull.clone()];
    }
    if !settings.covering {
        let vertices = settings.max_vertices;
        return clusters.iter().map(|cluster| reduce(&cluster.hull, levels, vertices, vertices)).collect();
    }
    let mut fitted: Vec<Fitted> = clusters.into_iter().map(|cluster| Fitted::new(cluster, levels, settings)).collect();
    while fitted.len() < most {
        let candidates = (0..fitted.len()).filter(|&i| !fitted[i].done && fitted[i].growth > fitted[i].tolerated);
        let Some(worst) = candidates.max_by(|&a, &b| fitted[a].growth.total_cmp(&fitted[b].growth)) else {
            break;
        };
        match fitted[worst].halves(solid, levels, settings) {
            Some([one, other]) => {
                fitted[worst] = one;
                fitted.push(other);
            }
            None => fitted[worst].done = true,
        }
    }
    fitted.into_iter().map(|fitted| fitted.part).collect()
}

/// `hull` with its vertices moved so that it covers `full`; as far as that goes without spikes.
fn cover(hull: &Hull, full: &Hull, levels: &Levels, max_vertices: usize) -> Hull {
    let mut grown = hull.clone();
    for _ in 0..ROUNDS {
        let short = full.vertices.iter().map(|v| grown.excess(*v)).fold(0.0, f32::max);
        if short <= SHORT {
            break;
        }
        let Some(next) = Hull::new(&moved(&grown, full, levels)).filter(|h| h.vertices.len() <= max_vertices) else {
            break;
        };
        grown = next;
    }
    grown
}

/// The vertices of `hull`, each moved beyond the faces around it once those are pushed out to the support of `full`.
fn moved(hull: &Hull, full: &Hull, levels: &Levels) -> Vec<Vec3> {
    let lacking: Vec<f32> = (hull.planes.iter())
        .map(|n| full.vertices.iter().map(|v| n.truncate().dot(*v) - n.w).fold(0.0, f32::max))
        .collect();
    let faces: Vec<(Vec4, f32, bool)> = (hull.planes.iter().zip(&lacking))
        .map(|(&n, &lack)| (n, lack, lack <= SHORT && n.truncate().dot(levels.up).abs() > HORIZONTAL))
        .collect();
    let keep_level = |place: Vec3| {
        let along = levels.up.dot(place);
        place + (along.clamp(levels.low, levels.high) - along) * levels.up
    };
    follow(hull, &faces).into_iter().map(keep_level).collect()
}

/// The vertices of `hull`, each moved by the shortest way to where the faces around it will be: their planes, how far
/// each is pushed outwards (m), and whether it must not be passed.
pub(super) fn follow(hull: &Hull, faces: &[(Vec4, f32, bool)]) -> Vec<Vec3> {
    let size = hull.bounds().1.distance(hull.bounds().0);
    (hull.vertices.iter())
        .map(|&vertex| {
            let around: Vec<&(Vec4, f32, bool)> =
                faces.iter().filter(|(n, ..)| n.truncate().dot(vertex) > n.w - 1e-5 * size.max(0.1)).collect();
            let most = SPIKE * around.iter().map(|face| face.1).fold(0.0, f32::max);
            let mut place = vertex;
            for _ in 0..SWEEPS {
                for (n, lack, tight) in &around {
                    let beyond = n.truncate().dot(place) - (n.w + lack);
                    if beyond < 0.0 || *tight {
                        place -= beyond * n.truncate();
                    }
                }
            }
            vertex + (place - vertex).clamp_length_max(most)
        })
        .collect()
}
