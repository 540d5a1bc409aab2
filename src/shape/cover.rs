//! Grows a reduced hull until it covers what it stands for, and divides what a few dozen vertices cannot follow.
//!
//! A part of 64 vertices within a pear lies up to 5 mm below its skin: pears that rest on such parts sink into each other
//! by as much. So the faces of the reduced hull are pushed out to the full hull's support, and the vertices follow them
//! by the shortest way. Horizontal faces that are tight already stay where they are: they are feet, tops and boards.

use super::ShapeSettings;
use super::divide::cut;
use super::hull::Hull;
use super::reduce::{Levels, reduce};
use glam::{Vec3, Vec4};

/// A part may stand out beyond its full hull by this share of its diagonal before it is worth another part …
const GROWTH: f32 = 0.01;
/// … or by this much, m, if that is more …
const LEAST_GROWTH: f32 = 1e-3;
/// … and the two halves must stand out by less than this share of what the whole does.
const WORTH: f32 = 0.8;
/// What a part falls short of its full hull in the end, m.
const SHORT: f32 = 0.02e-3;
/// Rounds of growing: a moved vertex tilts the faces around it, and the next round sees those.
const ROUNDS: usize = 4;
/// Sweeps over the faces around a vertex that look for its new place.
const SWEEPS: usize = 32;
/// A vertex moves at most so many times what its faces lack: the edge of a blade would grow a spike.
const SPIKE: f32 = 4.0;
/// Cosine with the vertical above which a face is horizontal (about 2.5°).
const HORIZONTAL: f32 = 0.999;

/// A hull and what it has become with the vertices that a part may have.
struct Fitted {
    full: Hull,
    part: Hull,
    /// How far the part stands out beyond the full hull, m, and how far it may.
    growth: f32,
    tolerated: f32,
}

impl Fitted {
    fn new(full: Hull, levels: &Levels, settings: &ShapeSettings) -> Self {
        let most = settings.max_vertices;
        let fitted = |soft: usize| {
            let part = cover(&reduce(&full, levels, soft, most), &full, levels, most);
            let growth = part.vertices.iter().map(|v| full.excess(*v)).fold(0.0, f32::max);
            (part, growth)
        };
        let (mut part, mut growth) = fitted(settings.soft_vertices.min(most));
        if growth > LEAST_GROWTH && part.vertices.len() < most {
            (part, growth) = fitted(most);
        }
        let (low, high) = full.bounds();
        let tolerated = LEAST_GROWTH.max(GROWTH * low.distance(high));
        Self { full, part, growth, tolerated }
    }
}

/// The hulls with at most so many vertices as a part may have. If they are to cover what they stand for, those that would
/// grow most are divided while there are fewer than `budget`.
pub(super) fn fit(hulls: Vec<Hull>, levels: &Levels, budget: usize, settings: &ShapeSettings) -> Vec<Hull> {
    if !settings.covering {
        let most = settings.max_vertices;
        return hulls.iter().map(|hull| reduce(hull, levels, most, most)).collect();
    }
    let mut fitted: Vec<Fitted> = hulls.into_iter().map(|hull| Fitted::new(hull, levels, settings)).collect();
    let mut whole = vec![true; fitted.len()];
    while fitted.len() < budget {
        let candidates = (0..fitted.len()).filter(|&i| whole[i] && fitted[i].growth > fitted[i].tolerated);
        let Some(worst) = candidates.max_by(|&a, &b| fitted[a].growth.total_cmp(&fitted[b].growth)) else {
            break;
        };
        let halves = halves(&fitted[worst].full).map(|half| half.map(|half| Fitted::new(half, levels, settings)));
        match halves {
            [Some(one), Some(other)] if one.growth.max(other.growth) < WORTH * fitted[worst].growth => {
                fitted[worst] = one;
                fitted.push(other);
                whole.push(true);
            }
            _ => whole[worst] = false,
        }
    }
    fitted.into_iter().map(|fitted| fitted.part).collect()
}

/// The two sides of a hull, cut across its longest side.
fn halves(hull: &Hull) -> [Option<Hull>; 2] {
    let (low, high) = hull.bounds();
    let extent = high - low;
    cut(hull, Vec3::AXES.into_iter().fold(Vec3::X, |best, a| if a.dot(extent) > best.dot(extent) { a } else { best }))
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

/// The vertices of `hull`, each moved by the shortest way to where the faces around it will be: their planes, how far each
/// is pushed outwards (m), and whether it must not be passed.
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
