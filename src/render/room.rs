//! The ground and the walls as polygons.

use crate::scene::{Room, Wall};
use glam::DVec3;

/// Walls farther from the middle than this times the objects' half extent end beside the objects.
const MEETING: f64 = 2.0;
/// How far a wall goes beyond the objects, share of the scene's half extent.
const BEYOND: f64 = 0.12;
/// Share of the objects wholly below the ground, by more than `DEEP` (m), from which on it cannot be the ground that
/// they stand on.
const BURIED: f64 = 0.2;
const DEEP: f64 = 0.02;

/// Height at which the ground is drawn: 0, or under the objects (given by their boxes) where too many would be hidden,
/// as it is before a reconstruction is turned upright. Single ones that are sunk or lost stay so.
pub fn floor_height<'a>(boxes: impl Iterator<Item = &'a [DVec3; 2]> + Clone) -> f64 {
    let buried = boxes.clone().filter(|[_, high]| high.y < -DEEP).count();
    if (buried as f64) <= BURIED * boxes.clone().count() as f64 {
        return 0.0;
    }
    boxes.map(|[low, _]| low.y).fold(f64::INFINITY, f64::min)
}

/// The part of each wall that is beside the scene (given by its box), counter-clockwise seen from inside the room.
pub fn walls(room: &Room, [low, high]: [DVec3; 2], floor: f64) -> Vec<Vec<DVec3>> {
    let beyond = BEYOND * 0.5 * (high - low).length();
    let middle = 0.5 * (low + high);
    let (mut low, mut high) = (low - beyond, high + beyond);
    // Walls that are not far from the objects meet in the corners of the room.
    for wall in &room.walls {
        let foot = middle - wall.normal * wall.normal.dot(middle - wall.point);
        if foot.distance(middle) < MEETING * 0.5 * (high - low).length() {
            (low, high) = (low.min(foot), high.max(foot));
        }
    }
    let ceiling = room.ceiling.unwrap_or(high.y).max(high.y - beyond);
    let polygon = |(number, wall): (usize, &Wall)| {
        let n = wall.normal;
        let across = DVec3::Y.cross(n).try_normalize()?;
        let up = n.cross(across);
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
        // Where it has no neighbour, it ends beside the objects.
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
