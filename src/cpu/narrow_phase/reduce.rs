//! Chooses the few of many contact points that support a body as well as all of them.

use super::MAX_MANIFOLD_POINTS;
use crate::world::constants::{
    BEARING_HEIGHT, LANDING_PENALTY, RESTING_PENALTY, ROLLING_PENALTY, SAME_POINT, SAME_RESTING_POINT,
};
use glam::{Vec3, Vec4};

/// Directions in which the farthest point is kept, four at a time (x, y): unit vectors at equal angles, turned so that
/// neither boxes nor regular polygons are aligned with them.
const DIRECTIONS: [[Vec4; 2]; MAX_MANIFOLD_POINTS / 4] = [
    [Vec4::new(0.955_336, 0.466_559, -0.295_520, -0.884_490), Vec4::new(0.295_520, 0.884_490, 0.955_336, 0.466_559)],
    [
        Vec4::new(-0.955_336, -0.466_559, 0.295_520, 0.884_490),
        Vec4::new(-0.295_520, -0.884_490, -0.955_336, -0.466_559),
    ],
];

/// Points of a round that are nearer to each other than this are one, m.
const SAME: [f32; 3] = [SAME_RESTING_POINT, SAME_POINT, SAME_POINT];

/// Chosen points, as indices into what was offered.
#[derive(Clone, Copy, Debug, Default)]
pub struct Selection {
    count: usize,
    indices: [u16; MAX_MANIFOLD_POINTS],
}

impl Selection {
    /// The indices, round after round, each counter-clockwise against the normal.
    pub fn indices(&self) -> &[u16] {
        &self.indices[..self.count]
    }
}

/// Chooses at most `MAX_MANIFOLD_POINTS` of `count` points, each given as position and separation (m): the farthest one
/// across `normal` in each of as many fixed directions, three times. The first round finds what a body rests on and
/// counts a point as nearer by `RESTING_PENALTY` times its height above the deepest; the others fill the places that
/// are left first with what the body may roll onto, where height costs only `ROLLING_PENALTY`, then with what it may
/// land on (`LANDING_PENALTY`). If there are places left after that, whatever else bears gets them: a blunt corner may
/// be the farthest in no direction.
///
/// Directions and preferences are fixed, so that the same points are kept in the same order from step to step and keep
/// their impulses. Points closer than `SAME_POINT` are one, in the first round closer than `SAME_RESTING_POINT`.
pub fn reduce(count: usize, point: impl Fn(usize) -> (Vec3, f32), normal: Vec3) -> Selection {
    let mut chosen = Selection::default();
    if count == 0 {
        return chosen;
    }
    let [u, v] = tangents(normal);
    let deepest = (0..count).map(|i| point(i).1).fold(f32::INFINITY, f32::min);
    // For each round, how far the farthest points reach, and their numbers.
    let mut farthest = [[[Vec4::NEG_INFINITY, Vec4::ZERO]; DIRECTIONS.len()]; 3];
    for i in 0..count {
        let (p, separation) = point(i);
        let (x, y) = (u.dot(p), v.dot(p));
        let height = separation - deepest;
        let resting = RESTING_PENALTY * (height - BEARING_HEIGHT).max(0.0);
        let penalties = [resting, ROLLING_PENALTY * height, LANDING_PENALTY * height];
        for ((penalty, same), round) in penalties.into_iter().zip(SAME).zip(&mut farthest) {
            for ([across, along], [reach, number]) in DIRECTIONS.into_iter().zip(round) {
                let distance = across * x + along * y - penalty;
                let farther = distance.cmpgt(*reach + same);
                *reach = Vec4::select(farther, distance, *reach);
                *number = Vec4::select(farther, Vec4::splat(i as f32), *number);
            }
        }
    }
    let numbers = farthest.into_iter().zip(SAME).flat_map(|(round, same)| {
        round.into_iter().flat_map(|[_, number]| number.to_array()).map(move |number| (number as u16, same))
    });
    let bearing = (0..count).filter(|&i| point(i).1 - deepest <= BEARING_HEIGHT).map(|i| (i as u16, SAME_POINT));
    for (index, same) in numbers.chain(bearing) {
        if chosen.count == MAX_MANIFOLD_POINTS {
            break;
        }
        let p = point(index as usize).0;
        let near = |&kept: &u16| kept == index || point(kept as usize).0.distance_squared(p) < same * same;
        if !chosen.indices().iter().any(near) {
            chosen.indices[chosen.count] = index;
            chosen.count += 1;
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
