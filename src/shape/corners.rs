//! Faces that bear have four corners.
//!
//! parry, and Rapier with it, makes the contacts of a face from the first four corners of its outline, wherever these are: a
//! foot with rounded ends stands on one of them there, and a desk falls over. So a part is cut until what is left of the
//! outline of the face that bears has no more than four corners, and corners that hardly matter go.

use super::Part;
use super::hull::Hull;
use super::split::clip;
use glam::{Vec2, Vec3};
use parry3d::shape::ConvexPolyhedron;

/// Most corners of a face of which all engines make contacts.
const MOST: usize = 4;
/// A face is the one that bears if it lies that near to the direction (cosine, 11°).
const FACING: f32 = 0.98;
/// Four corners are enough if they hold this share of the outline: of an octagon a quarter does, which leaves it its corners.
const ENOUGH: f32 = 0.8;
/// Corners that are given up reach beyond the four by no more than this, m.
const BEYOND: f32 = 0.02e-3;
/// So often is a part cut in two.
const CUTS: u32 = 3;
/// The pieces of a part hold all of it but for this share.
const WHOLE: f32 = 1e-3;

/// The part as pieces whose faces `towards` these directions (unit vectors, the part's frame) have at most four corners, as
/// far as three cuts in a row allow. The part itself where they have.
pub fn four_cornered(part: &Part, towards: &[Vec3]) -> Vec<Part> {
    let mut pieces = vec![part.vertices.clone()];
    for &direction in towards {
        pieces = pieces.into_iter().flat_map(|piece| faced(piece, direction, CUTS)).collect();
    }
    pieces.into_iter().map(|vertices| Part { vertices }).collect()
}

fn faced(mut vertices: Vec<Vec3>, direction: Vec3, cuts: u32) -> Vec<Vec<Vec3>> {
    let (u, v) = direction.any_orthonormal_pair();
    loop {
        let Some(outline) = outline(&vertices, direction).filter(|outline| outline.len() > MOST) else {
            return vec![vertices];
        };
        let seen: Vec<Vec2> = outline.iter().map(|corner| Vec2::new(u.dot(*corner), v.dot(*corner))).collect();
        let (area, quad) = largest_quad(&seen);
        if area >= ENOUGH * polygon_area(&seen) && is_borne(&outline, quad.map(|i| outline[i]), direction) {
            vertices.retain(|vertex| !outline.contains(vertex) || quad.iter().any(|&i| outline[i] == *vertex));
            continue;
        }
        let along = widest(&seen);
        let ends = seen.iter().map(|corner| along.dot(*corner));
        let (low, high) =
            ends.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), end| (low.min(end), high.max(end)));
        let middle = 0.5 * (low + high);
        return match halves(&vertices, u * along.x + v * along.y, middle).filter(|_| cuts > 0) {
            Some(halves) => halves.into_iter().flat_map(|half| faced(half, direction, cuts - 1)).collect(),
            None => vec![vertices],
        };
    }
}

/// Corners, in turn, of the face that lies nearest to the direction, if it lies near enough.
fn outline(vertices: &[Vec3], direction: Vec3) -> Option<Vec<Vec3>> {
    let solid = ConvexPolyhedron::from_convex_hull(vertices)?;
    let facing = solid.faces().iter().map(|face| (face.normal.dot(direction), face));
    let (along, face) = facing.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let corners = &solid.vertices_adj_to_face()[face.first_vertex_or_edge as usize..];
    let corners = corners[..face.num_vertices_or_edges as usize].iter().map(|&i| solid.points()[i as usize]);
    (along > FACING).then(|| corners.collect())
}

fn polygon_area(corners: &[Vec2]) -> f32 {
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    0.5 * edges.map(|(a, b)| (*a - corners[0]).perp_dot(*b - corners[0])).sum::<f32>().abs()
}

/// The four corners that hold most of a convex polygon, and how much: for each diagonal the farthest corner on either side.
fn largest_quad(corners: &[Vec2]) -> (f32, [usize; MOST]) {
    let count = corners.len();
    let mut best = (0.0, [0, 1, 2, 3]);
    for i in 0..count {
        for k in i + 2..count {
            let farthest = |range: &mut dyn Iterator<Item = usize>| {
                let height = |j: &usize| (corners[k] - corners[i]).perp_dot(corners[*j] - corners[i]).abs();
                range.map(|j| (height(&j), j)).max_by(|a, b| a.0.total_cmp(&b.0))
            };
            let sides = (farthest(&mut (i + 1..k)), farthest(&mut (k + 1..count).chain(0..i)));
            if let (Some((one, j)), Some((two, l))) = sides
                && 0.5 * (one + two) > best.0
            {
                best = (0.5 * (one + two), [i, j, k, l]);
            }
        }
    }
    best
}

/// True if no corner of an outline reaches beyond the plane of four of them, so that what stands on it stands on these.
fn is_borne(outline: &[Vec3], [a, b, c, d]: [Vec3; MOST], direction: Vec3) -> bool {
    let normal = (c - a).cross(d - b).normalize_or_zero();
    let outward = if normal.dot(direction) < 0.0 { -normal } else { normal };
    let plane = [a, b, c, d].map(|corner| outward.dot(corner)).into_iter().fold(f32::NEG_INFINITY, f32::max);
    outline.iter().all(|corner| outward.dot(*corner) <= plane + BEYOND)
}

