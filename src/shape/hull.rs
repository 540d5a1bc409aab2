//! A convex polytope: vertices, triangles and deduplicated face planes.
//!
//! parry's hull works in f32 and refuses flat input. Here every input gives a hull: what is thinner than
//! `MIN_THICKNESS` is thickened first, and a hull that lost points to rounding is rebuilt from fewer, coarser points.

use super::convex_hull::{HullMesh, convex_hull, sound_hull};
use super::eigen::symmetric_eigen;
use super::tolerances::hull::{DENSE, MIN_THICKNESS};
use fearless_simd::{Level, dispatch, prelude::*};
use glam::{DMat3, DVec3, Vec3, Vec4};

/// Vertices and outward triangles of the hull of points, if they have one.
type Attempt = fn(&[Vec3]) -> Option<HullMesh>;

/// A convex polytope with volume.
#[derive(Clone, Debug, Default)]
pub(super) struct Hull {
    /// Corners, m.
    pub vertices: Vec<Vec3>,
    /// Outward triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Outward unit normal and offset of every face, `n · x ≤ d` inside; coplanar triangles share one.
    pub planes: Vec<Vec4>,
}

impl Hull {
    /// The hull of `points` (m), thickened if flat. `None` without points, or if they are not finite.
    pub fn new(points: &[Vec3]) -> Option<Self> {
        let extreme = extremes(points);
        Self::solid(&extreme).or_else(|| {
            let thick = thicken(&extreme, MIN_THICKNESS);
            Self::solid(&thick).or_else(|| Self::solid(&boxed(&thick)))
        })
    }

    /// The hull of those points that are extreme in one of the directions; of all if they are no more than these.
    pub fn coarse(points: &[Vec3], directions: &[Vec3]) -> Option<Self> {
        if points.len() <= directions.len() {
            return Self::new(points);
        }
        let mut chosen = supports(points, directions);
        chosen.sort_unstable();
        chosen.dedup();
        let chosen: Vec<Vec3> = chosen.into_iter().map(|i| points[i as usize]).collect();
        Self::new(&chosen)
    }

    fn solid(points: &[Vec3]) -> Option<Self> {
        let (low, high) = bounds(points);
        let size = (high - low).max_element();
        if points.len() < 4 || !size.is_finite() || size <= 0.0 {
            return None;
        }
        // Rounding in parry's hull is relative to the coordinates: centre them, and merge what is closer than that.
        let center = 0.5 * (low + high);
        // A thin plate is flat for parry's hull, but not after a linear map that makes it round.
        let [plain, white]: [Attempt; 2] = [sound_hull, convex_hull];
        for (grid, hull) in [(1e-6_f32, plain), (1e-4, plain), (1e-6, white), (1e-4, white), (1e-3, plain)] {
            let local = merged(points, center, size * grid);
            let Some((vertices, triangles)) = hull(&local) else {
                continue;
            };
            let planes = planes(&vertices, &triangles);
            let tolerance = size * grid.max(2e-5);
            let whole = planes.len() >= 4
                && local.iter().all(|p| planes.iter().all(|n| n.truncate().dot(*p) <= n.w + tolerance));
            let hull = Self {
                vertices: vertices.iter().map(|v| *v + center).collect(),
                triangles,
                planes: planes.iter().map(|n| n.truncate().extend(n.w + n.truncate().dot(center))).collect(),
            };
            if whole && hull.thickness() > 0.25 * MIN_THICKNESS.min(0.02 * size) && hull.volume() > 0.0 {
                return Some(hull);
            }
        }
        None
    }

    /// Volume, m³.
    pub fn volume(&self) -> f32 {
        let origin = self.vertices.first().copied().unwrap_or_default();
        let corner = |i: u32| (self.vertices[i as usize] - origin).as_dvec3();
        let six: f64 = self.triangles.iter().map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2])))).sum();
        (six / 6.0) as f32
    }

    /// Surface, m².
    pub fn area(&self) -> f32 {
        let corner = |i: u32| self.vertices[i as usize];
        let twice = |t: &[u32; 3]| (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0])).length();
        0.5 * self.triangles.iter().map(twice).sum::<f32>()
    }

    /// Least extent along a face normal, m.
    pub fn thickness(&self) -> f32 {
        let along = |n: &Vec4| self.vertices.iter().map(|v| n.w - n.truncate().dot(*v)).fold(0.0, f32::max);
        self.planes.iter().map(along).fold(f32::INFINITY, f32::min)
    }

    /// Edges between triangles, each once.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges: Vec<[u32; 2]> = (self.triangles.iter())
            .flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]])
            .map(|[i, j]| [i.min(j), i.max(j)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// How far `point` lies outside the farthest face plane, m; negative inside. A lower bound of the distance.
    pub fn excess(&self, point: Vec3) -> f32 {
        self.planes.iter().map(|n| n.truncate().dot(point) - n.w).fold(f32::NEG_INFINITY, f32::max)
    }

    /// Least and largest coordinate along a direction, m.
    pub fn extent(&self, direction: Vec3) -> (f32, f32) {
        let along = self.vertices.iter().map(|v| direction.dot(*v));
        along.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), a| (l.min(a), h.max(a)))
    }

    /// Lowest and highest corner of the box around it.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        bounds(&self.vertices)
    }
}

