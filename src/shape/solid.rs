//! What is solid and what is free space, on a grid, and how far a hull reaches into the free space.
//!
//! Real meshes are unions of overlapping shells, often open. A cell is inside where the signed crossings of rays along
//! the six axis directions sum to a winding number of at least one half; it is free where a flood from outside gets,
//! and anything with nothing above it is open to the sky even if its walls are single sheets (a cardboard box).
//! Every free cell carries its distance to the surface; integrated over a hull that is the *bulge* (m⁴), the one
//! number by which splits and merges are judged: it punishes bridging a cavity much harder than a wavy face.

use super::hull::Hull;
use glam::Vec3;
use parry3d::query::PointQuery;
use parry3d::shape::Triangle;
use std::collections::BinaryHeap;

/// Depth of free space that the grid cannot tell from a face that runs through the cells, in cells: not counted.
const UNSEEN: f32 = 0.4;
/// Weight of free space above a surface of the object: things stand there. Below it is mostly legs and air.
const ABOVE: f32 = 2.0;
/// A hollow whose entrance is narrower than this share of it (a bottle, a teapot, slots in a housing) is filled.
const ENTRANCE: f32 = 0.4;

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
        let extent = (high - low).max(Vec3::splat((high - low).max_element() * 0.02));
        let cell = (extent.element_product() / cells as f32).cbrt().max(extent.max_element() / 192.0);
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
    fn columns(&self, hull: &Hull, mut visit: impl FnMut(usize, f32, f32)) {
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

    /// Distance of the cell centre to the triangles that touch the cell, m; infinite for all other cells.
    fn near_surface(&self, triangles: &[[Vec3; 3]]) -> Vec<f32> {
        let mut near = vec![f32::INFINITY; self.size.iter().product()];
        let reach = self.cell * 0.5 * 3.0_f32.sqrt();
        for &[a, b, c] in triangles {
            let shape = Triangle::new(a, b, c);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let first = ((a.min(b).min(c) - self.origin) / self.cell).floor();
            let last = ((a.max(b).max(c) - self.origin) / self.cell).floor();
            let range = |i: usize| first[i].max(0.0) as usize..=(last[i].max(0.0) as usize).min(self.size[i] - 1);
            for z in range(2) {
                for y in range(1) {
                    for x in range(0) {
                        let index = self.flat([x, y, z]);
                        let center = self.center(index);
                        if normal.dot(center - a).abs() <= reach {
                            let distance = shape.distance_to_local_point(center, true);
                            if distance <= reach {
                                near[index] = near[index].min(distance);
                            }
                        }
                    }
                }
            }
        }
        near
    }

    /// Signed crossings summed over the six axis directions, and whether nothing lies above.
    fn crossings(&self, triangles: &[[Vec3; 3]], up: Vec3) -> (Vec<i32>, Vec<bool>) {
        let total = self.size.iter().product();
        let mut winding = vec![0_i32; total];
        let mut sky = vec![false; total];
        let up_axis = (0..3).find(|&i| up[i].abs() > 0.5);
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut hits: Vec<(usize, f32, i32)> = Vec::new();
            for t in triangles {
                let at = t.map(|p| (p - self.origin) / self.cell - 0.5);
                let turn = |p: Vec3, q: Vec3, x: f32, y: f32| {
                    f64::from(q[u] - p[u]) * f64::from(y - p[v]) - f64::from(q[v] - p[v]) * f64::from(x - p[u])
                };
                let area = turn(at[0], at[1], at[2][u], at[2][v]);
                if area == 0.0 {
                    continue;
                }
                let low = at[0].min(at[1]).min(at[2]);
                let high = at[0].max(at[1]).max(at[2]);
                for y in low[v].ceil().max(0.0) as usize..=(high[v].max(0.0) as usize).min(self.size[v] - 1) {
                    for x in low[u].ceil().max(0.0) as usize..=(high[u].max(0.0) as usize).min(self.size[u] - 1) {
                        let (fx, fy) = (x as f32, y as f32);
                        let w = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| turn(at[i], at[j], fx, fy) / area);
                        if w.iter().all(|&w| w >= 0.0) {
                            let depth = (0..3).map(|i| w[i] * f64::from(at[i][axis])).sum::<f64>();
                            // Positive area: the outward normal points along +axis.
                            hits.push((y * self.size[u] + x, depth as f32, if area > 0.0 { 1 } else { -1 }));
                        }
                    }
                }
            }
            hits.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
            for column in hits.chunk_by(|a, b| a.0 == b.0) {
                let (x, y) = (column[0].0 % self.size[u], column[0].0 / self.size[u]);
                let all: i32 = column.iter().map(|h| h.2).sum();
                let (mut next, mut below) = (0, 0);
                for k in 0..self.size[axis] {
                    while next < column.len() && column[next].1 <= k as f32 {
                        below += column[next].2;
                        next += 1;
                    }
                    let mut c = [0; 3];
                    (c[axis], c[u], c[v]) = (k, x, y);
                    let index = self.flat(c);
                    // Forward ray leaves through +1 crossings ahead; backward ray through −1 crossings behind.
                    winding[index] += (all - below) - below;
                    if up_axis == Some(axis) && (if up[axis] > 0.0 { next == column.len() } else { next == 0 }) {
                        sky[index] = true;
                    }
                }
            }
        }
        (winding, sky)
    }

    /// Cells that a flood from the grid's border reaches without passing a wall.
    fn flood(&self, walls: &[bool]) -> Vec<bool> {
        let mut reached = vec![false; walls.len()];
        let mut stack: Vec<usize> = (0..walls.len())
            .filter(|&i| {
                let c = self.unflat(i);
                !walls[i] && (0..3).any(|a| c[a] == 0 || c[a] + 1 == self.size[a])
            })
            .collect();
        stack.iter().for_each(|&i| reached[i] = true);
        while let Some(i) = stack.pop() {
            for n in self.neighbours(i) {
                if !walls[n] && !reached[n] {
                    reached[n] = true;
                    stack.push(n);
                }
            }
        }
        reached
    }

    /// Distance of every cell centre to the surface, m.
    fn distances(&self, near: &[f32]) -> Vec<f32> {
        let mut squared: Vec<f32> = near.iter().map(|d| (d / self.cell).powi(2).min(1e12)).collect();
        self.transform(&mut squared);
        squared.into_iter().map(|s| s.sqrt() * self.cell).collect()
    }

    /// Replaces every value f(p) by min over q of |p − q|² + f(q), in cells (Felzenszwalb and Huttenlocher 2012).
    fn transform(&self, values: &mut [f32]) {
        for axis in 0..3 {
            let length = self.size[axis];
            let stride: usize = self.order.iter().take_while(|o| **o != axis).map(|&o| self.size[o]).product();
            let mut line = vec![0.0; length];
            for start in (0..values.len()).filter(|i| (i / stride).is_multiple_of(length)) {
                for (k, value) in line.iter_mut().enumerate() {
                    *value = values[start + k * stride];
                }
                for (k, value) in lower_envelope(&line).into_iter().enumerate() {
                    values[start + k * stride] = value;
                }
            }
        }
    }

    /// Takes hollows behind narrow entrances out of the free space.
    ///
    /// The widest way from outside to a cell has a clearance at its narrowest point; where the cell itself has much
    /// more room than that, it and the ball of room around it are a closed hollow.
    fn close_narrow(&mut self, distance: &[f32]) {
        let mut widest = vec![0.0_f32; self.free.len()];
        let mut queue: BinaryHeap<(u32, usize)> = BinaryHeap::new();
        for i in 0..self.free.len() {
            let c = self.unflat(i);
            if self.free[i] && (0..3).any(|a| c[a] == 0 || c[a] + 1 == self.size[a]) {
                widest[i] = distance[i];
                // Distances are not negative: their bits are in the same order.
                queue.push((distance[i].to_bits(), i));
            }
        }
        while let Some((bits, i)) = queue.pop() {
            let way = f32::from_bits(bits);
            if way < widest[i] {
                continue;
            }
            let next: Vec<usize> = self.neighbours(i).filter(|&n| self.free[n]).collect();
            for n in next {
                let through = way.min(distance[n]);
                if through > widest[n] {
                    widest[n] = through;
                    queue.push((through.to_bits(), n));
                }
            }
        }
        // Below two cells an entrance is not resolved.
        let closed = |i: usize| self.free[i] && distance[i] > 2.0 * self.cell && widest[i] < ENTRANCE * distance[i];
        let mut room: Vec<f32> =
            (0..widest.len()).map(|i| if closed(i) { -(distance[i] / self.cell).powi(2) } else { 1e12 }).collect();
        if room.iter().any(|r| *r < 0.0) {
            self.transform(&mut room);
            for (free, room) in self.free.iter_mut().zip(room) {
                *free &= room > 0.0;
            }
        }
    }

    /// For every cell whether some of the surface lies below it.
    fn things_below(&self, near: &[f32], up: Vec3) -> Vec<bool> {
        let mut below = vec![false; near.len()];
        let Some(axis) = (0..3).find(|&i| up[i].abs() > 0.5) else {
            return below;
        };
        let length = self.size[axis];
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for x in 0..self.size[u] {
            for y in 0..self.size[v] {
                let mut met = false;
                for k in 0..length {
                    let mut c = [0; 3];
                    (c[axis], c[u], c[v]) = (if up[axis] > 0.0 { k } else { length - 1 - k }, x, y);
                    let i = self.flat(c);
                    below[i] = met;
                    met |= near[i].is_finite();
                }
            }
        }
        below
    }

    fn sum_columns(&mut self, distance: &[f32]) {
        let length = self.size[self.order[0]];
        for column in 0..distance.len() / length {
            let (mut bulge, mut open) = (0.0, 0.0);
            self.bulge.push(bulge);
            self.open.push(open);
            for (i, d) in distance.iter().enumerate().skip(column * length).take(length) {
                if self.free[i] {
                    bulge += (d - UNSEEN * self.cell).max(0.0) * if self.above[i] { ABOVE } else { 1.0 };
                    open += 1.0;
                }
                self.bulge.push(bulge);
                self.open.push(open);
            }
        }
    }
}