/// The direction along which points spread most: the principal axis of their covariance.
fn widest(points: &[Vec2]) -> Vec2 {
    let mean = points.iter().sum::<Vec2>() / points.len() as f32;
    let [xx, xy, yy] = points.iter().fold([0.0; 3], |[xx, xy, yy], point| {
        let d = *point - mean;
        [xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y]
    });
    let half = Vec2::new(0.5 * (xx - yy), xy);
    // Of the two forms of the eigenvector the one that does not cancel.
    let axis = if half.x > 0.0 {
        Vec2::new(half.x + half.length(), half.y)
    } else {
        Vec2::new(half.y, half.length() - half.x)
    };
    axis.try_normalize().unwrap_or(Vec2::X)
}

/// The vertices on both sides of a plane, if that leaves two solids.
fn halves(vertices: &[Vec3], normal: Vec3, offset: f32) -> Option<[Vec<Vec3>; 2]> {
    let whole = Hull::new(vertices)?;
    let triangles: Vec<[Vec3; 3]> = whole.triangles.iter().map(|t| t.map(|i| whole.vertices[i as usize])).collect();
    let [one, two] = clip(&triangles, normal, offset).map(|side| Hull::new(side.as_flattened()));
    let (one, two) = (one?, two?);
    let lost = (one.volume() + two.volume() - whole.volume()).abs();
    (lost <= WHOLE * whole.volume()).then_some([one.vertices, two.vertices])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::f32::consts::TAU;

    /// A post of 10 cm whose foot has these corners.
    fn post(foot: &[Vec2]) -> Part {
        let ring = |y: f32| foot.iter().map(move |corner| Vec3::new(corner.x, y, corner.y));
        Part { vertices: ring(0.0).chain(ring(0.1)).collect() }
    }

    fn round(sides: usize) -> Vec<Vec2> {
        (0..sides).map(|i| 0.05 * Vec2::from_angle(TAU * i as f32 / sides as f32)).collect()
    }

    /// 20 by 4 cm, with corners of four small edges each.
    fn rounded() -> Vec<Vec2> {
        let corner = |k: usize| {
            let middle =
                [Vec2::new(0.09, 0.01), Vec2::new(-0.09, 0.01), Vec2::new(-0.09, -0.01), Vec2::new(0.09, -0.01)][k];
            (0..5).map(move |i| middle + 0.01 * Vec2::from_angle(TAU * (k as f32 + i as f32 / 4.0) / 4.0))
        };
        (0..4).flat_map(corner).collect()
    }

    /// Area of the faces of pieces towards a direction, and the corners of the one that has most.
    fn faces(pieces: &[Part], direction: Vec3) -> (f32, usize) {
        let (u, v) = direction.any_orthonormal_pair();
        let outlines: Vec<Vec<Vec3>> =
            pieces.iter().map(|piece| outline(&piece.vertices, direction).unwrap()).collect();
        let seen = |outline: &Vec<Vec3>| outline.iter().map(|p| Vec2::new(u.dot(*p), v.dot(*p))).collect::<Vec<_>>();
        let area = outlines.iter().map(|outline| polygon_area(&seen(outline))).sum();
        (area, outlines.iter().map(Vec::len).max().unwrap())
    }

    #[test]
    fn a_foot_of_many_corners_becomes_pieces_of_four_within_it() {
        for (foot, most) in [(round(6), 2), (round(16), 4), (round(32), 8), (rounded(), 1)] {
            let part = post(&foot);
            let whole = Hull::new(&part.vertices).unwrap();
            let pieces = four_cornered(&part, &[Vec3::NEG_Y, Vec3::Y]);
            assert!(pieces.len() <= most, "{} pieces of {} corners", pieces.len(), foot.len());
            for direction in [Vec3::NEG_Y, Vec3::Y] {
                let ((before, _), (area, corners)) =
                    (faces(std::slice::from_ref(&part), direction), faces(&pieces, direction));
                assert!(corners <= MOST, "{corners} corners of {}", foot.len());
                assert!(area <= 1.0001 * before && area >= ENOUGH * before, "{area} m² of {before}");
            }
            for vertex in pieces.iter().flat_map(|piece| &piece.vertices) {
                assert!(whole.excess(*vertex) < 1e-6, "{vertex} lies outside");
            }
        }
    }

    #[test]
    fn what_has_four_corners_or_a_point_stays() {
        let brick = post(&[Vec2::ZERO, Vec2::new(0.1, 0.0), Vec2::new(0.1, 0.06), Vec2::new(0.0, 0.06)]);
        assert_eq!(four_cornered(&brick, &[Vec3::NEG_Y, Vec3::X]), [brick]);
        let tip = [Vec3::NEG_Y * 0.1];
        let cone = Part { vertices: post(&round(12)).vertices.into_iter().filter(|v| v.y > 0.0).chain(tip).collect() };
        assert_eq!(four_cornered(&cone, &[Vec3::NEG_Y]), std::slice::from_ref(&cone), "nothing flat is below");
        assert_eq!(four_cornered(&cone, &[]), [cone], "it bears nowhere");
    }

    #[test]
    fn the_largest_quad_of_an_octagon_is_a_square() {
        let (area, mut quad) = largest_quad(&round(8));
        quad.sort_unstable();
        assert!((area - 2.0 * 0.05 * 0.05).abs() < 1e-7, "{area} m²");
        assert!(quad == [0, 2, 4, 6] || quad == [1, 3, 5, 7], "{quad:?}");
    }
}
