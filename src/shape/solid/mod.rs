//! What is solid and what is free space, on a grid, and how far a hull reaches into the free space.
//!
//! Real meshes are unions of overlapping shells, often open. A cell is inside where the signed crossings of rays along
//! the six axis directions sum to a winding number of at least one half; it is free where a flood from outside gets,
//! and anything with nothing above it is open to the sky even if its walls are single sheets (a cardboard box).
//! Every free cell carries its distance to the surface; integrated over a hull that is the *bulge* (m⁴), the one
//! number by which splits and merges are judged: it punishes bridging a cavity much harder than a wavy face.

mod fill;

use super::hull::Hull;
use crate::shape::tolerances::solid::{FLATTEST, MOST_CELLS, SMALLEST_CELL};
use fearless_simd::{Level, dispatch, prelude::*};
use glam::Vec3;

/// The grid. Cells are ordered with axis `order[0]` fastest: the longest, so that columns are few.
pub(super) struct Solid {
    origin: Vec3,
    cell: f32,
    size: [usize; 3],
    order: [usize; 3],
    inside: Vec<bool>,
    free: Vec<bool>,
    above: Vec<bool>,
    /// Running sums along the columns, one longer than the column: of distance · weight, m.
    bulge: Vec<f32>,
    /// The same of the free volume, cells.
    open: Vec<f32>,
}

