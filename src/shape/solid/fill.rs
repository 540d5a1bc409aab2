//! Fills the grid: surface, winding numbers, flood, distances, narrow hollows.

use super::Solid;
use crate::shape::tolerances::fill::{ABOVE, ENTRANCE, UNSEEN};
use glam::Vec3;
use parry3d::query::PointQuery;
use parry3d::shape::Triangle;
use std::collections::BinaryHeap;

impl Solid {
    /// Distance of the cell centre to the triangles that touch the cell, m; infinite for all other cells.
    pub(super) fn near_surface(&self, triangles: &[[Vec3; 3]]) -> Vec<f32> {
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
    pub(super) fn crossings(&self, triangles: &[[Vec3; 3]], up: Vec3) -> (Vec<i32>, Vec<bool>) {
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
    pub(super) fn flood(&self, walls: &[bool]) -> Vec<bool> {
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
    pub(super) fn distances(&self, near: &[f32]) -> Vec<f32> {
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
    pub(super) fn close_narrow(&mut self, distance: &[f32]) {
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
    pub(super) fn things_below(&self, near: &[f32], up: Vec3) -> Vec<bool> {
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

    pub(super) fn sum_columns(&mut self, distance: &[f32]) {
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
