//! The ground and the walls as polygons.

use crate::scene::{Room, Wall};
use glam::DVec3;

/// How far a wall goes beyond the objects, share of the scene's half extent.
const BEYOND: f64 = 0.12;
/// Share of the scene's points below the ground from which on it cannot be the ground that they stand on.
const SUNK: f64 = 0.3;

/// Height at which the ground is drawn: 0, or under the scene where too much of it would be hidden, as it is before a
/// reconstruction is turned upright.
pub fn floor_height(points: &[DVec3]) -> f64 {
    let sunk = points.iter().filter(|p| p.y < -0.02).count();
    if (sunk as f64) < SUNK * points.len() as f64 {
        return 0.0;
    }
    points.iter().map(|p| p.y).fold(f64::INFINITY, f64::min)
}

/// The part of each wall that is beside the scene (given by its box), counter-clockwise seen from inside the room.
pub fn walls(room: &Room, [low, high]: [DVec3; 2], floor: f64) -> Vec<Vec<DVec3>> {
    let beyond = BEYOND * 0.5 * (high - low).length();
    let (low, high) = (low - beyond, high + beyond);
    let ceiling = room.ceiling.unwrap_or(high.y).max(high.y - beyond);
    let polygon = |(number, wall): (usize, &Wall)| {
        let n = wall.normal;
        let across = DVec3::Y.cross(n).try_normalize()?;
        let up = n.cross(across);
        let middle = 0.5 * (low + high);
        let middle = middle - n * n.dot(middle - wall.point);
        let reach = (high - low).length();
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let mut polygon: Vec<DVec3> = corners.map(|[x, y]| middle + across * (x * reach) + up * (y * reach)).into();
        let mut cut = |point: DVec3, normal: DVec3| polygon = clipped(&polygon, point, normal);
        cut(DVec3::Y * floor, DVec3::Y);
        cut(DVec3::Y * ceiling, DVec3::NEG_Y);
        for (other, wall) in room.walls.iter().enumerate() {
            if other != number {
                cut(wall.point, wall.normal);
            }
        }
        // A wall far from the objects stays as far as its neighbours reach; without them it ends beside the objects.
        for axis in [DVec3::X, DVec3::Z] {
            if n.dot(axis).abs() < 0.5 {
                cut(low.min(wall.point), axis);
                cut(high.max(wall.point), -axis);
            }
        }
        (polygon.len() >= 3).then_some(polygon)
    };
    room.walls.iter().enumerate().filter_map(polygon).collect()
}

/// The part of a convex polygon on the inner side of a plane.
fn clipped(polygon: &[DVec3], point: DVec3, normal: DVec3) -> Vec<DVec3> {
    let mut out = Vec::with_capacity(polygon.len() + 1);
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (from, to) = (normal.dot(a - point), normal.dot(b - point));
        if from >= 0.0 {
            out.push(a);
        }
        if (from < 0.0) != (to < 0.0) {
            out.push(a.lerp(b, from / (from - to)));
        }
    }
    out
}