/// Corners and outward triangles of the convex hull of any points (m): flat ones are thickened, dense ones thinned.
/// `None` without points.
pub fn solid_hull(points: &[Vec3]) -> Option<HullMesh> {
    Hull::new(points).map(|hull| (hull.vertices, hull.triangles))
}

/// Lowest and highest corner of the box around `points`.
pub(super) fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)))
}

/// Points of a surface on both sides of the plane `normal · x = offset`, those in the plane on both.
pub(super) fn plane_sides(vertices: &[Vec3], edges: &[[u32; 2]], normal: Vec3, offset: f32) -> (Vec<Vec3>, Vec<Vec3>) {
    let heights: Vec<f32> = vertices.iter().map(|v| normal.dot(*v) - offset).collect();
    let (mut below, mut above) = (Vec::new(), Vec::new());
    for (v, h) in vertices.iter().zip(&heights) {
        if *h <= 0.0 {
            below.push(*v);
        }
        if *h >= 0.0 {
            above.push(*v);
        }
    }
    for [i, j] in edges.iter().map(|e| e.map(|i| i as usize)) {
        if heights[i] * heights[j] < 0.0 {
            let share = heights[i] / (heights[i] - heights[j]);
            let cut = vertices[i] + (vertices[j] - vertices[i]) * share;
            below.push(cut);
            above.push(cut);
        }
    }
    (below, above)
}

/// `count` directions spread evenly over the sphere (Fibonacci lattice), after the six axis directions.
pub(super) fn directions(count: usize) -> Vec<Vec3> {
    let golden = std::f32::consts::PI * (3.0 - 5.0_f32.sqrt());
    let spread = (0..count).map(|i| {
        let y = 1.0 - 2.0 * (i as f32 + 0.5) / count as f32;
        let radius = (1.0 - y * y).sqrt();
        let (sin, cos) = (golden * i as f32).sin_cos();
        Vec3::new(cos * radius, y, sin * radius)
    });
    Vec3::AXES.into_iter().flat_map(|a| [a, -a]).chain(spread).collect()
}

/// For every direction the index of the point farthest along it, the first of equals; with the widest vectors that the
/// processor has, because a decomposition asks for millions.
pub(super) fn supports(points: &[Vec3], directions: &[Vec3]) -> Vec<u32> {
    dispatch!(Level::new(), simd => simd.vectorize(
        #[inline(always)]
        || farthest(points, directions),
    ))
}

#[inline(always)]
fn farthest(points: &[Vec3], directions: &[Vec3]) -> Vec<u32> {
    const LANES: usize = 16;
    let Some(&first) = points.first() else { return vec![0; directions.len()] };
    // The last block is filled up with the first point, which has come before.
    let blocks: Vec<[[f32; LANES]; 3]> = (points.chunks(LANES))
        .map(|chunk| [0, 1, 2].map(|axis| std::array::from_fn(|lane| chunk.get(lane).unwrap_or(&first)[axis])))
        .collect();
    let mut found = Vec::with_capacity(directions.len());
    for direction in directions {
        let (mut reach, mut block) = ([f32::NEG_INFINITY; LANES], [0_u32; LANES]);
        for (number, [x, y, z]) in (0..).zip(&blocks) {
            for lane in 0..LANES {
                let along = direction.x * x[lane] + direction.y * y[lane] + direction.z * z[lane];
                let farther = along > reach[lane];
                reach[lane] = if farther { along } else { reach[lane] };
                block[lane] = if farther { number } else { block[lane] };
            }
        }
        let index = |lane: usize| block[lane] * LANES as u32 + lane as u32;
        let better = |a: usize, b: usize| if (reach[b], index(a)) > (reach[a], index(b)) { b } else { a };
        found.push(index((1..LANES).fold(0, better)));
    }
    found
}

/// Leaves out points that are surely inside, and thins a dense scan: the hull costs more than linear in the points.
fn extremes(points: &[Vec3]) -> Vec<Vec3> {
    if points.len() < 512 {
        return points.to_vec();
    }
    let seeds: Vec<Vec3> = supports(points, &directions(58)).into_iter().map(|i| points[i as usize]).collect();
    let Some(inner) = Hull::solid(&seeds) else {
        return points.to_vec();
    };
    let outer: Vec<Vec3> = points.iter().copied().filter(|&p| inner.excess(p) > -1e-6).collect();
    if outer.len() < DENSE {
        return outer.into_iter().chain(seeds).collect();
    }
    // Of each cell the point farthest out: on a curved face of that many cells the loss is size / (8 · 48²).
    let (low, high) = bounds(points);
    let (center, spacing) = (0.5 * (low + high), (high - low).max_element() / 48.0);
    let mut keyed: Vec<([i32; 3], u32, usize)> = outer
        .iter()
        .enumerate()
        .map(|(i, p)| (((*p - low) / spacing).as_ivec3().to_array(), u32::MAX - p.distance(center).to_bits(), i))
        .collect();
    keyed.sort_unstable();
    keyed.dedup_by_key(|k| k.0);
    keyed.into_iter().map(|k| outer[k.2]).chain(seeds).collect()
}

