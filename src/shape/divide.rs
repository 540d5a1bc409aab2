//! Cuts hulls of too many vertices into several of fewer, so that none of their surface is lost.
//!
//! A part that somebody made is what they want to be simulated. A ball of which only 64 of 642 corners are kept is
//! smaller by a twentieth and lies on other facets.

use super::hull::{Hull, plane_sides};
use super::tolerances::divide::MOST_PIECES;
use glam::Vec3;

/// Pieces of `hull`, with at most so many vertices each as far as `MOST_PIECES` allow.
pub(super) fn divide(hull: Hull, vertices: usize) -> Vec<Hull> {
    let mut pieces = vec![hull];
    let mut done = 0;
    while done < pieces.len() {
        let size = pieces[done].vertices.len();
        let halves = if size > vertices && pieces.len() < MOST_PIECES { best_cut(&pieces[done]) } else { None };
        match halves.filter(|[one, other]| one.vertices.len().max(other.vertices.len()) < size) {
            Some([one, other]) => {
                pieces[done] = one;
                pieces.push(other);
            }
            None => done += 1,
        }
    }
    pieces
}

/// The halves of a hull, cut along the axis that leaves the larger one fewest vertices.
fn best_cut(hull: &Hull) -> Option<[Hull; 2]> {
    let cuts = Vec3::AXES.into_iter().filter_map(|axis| match cut(hull, axis) {
        [Some(one), Some(other)] => Some([one, other]),
        _ => None,
    });
    cuts.min_by_key(|[one, other]| one.vertices.len().max(other.vertices.len()))
}

/// The two sides of a hull, cut across the middle of its extent along `axis`.
fn cut(hull: &Hull, axis: Vec3) -> [Option<Hull>; 2] {
    let (low, high) = hull.bounds();
    let (below, above) = plane_sides(&hull.vertices, &hull.edges(), axis, axis.dot(0.5 * (low + high)));
    [Hull::new(&below), Hull::new(&above)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A can of 128 sides and a ball of 642 corners: all corners are still there, and the volume.
    #[test]
    fn pieces_have_few_vertices_and_all_of_the_surface() {
        let can = (0..256).map(|i| {
            let (sin, cos) = (std::f32::consts::TAU * (i / 2) as f32 / 128.0).sin_cos();
            Vec3::new(0.05 * cos, 0.1 * (i % 2) as f32, 0.05 * sin)
        });
        let ball = (0..642).map(|i| {
            let y = 1.0 - (i as f32 + 0.5) / 321.0;
            let (sin, cos) = (2.399_963_2 * i as f32).sin_cos();
            0.1 * Vec3::new(cos * (1.0 - y * y).sqrt(), y, sin * (1.0 - y * y).sqrt())
        });
        for points in [can.collect::<Vec<_>>(), ball.collect()] {
            let whole = Hull::new(&points).expect("the points span a hull");
            let pieces = divide(whole.clone(), 64);
            assert!(pieces.iter().all(|piece| piece.vertices.len() <= 64));
            assert!(pieces.len() < MOST_PIECES, "{}", pieces.len());
            let volume: f32 = pieces.iter().map(Hull::volume).sum();
            assert!((volume / whole.volume() - 1.0).abs() < 1e-4, "{volume} {}", whole.volume());
            let kept = |v: &Vec3| pieces.iter().any(|piece| piece.vertices.iter().any(|p| p.distance(*v) < 1e-6));
            assert!(whole.vertices.iter().all(kept));
        }
    }
}
