//! Triangles on a raster of pixels, for whoever draws on the processor.

use super::Size;
use glam::{DVec2, DVec3, DVec4};
use std::ops::Range;

/// A triangle on the raster: x to the right and y down in pixels, z as the depth is counted, linear on the raster.
#[derive(Clone, Copy, Debug)]
pub struct Screen(pub [DVec3; 3]);

/// The parts of a triangle in clip space, as of `Camera::clip`, that are not too near, handed to `keep`: up to two.
pub fn project(corners: [DVec4; 3], near: f64, size: Size, mut keep: impl FnMut(Screen)) {
    let place = |c: DVec4| {
        let x = (0.5 + 0.5 * c.x / c.w) * f64::from(size.width);
        let y = (0.5 - 0.5 * c.y / c.w) * f64::from(size.height);
        DVec3::new(x, y, near / c.w)
    };
    if corners.iter().all(|c| c.w >= near) {
        return keep(Screen(corners.map(place)));
    }
    let mut kept = Vec::with_capacity(4);
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % 3];
        if a.w >= near {
            kept.push(place(a));
        }
        if (a.w >= near) != (b.w >= near) {
            kept.push(place(a.lerp(b, (near - a.w) / (b.w - a.w))));
        }
    }
    for i in 2..kept.len() {
        keep(Screen([kept[0], kept[i - 1], kept[i]]));
    }
}

impl Screen {
    /// Rows of pixels that it may touch, of `height`.
    pub fn rows(&self, height: u32) -> Range<u32> {
        pixels(self.0.map(|p| p.y), height)
    }

    /// Calls `hit` with column, row, sample and depth for every sample inside. `samples` are places in a pixel, from
    /// 0 to 1 across and down.
    pub fn scan(&self, rows: Range<u32>, width: u32, samples: &[DVec2], mut hit: impl FnMut(u32, u32, usize, f32)) {
        let [a, b, c] = self.0;
        let area = (b - a).truncate().perp_dot((c - a).truncate());
        if area == 0.0 || !area.is_finite() {
            return;
        }
        // Share of a corner at (x, y) is its edge · (x, y, 1); the three shares add up to 1.
        let edge = |p: DVec3, q: DVec3| DVec3::new(p.y - q.y, q.x - p.x, p.x * q.y - p.y * q.x) / area;
        let edges = [edge(b, c), edge(c, a), edge(a, b)];
        let depth = edges[0] * a.z + edges[1] * b.z + edges[2] * c.z;
        // Most triangles are small: looking for their edges in each row would cost more than it saves.
        let all = pixels(self.0.map(|p| p.x), width);
        let small = all.len() <= 4;
        for y in rows {
            for x in if small { all.clone() } else { self.span(y, width) } {
                for (number, sample) in samples.iter().enumerate() {
                    let at = DVec3::new(f64::from(x) + sample.x, f64::from(y) + sample.y, 1.0);
                    if edges.iter().all(|edge| edge.dot(at) >= 0.0) {
                        hit(x, y, number, depth.dot(at) as f32);
                    }
                }
            }
        }
    }

    /// Columns that it may touch in a row: those of its edges there.
    fn span(&self, y: u32, width: u32) -> Range<u32> {
        let (top, bottom) = (f64::from(y), f64::from(y) + 1.0);
        let mut xs = [f64::INFINITY, f64::NEG_INFINITY];
        let mut take = |x: f64| xs = [xs[0].min(x), xs[1].max(x)];
        for i in 0..3 {
            let (p, q) = (self.0[i], self.0[(i + 1) % 3]);
            if p.y >= top && p.y <= bottom {
                take(p.x);
            }
            for line in [top, bottom] {
                if (p.y < line) != (q.y < line) {
                    take(p.x + (line - p.y) / (q.y - p.y) * (q.x - p.x));
                }
            }
        }
        pixels(xs, width)
    }
}

/// The pixels between the least and the greatest of some places.
fn pixels<const N: usize>(places: [f64; N], count: u32) -> Range<u32> {
    let low = places.iter().copied().fold(f64::INFINITY, f64::min).clamp(0.0, f64::from(count)) as u32;
    let high = places.iter().copied().fold(f64::NEG_INFINITY, f64::max).clamp(0.0, f64::from(count));
    // Rounded up, without the call that older processors need for it.
    let last = high as u32 + u32::from(high > f64::from(high as u32));
    low..last.max(low)
}