/// The points relative to `center`, one for each cell of a grid of that spacing, in a fixed order.
fn merged(points: &[Vec3], center: Vec3, spacing: f32) -> Vec<Vec3> {
    let mut keyed: Vec<([i64; 3], usize)> = points
        .iter()
        .enumerate()
        .map(|(i, p)| (((*p - center) / spacing).round().to_array().map(|c| c as i64), i))
        .collect();
    keyed.sort_unstable();
    keyed.dedup_by_key(|k| k.0);
    keyed.iter().map(|&(_, i)| points[i] - center).collect()
}

/// Face planes of outward triangles, one for all triangles in a plane; every vertex lies on or below each.
fn planes(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec4> {
    let mut faces: Vec<(f32, Vec3)> = triangles
        .iter()
        .filter_map(|t| {
            let [a, b, c] = t.map(|i| vertices[i as usize]);
            let normal = (b - a).as_dvec3().cross((c - a).as_dvec3());
            let area = normal.length();
            (area > 1e-14).then(|| (area as f32, (normal / area).as_vec3()))
        })
        .collect();
    faces.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut kept: Vec<Vec4> = Vec::new();
    for (_, n) in faces {
        let d = vertices.iter().map(|v| n.dot(*v)).fold(f32::NEG_INFINITY, f32::max);
        if !kept.iter().any(|k| k.truncate().dot(n) > 0.999_999) {
            kept.push(n.extend(d));
        }
    }
    kept
}

/// Principal directions of a point cloud, thinnest first.
pub(super) fn principal_directions(points: &[Vec3]) -> [Vec3; 3] {
    let mean = points.iter().map(|p| p.as_dvec3()).sum::<DVec3>() / points.len().max(1) as f64;
    let mut spread = DMat3::ZERO;
    for p in points {
        let d = p.as_dvec3() - mean;
        spread += DMat3::from_cols(d * d.x, d * d.y, d * d.z);
    }
    symmetric_eigen(spread).map(|(_, axis)| axis.as_vec3())
}

/// Moves copies of the points apart along every principal direction in which they span less than `least` (m).
pub(super) fn thicken(points: &[Vec3], least: f32) -> Vec<Vec3> {
    let mut result = points.to_vec();
    for axis in principal_directions(points) {
        let (low, high) = points
            .iter()
            .map(|p| axis.dot(*p))
            .fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), a| (l.min(a), h.max(a)));
        if high - low < least {
            let shift = axis * (0.5 * (least - (high - low)));
            result = result.iter().flat_map(|p| [*p + shift, *p - shift]).collect();
        }
    }
    result
}

/// Corners of the box around the points, no side shorter than the least thickness: the last resort.
fn boxed(points: &[Vec3]) -> Vec<Vec3> {
    let (low, high) = bounds(points);
    let center = 0.5 * (low + high);
    let half = (0.5 * (high - low)).max(Vec3::splat(0.5 * MIN_THICKNESS));
    box_corners(half).into_iter().map(|corner| center + corner).collect()
}

/// Corners of a box around the origin with these half extents, x changing fastest.
pub fn box_corners(half: Vec3) -> Vec<Vec3> {
    let sign = |i: usize, bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
    (0..8).map(|i| half * Vec3::new(sign(i, 0), sign(i, 1), sign(i, 2))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The first of the points farthest along a direction, one after the other.
    fn first_farthest(points: &[Vec3], direction: Vec3) -> u32 {
        let farther = |(reach, at): (f32, u32), (i, p): (u32, &Vec3)| {
            let along = direction.dot(*p);
            if along > reach { (along, i) } else { (reach, at) }
        };
        (0..).zip(points).fold((f32::NEG_INFINITY, 0), farther).1
    }

    proptest! {
        /// Of coarse coordinates many points are equally far, and some are no numbers.
        #[test]
        fn supports_are_the_first_of_the_farthest(
            coarse in prop::collection::vec(prop::array::uniform3(-3i8..=3), 0..70),
            lost in prop::collection::vec(0usize..70, 0..3),
        ) {
            let mut points: Vec<Vec3> = coarse.iter().map(|c| Vec3::from(c.map(f32::from))).collect();
            lost.iter().filter(|&&i| i < coarse.len()).for_each(|&i| points[i].y = f32::NAN);
            let directions = directions(20);
            let expected: Vec<u32> = directions.iter().map(|&d| first_farthest(&points, d)).collect();
            prop_assert_eq!(supports(&points, &directions), expected);
        }
    }
}
