//! Convex hulls of points that may be very thin, or many of them in one plane.

use super::tolerances::convex_hull::{OFF, OFF_SHAKEN, SHAKE, SHAKES};
use glam::{DVec3, Vec3};
use parry3d::shape::ConvexPolyhedron;
use parry3d::transformation::try_convex_hull;

/// The fractional parts of the multiples of this are spread evenly over the unit cube (Roberts's R3 sequence).
const SCATTER: DVec3 = DVec3::new(0.819_172_513_396_2, 0.671_043_606_703_8, 0.549_700_477_901_97);

/// Corners and outward triangles of a hull.
pub(super) type HullMesh = (Vec<Vec3>, Vec<[u32; 3]>);

/// Corners and outward triangles of the convex hull; `None` for points without volume.
///
/// parry's hull takes a plate whose thickness is a thousandth of its length for a flat polygon. A linear map keeps
/// convexity, so the hull is taken of points whose covariance has been made the identity.
pub fn convex_hull(points: &[Vec3]) -> Option<HullMesh> {
    let mean = points.iter().map(|p| p.as_dvec3()).sum::<DVec3>() / points.len().max(1) as f64;
    let mut covariance = [[0.0; 3]; 3];
    for d in points.iter().map(|p| (p.as_dvec3() - mean).to_array()) {
        for (i, row) in covariance.iter_mut().enumerate() {
            (0..3).for_each(|j| row[j] += d[i] * d[j] / points.len() as f64);
        }
    }
    // Cholesky: covariance = L Lᵀ. Below f32's resolution there is no volume.
    let mut l = [[0.0; 3]; 3];
    let flat = (f64::from(f32::EPSILON) * f64::from(points.iter().map(|p| p.length()).fold(0.0, f32::max))).powi(2);
    for i in 0..3 {
        for j in 0..=i {
            let rest = covariance[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            if i == j && (rest <= flat || rest.is_nan()) {
                return None;
            }
            l[i][j] = if i == j { rest.sqrt() } else { rest / l[j][j] };
        }
    }
    let white: Vec<Vec3> = points
        .iter()
        .map(|p| {
            let d = p.as_dvec3() - mean;
            let x = d.x / l[0][0];
            let y = (d.y - l[1][0] * x) / l[1][1];
            let z = (d.z - l[2][0] * x - l[2][1] * y) / l[2][2];
            DVec3::new(x, y, z).as_vec3()
        })
        .collect();
    let (vertices, triangles) = sound_hull(&white).or_else(|| try_convex_hull(&white).ok())?;
    let vertices = originals(&vertices, &white, points)?;
    (vertices.len() >= 4 && triangles.len() >= 4).then_some((vertices, triangles))
}

/// parry's hull of points, if it is right. Where many points lie in one plane its triangles fold over, or leave corners
/// out, now and then: a piece of a round foot has lost 7 % of its volume. Points that are shaken a little lie in no
/// plane.
pub(super) fn sound_hull(points: &[Vec3]) -> Option<HullMesh> {
    let plain = try_convex_hull(points).ok().filter(|hull| is_sound(hull, points, OFF));
    let shaken = |round| shaken_hull(points, round).filter(|hull| is_sound(hull, points, OFF_SHAKEN));
    plain.or_else(|| (0..SHAKES).find_map(shaken))
}

/// True if parry makes a right hull of points as they are: so does what uses it.
pub(super) fn suits_parry(points: &[Vec3]) -> bool {
    let is_right = || try_convex_hull(points).is_ok_and(|hull| is_sound(&hull, points, OFF));
    is_right() && ConvexPolyhedron::from_convex_hull(points).is_some()
}

fn shaken_hull(points: &[Vec3], round: usize) -> Option<HullMesh> {
    let size = points.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
    let shaken = |(i, p): (usize, &Vec3)| {
        let noise = ((i * SHAKES + round) as f64 * SCATTER).fract() - 0.5;
        (p.as_dvec3() + SHAKE * f64::from(size) * noise).as_vec3()
    };
    let shaken: Vec<Vec3> = points.iter().enumerate().map(shaken).collect();
    let (vertices, triangles) = try_convex_hull(&shaken).ok()?;
    Some((originals(&vertices, &shaken, points)?, triangles))
}

/// The points that became these vertices when they were moved.
fn originals(vertices: &[Vec3], moved: &[Vec3], points: &[Vec3]) -> Option<Vec<Vec3>> {
    vertices.iter().map(|v| moved.iter().position(|m| m == v).map(|i| points[i])).collect()
}

/// True if no point lies above a triangle, and the triangles close. What is above counts as the tetrahedron between
/// triangle and farthest point: so much may the volume be off. The normals of a closed surface, times its areas, add up
/// to nothing.
fn is_sound((vertices, triangles): &HullMesh, points: &[Vec3], share: f64) -> bool {
    let origin = vertices.first().copied().unwrap_or_default().as_dvec3();
    let (mut volume, mut above, mut area, mut gap) = (0.0, 0.0, 0.0, DVec3::ZERO);
    for t in triangles {
        let [a, b, c] = t.map(|i| vertices[i as usize].as_dvec3());
        let normal = (b - a).cross(c - a);
        let height = normal.dot(a);
        volume += height - normal.dot(origin);
        above += points.iter().map(|p| normal.dot(p.as_dvec3()) - height).fold(0.0, f64::max);
        area += normal.length();
        gap += normal;
    }
    above <= share * volume && gap.length() <= share * area
}

#[cfg(test)]
mod tests {
    use super::super::{
        hull::{box_corners, solid_hull},
        split::clip,
    };
    use super::*;
    use glam::Vec2;
    use std::f32::consts::TAU;

    /// Feet of lamps, and their halves: many points in one plane, several of them in one line.
    fn feet() -> impl Iterator<Item = (HullMesh, [Vec<Vec3>; 2])> {
        (0..500).map(|n| {
            let corner = |radius: f32, i: usize| radius * Vec2::from_angle(TAU * i as f32 / 16.0 + 0.3);
            let ring = |radius: f32, y: f32| {
                let corners = (0..16).map(move |i| corner(radius, i));
                corners.map(move |p| Vec3::new(p.x, y, p.y)).collect::<Vec<_>>()
            };
            let radius = 0.1 + 4e-4 * n as f32;
            let points = [ring(radius, 0.0), ring(0.9 * radius, 0.02), ring(0.01, 0.04)].concat();
            let foot = try_convex_hull(&points).expect("a foot has a hull");
            let triangles: Vec<[Vec3; 3]> = foot.1.iter().map(|t| t.map(|i| foot.0[i as usize])).collect();
            let across = corner(radius, n % 8 + 8) - corner(radius, n % 8);
            let normal = Vec3::new(-across.y, 3e-7 * n as f32, across.x).normalize();
            let halves = clip(&triangles, normal, normal.dot(points[n % 8]));
            (foot, halves.map(|side| merged(side.as_flattened())))
        })
    }

    /// The points, one for each cell of a fine grid.
    fn merged(points: &[Vec3]) -> Vec<Vec3> {
        let cell = |p: &Vec3| (p * 5e6).round().to_array().map(|c| c as i64);
        let mut points = points.to_vec();
        points.sort_by_key(cell);
        points.dedup_by_key(|p| cell(p));
        points
    }

    fn volume((vertices, triangles): &HullMesh) -> f64 {
        let corner = |i: u32| vertices[i as usize].as_dvec3();
        triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))) / 6.0).sum()
    }

    /// Of how many feet the halves' hulls hold more or less than the foot, by a per mille and more.
    fn wrong(hull: impl Fn(&[Vec3]) -> Option<HullMesh>) -> usize {
        let sum =
            |halves: &[Vec<Vec3>; 2]| halves.iter().map(|half| hull(half).map_or(0.0, |h| volume(&h))).sum::<f64>();
        feet().filter(|(foot, halves)| (sum(halves) / volume(foot) - 1.0).abs() > 1e-3).count()
    }

    #[test]
    fn halves_hold_what_the_whole_held() {
        assert!(
            wrong(|points| try_convex_hull(points).ok()) > 20,
            "parry's hulls are right: these points show nothing"
        );
        assert_eq!((wrong(convex_hull), wrong(solid_hull)), (0, 0));
    }

    /// The eight corners of a cube, and the same as triangles of all sides but one, or of all but one corner.
    #[test]
    fn a_hull_with_a_hole_or_without_a_corner_is_not_sound() {
        let corners: Vec<Vec3> =
            (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32)).collect();
        let (vertices, triangles) = try_convex_hull(&corners).expect("a cube has a hull");
        assert!(is_sound(&(vertices.clone(), triangles.clone()), &corners, OFF_SHAKEN));
        assert!(!is_sound(&(vertices, triangles[1..].to_vec()), &corners, OFF));
        let without = try_convex_hull(&corners[1..]).expect("seven corners have a hull");
        assert!(is_sound(&without, &corners[1..], OFF_SHAKEN) && !is_sound(&without, &corners, OFF));
    }

    /// A plate of 2 m and 1.9 mm, and a rod of 2 m and 2 mm, turned out of their axes: rounding alone is not wrong.
    #[test]
    fn thin_plates_and_rods_are_sound() {
        let turn = glam::Quat::from_euler(glam::EulerRot::XYZ, 0.3, 0.7, 1.1);
        for size in [Vec3::new(2.0, 1.9e-3, 2.0), Vec3::new(2.0, 2e-3, 2e-3)] {
            let points: Vec<Vec3> = box_corners(0.5 * size).into_iter().map(|corner| turn * corner).collect();
            let hull = convex_hull(&points).expect("it has a hull");
            assert!(is_sound(&hull, &points, OFF), "{size}");
            assert!((volume(&hull) / f64::from(size.element_product()) - 1.0).abs() < 1e-3, "{size}");
        }
    }

    /// Plates of 2 m and 1.9 mm with many points in either face, turned out of their axes.
    #[test]
    fn thin_plates_keep_their_volume() {
        for (across, turn) in (2..14).flat_map(|across| (0..20).map(move |turn| (across, turn as f32))) {
            let size = Vec3::new(2.0, 1.9e-3, 2.0);
            let along = 2 + turn as usize % 13;
            let turn = glam::Quat::from_euler(glam::EulerRot::XYZ, 0.3 * turn, 0.7 + 0.1 * turn, 0.37 * turn);
            let rows = (0..=across).flat_map(|i| (0..=along).flat_map(move |k| [(i, 0.0, k), (i, 1.0, k)]));
            let at = |(i, y, k)| Vec3::new(i as f32 / across as f32, y, k as f32 / along as f32) - 0.5;
            let points: Vec<Vec3> = rows.map(|row| turn * (size * at(row))).collect();
            let hull = solid_hull(&points).expect("a plate has a hull");
            let off = (volume(&hull) / f64::from(size.element_product()) - 1.0).abs();
            assert!(off < 1e-3, "{across} by {along}, {turn}: off by {off}");
        }
    }
}