/// Value of running sums at a fractional cell.
fn interpolate(sums: &[f32], at: f32) -> f32 {
    let whole = at as usize;
    let rest = at - whole as f32;
    if rest > 0.0 { sums[whole] + rest * (sums[whole + 1] - sums[whole]) } else { sums[whole] }
}

/// min over q of (p − q)² + f(q), for every p.
fn lower_envelope(f: &[f32]) -> Vec<f32> {
    let meet = |p: usize, q: usize| {
        let (fp, fq) = (f64::from(f[p]) + (p * p) as f64, f64::from(f[q]) + (q * q) as f64);
        (fq - fp) / (2.0 * (q as f64 - p as f64))
    };
    let mut roots: Vec<(usize, f64)> = vec![(0, f64::NEG_INFINITY)];
    for q in 1..f.len() {
        while let Some(&(p, start)) = roots.last() {
            let s = meet(p, q);
            if s > start {
                roots.push((q, s));
                break;
            }
            roots.pop();
        }
        if roots.is_empty() {
            roots.push((q, f64::NEG_INFINITY));
        }
    }
    let mut k = 0;
    (0..f.len())
        .map(|p| {
            while k + 1 < roots.len() && roots[k + 1].1 <= p as f64 {
                k += 1;
            }
            let q = roots[k].0;
            (p as f32 - q as f32).powi(2) + f[q]
        })
        .collect()
}
