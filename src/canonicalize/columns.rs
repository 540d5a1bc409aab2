//! Vertical columns through meshes: where an object has its underside and its top, and where its bearer is solid.
//!
//! All columns of a regular grid are cut with one triangle after the other, as a rasterizer does it; no mesh has to be
//! closed for that.

use super::tolerances::{COLUMNS, FIRST_COLUMN, FOOT_BAND, FOOT_SHARE, SHEET};
use glam::{DVec2, DVec3, Vec3Swizzles};
use std::ops::Range;

/// A mesh in the world, m.
pub(super) struct Surface {
    pub triangles: Vec<[DVec3; 3]>,
    pub low: DVec3,
    pub high: DVec3,
}

impl Surface {
    pub fn new(triangles: Vec<[DVec3; 3]>) -> Self {
        let corners = || triangles.iter().flatten().copied();
        let low = corners().fold(DVec3::INFINITY, DVec3::min);
        let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        Self { triangles, low, high }
    }
}

/// The part of an object that touches what it stands on: the columns in which it reaches down to its foot.
pub(super) struct Footprint {
    grid: Grid,
    /// Underside and top of the object in each column of the grid, m; none where it has no foot.
    feet: Vec<Option<[f64; 2]>>,
}

impl Footprint {
    /// Of an object as it stands.
    pub fn new(object: &Surface) -> Self {
        let grid = Grid::over(object);
        let mut feet: Vec<Option<[f64; 2]>> = vec![None; grid.count()];
        for triangle in &object.triangles {
            grid.cut(triangle, |i, height, _| {
                let [low, high] = feet[i].unwrap_or([height; 2]);
                feet[i] = Some([low.min(height), high.max(height)]);
            });
        }
        let highest = object.low.y + FOOT_BAND.max(FOOT_SHARE * (object.high.y - object.low.y));
        feet.iter_mut().for_each(|foot| *foot = foot.filter(|[low, _]| *low <= highest));
        if feet.iter().any(Option::is_some) {
            return Self { grid, feet };
        }
        // Feet thinner than the grid: one column at the lowest vertex.
        let corners = object.triangles.iter().flatten().copied();
        let foot = corners.reduce(|a, b| if b.y < a.y { b } else { a }).unwrap_or_default();
        let grid = Grid { origin: foot.xz(), size: [1, 1], ..grid };
        Self { grid, feet: vec![Some([foot.y, object.high.y])] }
    }

    /// For every column with a foot, the vertical shifts of the object at which it would reach into the bearer there,
    /// as sorted disjoint intervals, m. The footprint is first moved by `aside` in x and z, m.
    pub fn blocked(&self, bearer: &Surface, aside: DVec2) -> Vec<Vec<[f64; 2]>> {
        let grid = Grid { origin: self.grid.origin + aside, ..self.grid };
        let mut hits: Vec<Vec<(f64, bool)>> = vec![Vec::new(); grid.count()];
        for triangle in &bearer.triangles {
            grid.cut(triangle, |i, height, upward| hits[i].push((height, upward)));
        }
        let feet = self.feet.iter().zip(hits).filter_map(|(foot, hits)| foot.map(|foot| (foot, hits)));
        feet.map(|([bottom, top], hits)| joined(solids(hits).map(|[low, high]| [low - top, high - bottom]))).collect()
    }
}

/// Columns at equal distances in x and z.
#[derive(Clone, Copy)]
struct Grid {
    /// x and z of the first column, m.
    origin: DVec2,
    /// m.
    spacing: f64,
    /// Columns along x and z.
    size: [usize; 2],
}

impl Grid {
    fn over(object: &Surface) -> Self {
        let extent = (object.high - object.low).xz().max(DVec2::splat(1e-6));
        let spacing = extent.max_element() / COLUMNS as f64;
        let origin = object.low.xz() + spacing * FIRST_COLUMN;
        Self { origin, spacing, size: extent.to_array().map(|side| (side / spacing).ceil() as usize) }
    }

