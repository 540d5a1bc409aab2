//! Faces that bear have four corners.
//!
//! parry, and Rapier with it, makes the contacts of a face from the first four corners of its outline, wherever these
//! are: a foot with rounded ends stands on one of them there, and a desk falls over. So a part is cut until what is
//! left of the outline of the face that bears has no more than four corners, and corners that hardly matter go.

use super::Part;
use super::convex_hull::suits_parry;
use super::hull::Hull;
use super::split::clip;
use super::tolerances::corners::{
    ASIDE, BEYOND, CUTS, ENOUGH, FACING, LEAST, MOST, PIECES, SIDE, TRIES, VERTICES, WHOLE,
};
use glam::{Vec2, Vec3};
use parry3d::shape::ConvexPolyhedron;

/// The part as pieces whose faces `towards` these directions (unit vectors, the part's frame) have at most four
/// corners, as far as three cuts in a row and eight pieces allow. The part itself where they have.
pub fn four_cornered(part: &Part, towards: &[Vec3]) -> Vec<Part> {
    let mut pieces = vec![part.vertices.clone()];
    for &direction in towards {
        let cut: Vec<Vec<Vec3>> = pieces.iter().flat_map(|piece| faced(piece.clone(), direction, CUTS)).collect();
        if cut.len() <= PIECES {
            pieces = cut;
        }
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
        let (area, quad) = best_quad(&seen);
        let enough = area >= ENOUGH * polygon_area(&seen) && given_up(&seen, quad) <= ASIDE;
        if enough && is_borne(&outline, quad.map(|i| outline[i]), direction) {
            let stays = |vertex: &Vec3| !outline.contains(vertex) || quad.iter().any(|&i| outline[i] == *vertex);
            let left: Vec<Vec3> = vertices.iter().copied().filter(stays).collect();
            // An outline of slivers can come to the same corner twice.
            if left.len() < vertices.len() && suits_parry(&left) {
                vertices = left;
                continue;
            }
        }
        let whole = Hull::new(&vertices).filter(|_| cuts > 0);
        let cut = |[i, k]: [usize; 2]| {
            let normal = direction.cross(outline[k] - outline[i]).normalize_or_zero();
            halves(whole.as_ref()?, normal, normal.dot(outline[i]))
        };
        return match across(&seen).into_iter().take(TRIES).find_map(cut) {
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

/// Four corners of a convex polygon outside which the others lie least far: for each diagonal the farthest corner on
/// either side is looked at. And the area between them.
fn best_quad(corners: &[Vec2]) -> (f32, [usize; MOST]) {
    let count = corners.len();
    let mut best = (f32::INFINITY, 0.0, [0, 1, 2, 3]);
    for i in 0..count {
        for k in i + 2..count {
            let farthest = |range: &mut dyn Iterator<Item = usize>| {
                let height = |j: &usize| (corners[k] - corners[i]).perp_dot(corners[*j] - corners[i]).abs();
                range.map(|j| (height(&j), j)).max_by(|a, b| a.0.total_cmp(&b.0))
            };
            let sides = (farthest(&mut (i + 1..k)), farthest(&mut (k + 1..count).chain(0..i)));
            if let (Some((one, j)), Some((two, l))) = sides {
                let aside = given_up(corners, [i, j, k, l]);
                if aside < best.0 {
                    best = (aside, 0.5 * (one + two), [i, j, k, l]);
                }
            }
        }
    }
    (best.1, best.2)
}

/// How far the corners of a convex polygon lie outside four of them, m.
fn given_up(corners: &[Vec2], quad: [usize; MOST]) -> f32 {
    let count = corners.len();
    let edges = (0..MOST).map(|k| (quad[k], quad[(k + 1) % MOST]));
    let between = edges.flat_map(|(a, b)| {
        let along = (corners[b] - corners[a]).normalize_or_zero();
        let skipped = (1..(b + count - a) % count).map(move |k| (a + k) % count);
        skipped.map(move |c| along.perp_dot(corners[c] - corners[a]).abs())
    });
    between.fold(0.0, f32::max)
}

/// True if no corner of an outline reaches beyond the plane of four of them, so that what stands on it stands on these.
fn is_borne(outline: &[Vec3], [a, b, c, d]: [Vec3; MOST], direction: Vec3) -> bool {
    let normal = (c - a).cross(d - b).normalize_or_zero();
    let outward = if normal.dot(direction) < 0.0 { -normal } else { normal };
    let plane = [a, b, c, d].map(|corner| outward.dot(corner)).into_iter().fold(f32::NEG_INFINITY, f32::max);
    outline.iter().all(|corner| outward.dot(*corner) <= plane + BEYOND)
}

/// The diagonals of a convex polygon: first those that have enough of it on either side, by how evenly they part its
/// corners and by their length; then the others, by what they have on their smaller side.
fn across(corners: &[Vec2]) -> Vec<[usize; 2]> {
    let count = corners.len();
    let whole = polygon_area(corners);
    let diagonal = |[i, k]: [usize; 2]| {
        let side = polygon_area(&corners[i..=k]);
        let smaller = side.min(whole - side);
        let uneven = (2 * (k - i)).abs_diff(count) as f32;
        // Up to six corners an even cut is the last.
        let is_short = count > 2 * (MOST - 1) && smaller < SIDE * whole;
        let rank = if is_short { [-smaller, 0.0] } else { [uneven, corners[i].distance(corners[k])] };
        (is_short, rank, [i, k])
    };
    let diagonals = (0..count).flat_map(|i| (i + 2..count.min(i + count - 1)).map(move |k| [i, k])).map(diagonal);
    let better = |a: &(bool, [f32; 2], _), b: &(bool, [f32; 2], _)| {
        a.0.cmp(&b.0).then(a.1[0].total_cmp(&b.1[0])).then(a.1[1].total_cmp(&b.1[1]))
    };
    let mut diagonals: Vec<_> = diagonals.collect();
    diagonals.sort_by(better);
    diagonals.into_iter().map(|(.., ends)| ends).collect()
}

/// The vertices on both sides of a plane, if that leaves two solids of which parry makes right hulls.
fn halves(whole: &Hull, normal: Vec3, offset: f32) -> Option<[Vec<Vec3>; 2]> {
    let triangles: Vec<[Vec3; 3]> = whole.triangles.iter().map(|t| t.map(|i| whole.vertices[i as usize])).collect();
    let [one, two] = clip(&triangles, normal, offset).map(|side| Hull::new(side.as_flattened()));
    let (one, two) = (one?, two?);
    let lost = (one.volume() + two.volume() - whole.volume()).abs();
    let large = |half: &Hull| half.volume() >= LEAST * whole.volume() && half.vertices.len() <= VERTICES;
    let good = |half: &Hull| large(half) && suits_parry(&half.vertices);
    (lost <= WHOLE * whole.volume() && good(&one) && good(&two)).then_some([one.vertices, two.vertices])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::array::uniform3;
    use proptest::collection::vec;
    use proptest::prelude::*;
    use proptest::sample::Index;
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
        for (foot, most) in [(round(6), 2), (round(16), 8), (round(32), 8), (rounded(), 2)] {
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
    fn a_foot_with_most_corners_at_one_end_is_cut_across() {
        let end = (0..13).map(|i| Vec2::new(0.2, 0.0) + 0.02 * Vec2::from_angle(TAU * (i as f32 / 24.0 - 0.25)));
        let round = (1..8).map(|i| 0.1 * Vec2::from_angle(TAU * (0.25 + i as f32 / 16.0)));
        let foot: Vec<Vec2> = end.chain(round).collect();
        let [i, k] = across(&foot)[0];
        let side = polygon_area(&foot[i..=k]) / polygon_area(&foot);
        assert!((SIDE..1.0 - SIDE).contains(&side), "{side} on one side");
        assert!(four_cornered(&post(&foot), &[Vec3::NEG_Y]).len() > 1);
    }

    #[test]
    fn feet_of_lamps_become_pieces_of_four_whatever_rounding_does() {
        // Foot and lower pole of a lamp, tilted by less than a minute of arc.
        let ring = |radius: f32, sides: usize, turn: f32, y: f32| {
            let around = move |i| radius * Vec2::from_angle(TAU * i as f32 / sides as f32 + turn);
            (0..sides).map(around).map(move |corner| Vec3::new(corner.x, y, corner.y))
        };
        // Cut at the first diagonal, the last two leave pieces of which parry makes no hull.
        let corners = (0..20_000).step_by(70).chain([9626, 16651]).map(|n| {
            let (radius, tilt) = (0.1 + 1e-5 * n as f32, 1e-7 * n as f32);
            let foot = ring(radius, 16, 0.3, 0.0).chain(ring(0.9 * radius, 16, 0.3, 0.02));
            let lamp = foot.chain(ring(0.01, 5, 0.0, 0.04));
            let direction = Vec3::new(0.3 * tilt, -1.0, tilt).normalize();
            faces(&four_cornered(&Part { vertices: lamp.collect() }, &[direction]), direction).1
        });
        let corners: Vec<usize> = corners.collect();
        let more = corners.iter().filter(|corners| **corners > MOST).count();
        assert!(corners.iter().all(|corners| *corners <= MOST + 1) && more <= 3, "{more} feet with more: {corners:?}");
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

    proptest! {
        /// Clouds of points, flat ones among them, and faces of theirs that bear.
        #[test]
        fn any_part_becomes_pieces_of_what_it_was(
            points in vec(uniform3(-1.0_f32..1.0), 5..64),
            size in uniform3(0.01_f32..1.0),
            faces in vec(any::<Index>(), 1..4),
        ) {
            let points: Vec<Vec3> = points.into_iter().map(|p| Vec3::from(p) * Vec3::from(size)).collect();
            let whole = Hull::new(&points).unwrap();
            let part = Part { vertices: whole.vertices.clone() };
            let towards: Vec<Vec3> = faces.iter().map(|face| face.get(&whole.planes).truncate()).collect();
            let pieces = four_cornered(&part, &towards);
            prop_assert!(pieces.len() <= PIECES && pieces.iter().all(|piece| piece.vertices.len() <= VERTICES));
            let hulls: Vec<Hull> = pieces.iter().map(|piece| Hull::new(&piece.vertices).unwrap()).collect();
            for vertex in hulls.iter().flat_map(|hull| &hull.vertices) {
                prop_assert!(whole.excess(*vertex) < 1e-5, "{vertex} lies outside");
            }
            let volume: f32 = hulls.iter().map(Hull::volume).sum();
            prop_assert!(volume <= 1.01 * whole.volume(), "{volume} m³ of {}", whole.volume());
            prop_assert!(volume >= 0.5 * whole.volume(), "{volume} m³ of {}", whole.volume());
        }
    }

    #[test]
    fn the_lowest_corner_stays() {
        for lowest in 0..20 {
            let mut part = post(&rounded());
            part.vertices[lowest].y = -0.1e-3;
            let lows = |parts: &[Part]| parts.iter().flat_map(|part| &part.vertices).map(|v| v.y).fold(0.0, f32::min);
            let pieces = four_cornered(&part, &[Vec3::NEG_Y]);
            assert!((lows(&pieces) - lows(&[part])).abs() <= BEYOND, "corner {lowest}");
        }
    }

    #[test]
    fn the_best_quad_of_an_octagon_is_a_square() {
        let (area, mut quad) = best_quad(&round(8));
        quad.sort_unstable();
        assert!((area - 2.0 * 0.05 * 0.05).abs() < 1e-7, "{area} m²");
        assert!(quad == [0, 2, 4, 6] || quad == [1, 3, 5, 7], "{quad:?}");
    }
}