impl Solid {
    /// Fills a grid of about `cells` cells around the triangles (m). `up` is the axis direction nearest to up.
    pub fn new(triangles: &[[Vec3; 3]], up: Vec3, cells: usize) -> Self {
        let corners: Vec<Vec3> = triangles.iter().flatten().copied().collect();
        let (low, high) = super::hull::bounds(&corners);
        let extent = (high - low).max(Vec3::splat((high - low).max_element() * FLATTEST));
        let cell =
            (extent.element_product() / cells as f32).cbrt().max(extent.max_element() / MOST_CELLS).max(SMALLEST_CELL);
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| extent[b].total_cmp(&extent[a]).then(a.cmp(&b)));
        // Two cells of air on each side. The offset keeps cell centres off the flat faces of furniture.
        let margin = Vec3::new(2.03, 2.07, 2.05) * cell;
        let size = [0, 1, 2].map(|i| ((high - low)[i] / cell).ceil() as usize + 4);
        let mut solid = Self {
            origin: low - margin,
            cell,
            size,
            order,
            inside: Vec::new(),
            free: Vec::new(),
            above: Vec::new(),
            bulge: Vec::new(),
            open: Vec::new(),
        };
        let near = solid.near_surface(triangles);
        let (winding, sky) = solid.crossings(triangles, up);
        let total = size[0] * size[1] * size[2];
        // Six rays, each worth one: half of them is a winding number of one half.
        solid.inside = (0..total).map(|i| winding[i].abs() >= 3 && !sky[i]).collect();
        let walls: Vec<bool> = (0..total).map(|i| solid.inside[i] || near[i].is_finite()).collect();
        let reached = solid.flood(&walls);
        // Cells at the surface whose centre is outside are free too if any neighbour is.
        solid.free = (0..total)
            .map(|i| {
                !solid.inside[i] && (reached[i] || (near[i].is_finite() && solid.neighbours(i).any(|n| reached[n])))
            })
            .collect();
        let distance = solid.distances(&near);
        solid.close_narrow(&distance);
        solid.above = solid.things_below(&near, up);
        solid.sum_columns(&distance);
        solid
    }

    /// Side of a cell, m.
    pub fn cell(&self) -> f32 {
        self.cell
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.inside.len()
    }

    /// The cell that holds `point`.
    pub fn index(&self, point: Vec3) -> usize {
        let at = (point - self.origin) / self.cell;
        self.flat([0, 1, 2].map(|i| (at[i].max(0.0) as usize).min(self.size[i] - 1)))
    }

    /// The cells whose centres lie in a box.
    pub fn cells_within(&self, low: Vec3, high: Vec3) -> impl Iterator<Item = usize> + use<'_> {
        let first = ((low - self.origin) / self.cell - 0.5).ceil().max(Vec3::ZERO);
        let last = ((high - self.origin) / self.cell - 0.5).floor();
        let range = move |i: usize| first[i] as usize..((last[i] + 1.0).max(0.0) as usize).min(self.size[i]);
        range(2).flat_map(move |z| range(1).flat_map(move |y| range(0).map(move |x| self.flat([x, y, z]))))
    }

    /// Centre of a cell.
    pub fn center(&self, index: usize) -> Vec3 {
        let c = self.unflat(index);
        self.origin + (Vec3::new(c[0] as f32, c[1] as f32, c[2] as f32) + 0.5) * self.cell
    }

    /// Whether the cell's centre is within the mesh.
    pub fn is_inside(&self, index: usize) -> bool {
        self.inside[index]
    }

    /// Whether the cell's centre and those of all its neighbours are within the mesh.
    pub fn is_deep(&self, index: usize) -> bool {
        self.inside[index] && self.neighbours(index).all(|neighbour| self.inside[neighbour])
    }

    /// Whether the cell's centre is outside the mesh where other objects can get.
    pub fn is_free(&self, index: usize) -> bool {
        self.free[index]
    }

    /// The up to six cells that share a face with `index`.
    pub fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> + use<'_> {
        let c = self.unflat(index);
        (0..6).filter_map(move |k| {
            let (axis, forward) = (k / 2, k % 2 == 1);
            let mut n = c;
            if forward {
                n[axis] += 1;
            } else {
                n[axis] = n[axis].checked_sub(1)?;
            }
            (n[axis] < self.size[axis]).then(|| self.flat(n))
        })
    }

    /// Free space within `hull`: its bulge, m⁴, and its volume, m³.
    pub fn protrusion(&self, hull: &Hull) -> (f32, f32) {
        let (mut bulge, mut open) = (0.0_f64, 0.0_f64);
        self.columns(hull, |row, from, to| {
            bulge += f64::from(interpolate(&self.bulge[row..], to) - interpolate(&self.bulge[row..], from));
            open += f64::from(interpolate(&self.open[row..], to) - interpolate(&self.open[row..], from));
        });
        let volume = f64::from(self.cell).powi(3);
        ((bulge * volume) as f32, (open * volume) as f32)
    }

    /// Free volume in the union of `hulls` and the volume of the union, m³.
    pub fn union(&self, hulls: &[Hull]) -> (f32, f32) {
        let mut spans: Vec<(usize, f32, f32)> = Vec::new();
        for hull in hulls {
            self.columns(hull, |row, from, to| spans.push((row, from, to)));
        }
        spans.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let (mut open, mut all, mut last) = (0.0_f64, 0.0_f64, (usize::MAX, 0.0_f32));
        for (row, from, to) in spans {
            if row != last.0 {
                last = (row, f32::NEG_INFINITY);
            }
            let from = from.max(last.1);
            if to > from {
                open += f64::from(interpolate(&self.open[row..], to) - interpolate(&self.open[row..], from));
                all += f64::from(to - from);
                last.1 = to;
            }
        }
        let volume = f64::from(self.cell).powi(3);
        ((open * volume) as f32, (all * volume) as f32)
    }

    /// Calls `visit(start of the column's sums, from, to)` with the span of every column within the hull, in cells.
    fn columns(&self, hull: &Hull, visit: impl FnMut(usize, f32, f32)) {
        dispatch!(Level::new(), simd => simd.vectorize(
            #[inline(always)]
            || self.spans(hull, visit),
        ));
    }

    #[inline(always)]
    fn spans(&self, hull: &Hull, mut visit: impl FnMut(usize, f32, f32)) {
        let [a, b, c] = self.order;
        let (low, high) = hull.bounds();
        let range = |axis: usize| {
            let first = ((low[axis] - self.origin[axis]) / self.cell - 0.5).ceil().max(0.0) as usize;
            let last = ((high[axis] - self.origin[axis]) / self.cell - 0.5).floor().max(-1.0) as isize;
            first..((last + 1).max(0) as usize).min(self.size[axis])
        };
        // Every plane bounds x by k0 + k1 · y + k2 · z, from above or below, all in cells.
        let (mut above, mut below, mut across) = (Vec::new(), Vec::new(), Vec::new());
        for n in &hull.planes {
            let d = (n.w - n.truncate().dot(self.origin)) / self.cell;
            if n[a].abs() <= 1e-5 {
                across.push([d, -n[b], -n[c]]);
            } else {
                let k = [d / n[a], -n[b] / n[a], -n[c] / n[a]];
                if n[a] > 0.0 { above.push(k) } else { below.push(k) }
            }
        }
        let rows = range(b);
        let first = rows.start as f32 + 0.5;
        let (mut from, mut to) = (vec![0.0_f32; rows.len()], vec![0.0_f32; rows.len()]);
        for z in range(c) {
            let fz = z as f32 + 0.5;
            from.fill(0.0);
            to.fill(self.size[a] as f32);
            // Straight loops over a row, so that the compiler can use wide instructions.
            for k in &above {
                let start = k[0] + k[2] * fz + k[1] * first;
                to.iter_mut().enumerate().for_each(|(i, t)| *t = t.min(start + k[1] * i as f32));
            }
            for k in &below {
                let start = k[0] + k[2] * fz + k[1] * first;
                from.iter_mut().enumerate().for_each(|(i, f)| *f = f.max(start + k[1] * i as f32));
            }
            for k in &across {
                let start = k[0] + k[2] * fz + k[1] * first;
                to.iter_mut()
                    .enumerate()
                    .for_each(|(i, t)| *t = if start + k[1] * (i as f32) < 0.0 { -1.0 } else { *t });
            }
            for (i, y) in rows.clone().enumerate() {
                if to[i] > from[i] {
                    visit((z * self.size[b] + y) * (self.size[a] + 1), from[i], to[i]);
                }
            }
        }
    }

    fn flat(&self, c: [usize; 3]) -> usize {
        let [i, j, k] = self.order;
        (c[k] * self.size[j] + c[j]) * self.size[i] + c[i]
    }

    fn unflat(&self, index: usize) -> [usize; 3] {
        let [i, j, k] = self.order;
        let mut c = [0; 3];
        c[i] = index % self.size[i];
        c[j] = index / self.size[i] % self.size[j];
        c[k] = index / self.size[i] / self.size[j];
        c
    }
}

/// Value of running sums at a fractional cell.
fn interpolate(sums: &[f32], at: f32) -> f32 {
    let whole = at as usize;
    let rest = at - whole as f32;
    if rest > 0.0 { sums[whole] + rest * (sums[whole + 1] - sums[whole]) } else { sums[whole] }
}
