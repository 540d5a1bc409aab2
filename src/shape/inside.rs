//! Whether a point is inside a mesh, closed or not: generalized winding numbers.

use super::tolerances::inside::{FAR, INSIDE, LEAF};
use glam::DVec3;
use std::f64::consts::TAU;

/// A mesh that can be asked what is inside it.
///
/// The winding number counts how often the surface goes around a point: 0 outside and 1 inside a closed mesh, and
/// something between where holes are, so that scanned and generated meshes need not be closed (Jacobson et al. 2013).
/// Far clusters of triangles are taken as dipoles (Barill et al. 2018, "Fast winding numbers for soups and clouds",
/// first order), so that a query costs the logarithm of their number.
pub struct Inside {
    triangles: Vec<[DVec3; 3]>,
    nodes: Vec<Node>,
}

/// A cluster of triangles: a range of them and its dipole.
struct Node {
    first: u32,
    count: u32,
    /// The node after this one and all below it; children come right after their parent.
    skip: u32,
    center: DVec3,
    radius: f64,
    /// Sum of the triangles' areas times normals, m².
    dipole: DVec3,
}

impl Inside {
    /// Of triangles that all have their outside on the same side, m.
    pub fn new(mut triangles: Vec<[DVec3; 3]>) -> Self {
        let mut nodes = Vec::with_capacity(2 * triangles.len() / LEAF + 1);
        if !triangles.is_empty() {
            build(&mut triangles, 0, &mut nodes);
        }
        Self { triangles, nodes }
    }

    /// True if the surface goes around `point`, one way or the other.
    pub fn contains(&self, point: DVec3) -> bool {
        self.winding(point).abs() > INSIDE
    }

    fn winding(&self, point: DVec3) -> f64 {
        let mut angle = 0.0;
        let mut next = 0;
        while let Some(node) = self.nodes.get(next) {
            let away = node.center - point;
            let distance = away.length();
            if distance > FAR * node.radius {
                angle += node.dipole.dot(away) / (distance * distance * distance);
                next = node.skip as usize;
            } else {
                if node.skip as usize == next + 1 {
                    let range = node.first as usize..(node.first + node.count) as usize;
                    angle += self.triangles[range].iter().map(|t| solid_angle(t.map(|p| p - point))).sum::<f64>();
                }
                next += 1;
            }
        }
        angle / (2.0 * TAU)
    }
}

/// Adds the tree over `triangles`, of which `first` come before: halved at the median along the longest side.
fn build(triangles: &mut [[DVec3; 3]], first: usize, nodes: &mut Vec<Node>) {
    let mut area = 0.0;
    let (mut center, mut dipole) = (DVec3::ZERO, DVec3::ZERO);
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for triangle in &*triangles {
        let [a, b, c] = *triangle;
        let normal = 0.5 * (b - a).cross(c - a);
        area += normal.length();
        dipole += normal;
        center += normal.length() * middle(triangle);
        (low, high) = (low.min(middle(triangle)), high.max(middle(triangle)));
    }
    let center = if area > 0.0 { center / area } else { 0.5 * (low + high) };
    let radius = triangles.iter().flatten().map(|p| p.distance_squared(center)).fold(0.0, f64::max).sqrt();
    let own = nodes.len();
    nodes.push(Node { first: first as u32, count: triangles.len() as u32, skip: 0, center, radius, dipole });
    if triangles.len() > LEAF {
        let axis = (high - low).max_position();
        let half = triangles.len() / 2;
        triangles.select_nth_unstable_by(half, |s, t| middle(s)[axis].total_cmp(&middle(t)[axis]));
        let (left, right) = triangles.split_at_mut(half);
        build(left, first, nodes);
        build(right, first + half, nodes);
    }
    nodes[own].skip = nodes.len() as u32;
}

fn middle([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (*a + *b + *c) / 3.0
}

/// Signed solid angle of a triangle seen from the origin, sr (van Oosterom and Strackee 1983).
fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    2.0 * a.dot(b.cross(c)).atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of radius 1 m of `rings` · 2 `rings` quads, without its cap above `open`.
    fn ball(rings: usize, open: f64) -> Vec<[DVec3; 3]> {
        let at = |i: usize, j: usize| {
            let (polar, around) = (TAU / 2.0 * i as f64 / rings as f64, TAU / 2.0 * j as f64 / rings as f64);
            DVec3::new(polar.sin() * around.cos(), polar.cos(), -polar.sin() * around.sin())
        };
        let quads = (0..rings).flat_map(|i| (0..2 * rings).map(move |j| (i, j)));
        let triangles = quads.flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        });
        triangles.filter(|t| middle(t).y < open).collect()
    }

    #[test]
    fn tells_inside_from_outside() {
        for flip in [false, true] {
            let mut triangles = ball(40, 2.0);
            if flip {
                triangles.iter_mut().for_each(|t| t.swap(0, 1));
            }
            let inside = Inside::new(triangles);
            for k in 0..200 {
                let direction =
                    DVec3::new((k as f64).sin(), (1.7 * k as f64).cos(), (0.3 * k as f64).sin()).normalize();
                assert!(inside.contains(0.98 * direction), "{direction}");
                assert!(!inside.contains(1.02 * direction), "{direction}");
            }
        }
    }

    #[test]
    fn dipoles_are_near_the_exact_sum() {
        let triangles = ball(40, 0.9);
        let inside = Inside::new(triangles.clone());
        for k in 0..100 {
            let point = 1.5 * DVec3::new((k as f64).sin(), (1.7 * k as f64).cos(), (0.3 * k as f64).sin());
            let exact = triangles.iter().map(|t| solid_angle(t.map(|p| p - point))).sum::<f64>() / (2.0 * TAU);
            assert!((inside.winding(point) - exact).abs() < 0.02, "{point}: {} and {exact}", inside.winding(point));
        }
    }

    #[test]
    fn a_hole_leaves_the_middle_inside() {
        let inside = Inside::new(ball(40, 0.9));
        assert!(inside.contains(DVec3::ZERO) && !inside.contains(DVec3::Y) && !inside.contains(2.0 * DVec3::Y));
    }

    #[test]
    fn nothing_is_inside_nothing() {
        assert!(!Inside::new(Vec::new()).contains(DVec3::ZERO));
        assert!(!Inside::new(vec![[DVec3::ONE; 3]; 20]).contains(DVec3::ZERO));
    }
}
