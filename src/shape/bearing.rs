//! Surfaces on which things rest: parts that follow them more closely.
//!
//! A convex part over a hollow (a worn table top, a plate) spans it, and what rests there floats above the mesh by the
//! depth of the hollow. So pieces of objects that bear others are cut further, in two or in four, until no part stands
//! far above the surface under it.

use super::cluster::Cluster;
use super::solid::Solid;
use super::tolerances::bearing::{COLUMNS, STEEPEST, TOLERATED, WORTH};
use glam::{Vec2, Vec3, Vec4};

/// A piece and how its hull stands above its surface.
struct Cover {
    cluster: Cluster,
    /// Depth under the hull, 95th percentile over the columns, m.
    depth: f32,
    /// Squared depth integrated over the columns, m⁴.
    waste: f32,
}

/// What of a piece is seen from above, in columns of equal width.
struct Columns {
    low: Vec2,
    /// Width of a column, m.
    cell: f32,
    count: [usize; 2],
    /// Height of the surface, m, and the cosine of its slope; minus infinity where there is none.
    tops: Vec<(f32, f32)>,
}

impl Columns {
    /// `flat`: where a point lies seen from above.
    fn new(cluster: &Cluster, up: Vec3, flat: impl Fn(Vec3) -> Vec2) -> Self {
        let corners = cluster.hull.vertices.iter().map(|&p| flat(p));
        let (low, high) =
            corners.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let cell = ((high - low).max_element() / COLUMNS as f32).max(f32::MIN_POSITIVE);
        let count = ((high - low) / cell).ceil().max(Vec2::ONE).to_array().map(|n| n as usize);
        let mut columns = Self { low, cell, count, tops: vec![(f32::NEG_INFINITY, 0.0); count[0] * count[1]] };
        for t in cluster.triangles() {
            let slope = (t[1] - t[0]).cross(t[2] - t[0]).normalize_or_zero().dot(up);
            columns.see(t.map(&flat), t.map(|corner| up.dot(corner)), slope);
        }
        columns
    }

    /// Middle of a column.
    fn middle(&self, index: usize) -> Vec2 {
        let [column, row] = [index % self.count[0], index / self.count[0]];
        self.low + self.cell * (Vec2::new(column as f32, row as f32) + 0.5)
    }

    /// Takes in a triangle: its corners seen from above, and their heights.
    fn see(&mut self, [a, b, c]: [Vec2; 3], heights: [f32; 3], slope: f32) {
        let twice = (b - a).perp_dot(c - a);
        if twice == 0.0 {
            return;
        }
        let at = |p: Vec2| ((p - self.low) / self.cell - 0.5).max(Vec2::ZERO);
        let (first, last) = (at(a.min(b).min(c)).floor(), at(a.max(b).max(c)).ceil());
        for row in first.y as usize..=(last.y as usize).min(self.count[1] - 1) {
            for column in first.x as usize..=(last.x as usize).min(self.count[0] - 1) {
                let index = row * self.count[0] + column;
                let p = self.middle(index);
                let weights = [(b - p).perp_dot(c - p), (c - p).perp_dot(a - p), (a - p).perp_dot(b - p)];
                let height: f32 = weights.iter().zip(heights).map(|(w, height)| w / twice * height).sum();
                if weights.iter().all(|w| w * twice >= 0.0) && height > self.tops[index].0 {
                    self.tops[index] = (height, slope);
                }
            }
        }
    }
}

impl Cover {
    fn new(cluster: Cluster, solid: &Solid, up: Vec3) -> Self {
        let (u, v) = up.any_orthonormal_pair();
        let columns = Columns::new(&cluster, up, |p| Vec2::new(u.dot(p), v.dot(p)));
        let above: Vec<Vec4> = cluster.hull.planes.iter().copied().filter(|n| n.truncate().dot(up) > 1e-6).collect();
        let mut depths = Vec::new();
        for (i, &(height, slope)) in columns.tops.iter().enumerate().filter(|(_, top)| top.1.abs() >= STEEPEST) {
            let p = columns.middle(i);
            let foot = u * p.x + v * p.y;
            let reach = |n: &Vec4| (n.w - n.truncate().dot(foot)) / n.truncate().dot(up);
            let cover = above.iter().map(reach).fold(f32::INFINITY, f32::min);
            let between = foot + up * (0.5 * (height + cover));
            // Seen from below, the surface is the underside of something solid.
            if cover > height && (slope > 0.0 || solid.is_free(solid.index(between))) {
                depths.push((cover - height) * slope.abs());
            }
        }
        let waste = depths.iter().map(|d| d * d).sum::<f32>() * columns.cell * columns.cell;
        depths.sort_by(f32::total_cmp);
        let depth = depths.get(depths.len() * 19 / 20).copied().unwrap_or(0.0);
        Self { cluster, depth, waste }
    }

    /// The piece cut in two across the horizontal direction that leaves least; in four if that alone helps, as where it
    /// sags both ways. None if nothing helps.
    fn cut(&self, solid: &Solid, up: Vec3) -> Option<Vec<Self>> {
        let (u, v) = up.any_orthonormal_pair();
        let ways: [&[Vec3]; 3] = [&[u], &[v], &[u, v]];
        let waste = |covers: &Vec<Self>| covers.iter().map(|cover| cover.waste).sum::<f32>();
        let cuts = ways.map(|normals| self.cut_across(normals, solid, up).filter(|c| waste(c) < WORTH * self.waste));
        let [one, other, both] = cuts;
        one.into_iter().chain(other).min_by(|a, b| waste(a).total_cmp(&waste(b))).or(both)
    }

    /// The pieces on all sides of planes through the middle.
    fn cut_across(&self, normals: &[Vec3], solid: &Solid, up: Vec3) -> Option<Vec<Self>> {
        let mut sides = vec![self.cluster.clone()];
        for &normal in normals {
            let (low, high) = self.cluster.hull.extent(normal);
            let cut = sides.iter().flat_map(|side| side.sides(normal, 0.5 * (low + high), solid));
            sides = cut.collect::<Option<_>>()?;
        }
        Some(sides.into_iter().map(|side| Self::new(side, solid, up)).collect())
    }
}

/// Cuts those pieces further whose hulls stand above their surface, as long as there are fewer than `most`.
pub(super) fn follow_tops(clusters: Vec<Cluster>, solid: &Solid, up: Vec3, most: usize) -> Vec<Cluster> {
    let mut covers: Vec<Cover> = clusters.into_iter().map(|cluster| Cover::new(cluster, solid, up)).collect();
    let mut whole = vec![false; covers.len()];
    while covers.len() < most {
        let open = (0..covers.len()).filter(|&i| !whole[i] && covers[i].depth > TOLERATED);
        let Some(worst) = open.max_by(|&a, &b| covers[a].waste.total_cmp(&covers[b].waste)) else { break };
        match covers[worst].cut(solid, up).filter(|cut| covers.len() + cut.len() - 1 <= most) {
            Some(cut) => {
                whole.resize(covers.len() + cut.len() - 1, false);
                covers.extend(cut);
                covers.swap_remove(worst);
            }
            None => whole[worst] = true,
        }
    }
    covers.into_iter().map(|cover| cover.cluster).collect()
}