    fn count(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Visits every column that the triangle crosses, with the height there and whether the triangle faces up.
    fn cut(&self, triangle: &[DVec3; 3], mut visit: impl FnMut(usize, f64, bool)) {
        let [a, b, c] = triangle.map(|corner| corner.xz() - self.origin);
        let [columns, rows] = [0, 1].map(|axis| self.span(axis, [a[axis], b[axis], c[axis]]));
        let twice = (b - a).perp_dot(c - a);
        if twice == 0.0 || columns.is_empty() {
            return;
        }
        for row in rows {
            for column in columns.clone() {
                let p = self.spacing * DVec2::new(column as f64, row as f64);
                let weights = [(b - p).perp_dot(c - p), (c - p).perp_dot(a - p), (a - p).perp_dot(b - p)];
                if weights.iter().all(|w| w * twice >= 0.0) {
                    let height: f64 = weights.iter().zip(triangle).map(|(w, corner)| w / twice * corner.y).sum();
                    // In (x, z), a face is seen counter-clockwise from below.
                    visit(row * self.size[0] + column, height, twice < 0.0);
                }
            }
        }
    }

    /// The columns along an axis between the least and the greatest of three distances from the origin.
    fn span(&self, axis: usize, at: [f64; 3]) -> Range<usize> {
        let low = at.into_iter().fold(f64::INFINITY, f64::min) / self.spacing;
        let high = at.into_iter().fold(f64::NEG_INFINITY, f64::max) / self.spacing;
        let end = (high.floor() + 1.0).clamp(0.0, self.size[axis] as f64) as usize;
        (low.ceil().max(0.0) as usize).min(end)..end
    }
}

/// The solid stretches of a column, from its crossings (height, faces up). Where as many faces look down as up, what is
/// between is solid, parts within parts included; elsewhere, from a face that looks down to the next above it that
/// looks up. What has no such partner is a sheet.
fn solids(mut hits: Vec<(f64, bool)>) -> impl Iterator<Item = [f64; 2]> {
    // Two faces back to back enclose nothing: the one that looks down comes first.
    hits.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let closed = 2 * hits.iter().filter(|(_, upward)| *upward).count() == hits.len();
    // Heights at which the column has entered solids that it has not left.
    let mut entered: Vec<f64> = Vec::new();
    hits.into_iter().map(move |(height, upward)| match (upward, entered.last().copied()) {
        (true, Some(low)) => {
            entered.pop();
            [low, height]
        }
        (true, None) => [height - SHEET, height],
        (false, _) => {
            if !closed {
                entered.clear();
            }
            entered.push(height);
            [height - SHEET, height]
        }
    })
}

/// Overlapping intervals joined, in order.
fn joined(intervals: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let mut sorted: Vec<[f64; 2]> = intervals.collect();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut joined: Vec<[f64; 2]> = Vec::new();
    for [low, high] in sorted {
        match joined.last_mut() {
            Some(last) if low <= last[1] => last[1] = last[1].max(high),
            _ => joined.push([low, high]),
        }
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boards_are_solid_and_sheets_are_thin() {
        let solid = |hits: &[(f64, bool)]| joined(solids(hits.to_vec()));
        assert_eq!(solid(&[(0.3, true), (0.2, false), (0.5, true)]), [[0.2 - SHEET, 0.3], [0.5 - SHEET, 0.5]]);
        let nested = [(0.2, false), (0.25, false), (0.27, true), (0.3, true), (0.5, false), (0.6, true)];
        assert_eq!(solid(&nested), [[0.2 - SHEET, 0.3], [0.5 - SHEET, 0.6]]);
        // The undersides of two boards without their tops leave the room between them free.
        assert_eq!(solid(&[(0.2, false), (0.5, false), (0.53, true)]), [[0.2 - SHEET, 0.2], [0.5 - SHEET, 0.53]]);
    }

    #[test]
    fn a_triangle_is_cut_where_it_is() {
        let triangle = [DVec3::new(0.0, 1.0, 0.0), DVec3::new(0.0, 1.0, 1.0), DVec3::new(1.0, 2.0, 0.0)];
        let grid = Grid { origin: DVec2::splat(0.03), spacing: 0.1, size: [10, 10] };
        let mut heights = Vec::new();
        grid.cut(&triangle, |_, height, upward| {
            assert!(upward);
            heights.push(height);
        });
        assert_eq!(heights.len(), 55);
        assert!(heights.iter().all(|h| (1.0..2.0).contains(h)));
    }
}
