//! Chooses the few of many contact points that support a body as well as all of them.

use super::MAX_MANIFOLD_POINTS;
use crate::world::constants::{
    BEARING_HEIGHT, LANDING_PENALTY, RESTING_PENALTY, ROLLING_PENALTY, SAME_POINT, SAME_RESTING_POINT,
};
use glam::{Vec2, Vec3, Vec4};

/// Directions in which the farthest point is kept, four at a time (x, y): unit vectors at equal angles, turned so that
/// neither boxes nor regular polygons are aligned with them.
const DIRECTIONS: [[Vec4; 2]; MAX_MANIFOLD_POINTS / 4] = [
    [Vec4::new(0.955_336, 0.466_559, -0.295_520, -0.884_490), Vec4::new(0.295_520, 0.884_490, 0.955_336, 0.466_559)],
    [
        Vec4::new(-0.955_336, -0.466_559, 0.295_520, 0.884_490),
        Vec4::new(-0.295_520, -0.884_490, -0.955_336, -0.466_559),
    ],
];

/// Chosen points, as indices into what was offered.
#[derive(Clone, Copy, Debug, Default)]
pub struct Selection {
    count: usize,
    indices: [u16; MAX_MANIFOLD_POINTS],
}

impl Selection {
    /// The indices: what was found in the first round, counter-clockwise against the normal, then what completes its
    /// polygon, then the other rounds, each counter-clockwise.
    pub fn indices(&self) -> &[u16] {
        &self.indices[..self.count]
    }

    fn is_full(&self) -> bool {
        self.count == MAX_MANIFOLD_POINTS
    }

    fn push(&mut self, index: u16) {
        self.indices[self.count] = index;
        self.count += 1;
    }
}

/// The polygon on which a body rests, across the normal, counter-clockwise.
#[derive(Default)]
struct SupportPolygon {
    count: usize,
    corners: [Vec2; MAX_MANIFOLD_POINTS],
}

impl SupportPolygon {
    /// Adds a corner as number `at`.
    fn insert(&mut self, at: usize, corner: Vec2) {
        self.corners.copy_within(at..self.count, at + 1);
        self.corners[at] = corner;
        self.count += 1;
    }

    /// How far a point is beyond the polygon, m, and beside which edge: 0 unless it is beside one.
    fn beyond(&self, p: Vec2) -> (f32, usize) {
        let mut most = (0.0, 0);
        for k in 0..self.count {
            let next = if k + 1 < self.count { k + 1 } else { 0 };
            let (apart, edge) = (p - self.corners[k], self.corners[next] - self.corners[k]);
            let (along, square) = (apart.dot(edge), edge.length_squared());
            let beyond = if along > 0.0 && along < square { apart.perp_dot(edge) / square.sqrt() } else { 0.0 };
            if beyond > most.0 {
                most = (beyond, k);
            }
        }
        most
    }
}

/// Chooses at most `MAX_MANIFOLD_POINTS` of `count` points, each given as position and separation (m): the farthest one
/// across `normal` in each of as many fixed directions, three times. The first round finds what a body rests on and
/// counts a point as nearer by `RESTING_PENALTY` times its height above the deepest. If there are places left, whatever
/// bears farthest beyond the polygon of these gets them, one after the other: a blunt corner, or the edge of a table
/// between the two places where a plate's rim crosses it, may be the farthest in no direction. What places are
/// left after that go to what the body may roll onto, where height costs only `ROLLING_PENALTY`, then to what it may
/// land on (`LANDING_PENALTY`).
///
/// Directions and preferences are fixed, so that the same points are kept in the same order from step to step and keep
/// their impulses. Points closer than `SAME_POINT` are one, in the first round closer than `SAME_RESTING_POINT`.
pub fn reduce(count: usize, point: impl Fn(usize) -> (Vec3, f32), normal: Vec3) -> Selection {
    let mut chosen = Selection::default();
    if count == 0 {
        return chosen;
    }
    let [u, v] = tangents(normal);
    let flat = |p: Vec3| Vec2::new(u.dot(p), v.dot(p));
    let deepest = (0..count).map(|i| point(i).1).fold(f32::INFINITY, f32::min);
    // The numbers of the farthest points of a round in which a height above the deepest costs `penalty`.
    let farthest = |penalty: fn(f32) -> f32, same: f32| {
        let mut farthest = [[Vec4::NEG_INFINITY, Vec4::ZERO]; DIRECTIONS.len()];
        for i in 0..count {
            let (p, separation) = point(i);
            let (Vec2 { x, y }, penalty) = (flat(p), penalty(separation - deepest));
            for ([across, along], [reach, number]) in DIRECTIONS.into_iter().zip(&mut farthest) {
                let distance = across * x + along * y - penalty;
                let farther = distance.cmpgt(*reach + same);
                *reach = Vec4::select(farther, distance, *reach);
                *number = Vec4::select(farther, Vec4::splat(i as f32), *number);
            }
        }
        farthest.into_iter().flat_map(|[_, numbers]| numbers.to_array()).map(|i| i as u16)
    };
    let is_new = |chosen: &Selection, index: u16, same: f32| {
        let p = point(index as usize).0;
        let near = |&kept: &u16| kept == index || point(kept as usize).0.distance_squared(p) < same * same;
        !chosen.is_full() && !chosen.indices().iter().any(near)
    };
    let mut support = SupportPolygon::default();
    for index in farthest(|height| RESTING_PENALTY * (height - BEARING_HEIGHT).max(0.0), SAME_RESTING_POINT) {
        if is_new(&chosen, index, SAME_RESTING_POINT) {
            chosen.push(index);
            support.insert(support.count, flat(point(index as usize).0));
        }
    }
    while !chosen.is_full() && chosen.count < count {
        let (mut most, mut found) = (0.0, None);
        for i in (0..count).filter(|&i| point(i).1 - deepest <= BEARING_HEIGHT) {
            let (beyond, edge) = support.beyond(flat(point(i).0));
            if beyond > most + SAME_RESTING_POINT {
                (most, found) = (beyond, Some((i, edge)));
            }
        }
        let Some((i, edge)) = found.filter(|&(i, _)| is_new(&chosen, i as u16, SAME_RESTING_POINT)) else { break };
        chosen.push(i as u16);
        support.insert(edge + 1, flat(point(i).0));
    }
    for penalty in [|height| ROLLING_PENALTY * height, |height| LANDING_PENALTY * height] {
        if chosen.is_full() || chosen.count == count {
            break;
        }
        for index in farthest(penalty, SAME_POINT) {
            if is_new(&chosen, index, SAME_POINT) {
                chosen.push(index);
            }
        }
    }
    chosen
}

/// Two unit vectors that make a right-handed frame with `normal`. Unlike the common branch-free formula it has no jump
/// at upright normals, where most contacts are.
pub fn tangents(normal: Vec3) -> [Vec3; 2] {
    let side = if normal.x.abs() < 0.8 { Vec3::X } else { Vec3::Z };
    let u = (side - normal * normal.dot(side)).normalize();
    [u, normal.cross(u)]
}
