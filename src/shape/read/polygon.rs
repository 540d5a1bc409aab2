//! Faces of more than three corners. Modelling programs write concave ones, too, such as the cap of an L-shaped prism.

use earcut::Earcut;
use glam::{DVec3, Vec3};

/// The triangles of a polygon, by the numbers of its corners and turned as it is: a fan around the first corner if it is
/// convex or has no area, else ears cut off the polygon as it is seen along its mean normal (M. Newell's). Fewer than
/// three corners give nothing.
pub(super) fn triangles(polygon: &[Vec3]) -> Vec<[usize; 3]> {
    let as_fan = || fan(polygon.len()).collect();
    if polygon.len() < 4 {
        return as_fan();
    }
    let corners: Vec<DVec3> = polygon.iter().map(|corner| (corner - polygon[0]).as_dvec3()).collect();
    let next = |i: usize| corners[(i + 1) % corners.len()];
    let area: DVec3 = (0..corners.len()).map(|i| corners[i].cross(next(i))).sum();
    let Some(normal) = area.try_normalize() else { return as_fan() };
    let sides = |i: usize| [next(i) - corners[i], next(i + 1) - next(i)];
    let turns = |[a, b]: [DVec3; 2]| a.cross(b).dot(normal) >= -STRAIGHT * a.length() * b.length();
    if (0..corners.len()).map(sides).all(turns) {
        return as_fan();
    }
    let (u, v) = normal.any_orthonormal_pair();
    let seen: Vec<[f64; 2]> = corners.iter().map(|corner| [corner.dot(u), corner.dot(v)]).collect();
    let mut cut: Vec<usize> = Vec::new();
    Earcut::new().earcut(seen, &[], &mut cut);
    let as_turned = |&[a, b, c]: &[usize; 3]| {
        let turned = (corners[b] - corners[a]).cross(corners[c] - corners[a]).dot(normal) < 0.0;
        if turned { [a, c, b] } else { [a, b, c] }
    };
    cut.as_chunks().0.iter().map(as_turned).collect()
}

/// The triangles around the first of so many corners.
pub(super) fn fan(corners: usize) -> impl Iterator<Item = [usize; 3]> {
    (2..corners).map(|last| [0, last - 1, last])
}

/// A corner that bends inwards by less than this is straight (sine of an angle).
const STRAIGHT: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn flat(corners: &[[f32; 2]]) -> Vec<Vec3> {
        corners.iter().map(|&[x, z]| Vec3::new(x, 0.3 * x, z)).collect()
    }

    fn area(polygon: &[Vec3], triangle: [usize; 3]) -> Vec3 {
        let [a, b, c] = triangle.map(|i| polygon[i]);
        0.5 * (b - a).cross(c - a)
    }

    #[test]
    fn a_convex_polygon_is_a_fan() {
        let square = flat(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 1.0], [0.0, 1.0]]);
        assert_eq!(triangles(&square), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        assert_eq!(triangles(&square[..2]), [[0; 3]; 0]);
        assert_eq!(triangles(&[Vec3::ONE; 4]).len(), 2, "without area");
        assert_eq!(triangles(&[Vec3::NAN; 4]).len(), 2, "refused later");
    }

    #[test]
    fn a_concave_one_is_filled_whichever_corner_is_the_first() {
        let mut corners = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        for reversed in [false, true] {
            for _ in 0..corners.len() {
                corners.rotate_left(1);
                let polygon = flat(&corners);
                let areas: Vec<Vec3> = triangles(&polygon).into_iter().map(|t| area(&polygon, t)).collect();
                let up = if reversed { 1.0 } else { -1.0 };
                assert!(areas.iter().all(|area| area.y * up > 0.0), "{areas:?}");
                assert!((areas.iter().sum::<Vec3>().y * up - 3.0).abs() < 1e-5, "{areas:?}");
                assert!(areas.len() == 4);
            }
            corners.reverse();
        }
    }

    proptest! {
        /// Stars about a point, of which every corner is seen from there: as large as the sum of their triangles, each
        /// turned as the star is.
        #[test]
        fn stars_are_filled(lengths in prop::collection::vec(0.1_f32..2.0, 4..40), start in 0_usize..40) {
            let turn = std::f32::consts::TAU / lengths.len() as f32;
            let mut polygon: Vec<Vec3> = lengths.iter().enumerate()
                .map(|(i, &length)| length * Vec3::new((i as f32 * turn).cos(), (i as f32 * turn).sin(), 0.0))
                .collect();
            let count = polygon.len();
            polygon.rotate_left(start % count);
            let whole: f32 = (0..count).map(|i| 0.5 * polygon[i].cross(polygon[(i + 1) % count]).z).sum();
            let found = triangles(&polygon);
            let areas: Vec<f32> = found.iter().map(|&t| area(&polygon, t).z).collect();
            prop_assert!(areas.iter().all(|&area| area > -1e-6), "{areas:?}");
            prop_assert!((areas.iter().sum::<f32>() - whole).abs() < 1e-3 * whole, "{areas:?} {whole}");
            prop_assert!(found.len() <= count - 2);
        }
    }
}
