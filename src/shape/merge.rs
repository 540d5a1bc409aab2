//! Bottom-up: joins pieces until the budget is met, always the two whose common hull adds the least bulge.
//!
//! Then pieces change sides as long as that lowers the total (the greedy order is not the best one).

use super::hull::{Hull, directions};
use super::solid::Solid;
use super::split::{Piece, outline};
use glam::Vec3;

/// Sweeps in which every piece may change to another part.
const SWEEPS: usize = 3;

/// A set of pieces that shares one hull.
struct Group {
    members: Vec<usize>,
    bulge: f32,
}

/// Distributes the pieces over at most `budget` groups; pairs that add less than `free` (m⁴) are joined in any case.
/// Returns the member numbers of every group and the sum of their bulges (m⁴).
pub(super) fn merge(pieces: &[Piece], solid: &Solid, budget: usize, free: f32) -> (Vec<Vec<usize>>, f32) {
    let probes = directions(58);
    let points: Vec<Vec<Vec3>> = pieces.iter().map(|p| outline(&p.hull, &probes)).collect();
    let bulge = |members: &mut dyn Iterator<Item = usize>| {
        let all: Vec<Vec3> = members.flat_map(|m| points[m].iter().copied()).collect();
        Hull::coarse(&all, &probes).map_or(f32::INFINITY, |h| solid.protrusion(&h).0)
    };
    let mut groups: Vec<Option<Group>> =
        (0..pieces.len()).map(|i| Some(Group { members: vec![i], bulge: bulge(&mut std::iter::once(i)) })).collect();
    let joined = |a: &Group, b: &Group| bulge(&mut a.members.iter().chain(&b.members).copied());
    // cost[i][j], i > j: what joining adds.
    let mut cost: Vec<Vec<f32>> = (0..groups.len())
        .map(|i| {
            (0..i)
                .map(|j| match (&groups[i], &groups[j]) {
                    (Some(a), Some(b)) => joined(a, b) - a.bulge - b.bulge,
                    _ => f32::INFINITY,
                })
                .collect()
        })
        .collect();
    let mut left = groups.len();
    while left > 1 {
        let mut best = (f32::INFINITY, 0, 0);
        for (i, row) in cost.iter().enumerate() {
            for (j, &c) in row.iter().enumerate() {
                if c < best.0 {
                    best = (c, i, j);
                }
            }
        }
        let (added, i, j) = best;
        if !added.is_finite() || (left <= budget && added > free) {
            break;
        }
        let (Some(a), Some(b)) = (groups[i].take(), groups[j].take()) else {
            break;
        };
        let bulge = added + a.bulge + b.bulge;
        groups[j] = Some(Group { members: [b.members, a.members].concat(), bulge });
        left -= 1;
        for k in 0..groups.len() {
            cost[i].iter_mut().for_each(|c| *c = f32::INFINITY);
            if k > i {
                cost[k][i] = f32::INFINITY;
            }
            if k != j
                && let (Some(a), Some(b)) = (&groups[j], &groups[k])
            {
                let added = joined(a, b) - a.bulge - b.bulge;
                cost[j.max(k)][j.min(k)] = added;
            }
        }
    }
    let mut groups: Vec<Group> = groups.into_iter().flatten().collect();
    for _ in 0..SWEEPS {
        if !exchange(&mut groups, &bulge) {
            break;
        }
    }
    let total = groups.iter().map(|g| g.bulge).sum();
    (groups.into_iter().map(|g| g.members).collect(), total)
}

/// Moves every piece to the group where it lowers the total most. False if nothing moved.
fn exchange(groups: &mut [Group], bulge: &dyn Fn(&mut dyn Iterator<Item = usize>) -> f32) -> bool {
    let mut moved = false;
    for from in 0..groups.len() {
        let mut at = 0;
        while at < groups[from].members.len() && groups[from].members.len() > 1 {
            let piece = groups[from].members[at];
            let without = bulge(&mut groups[from].members.iter().copied().filter(|&m| m != piece));
            let saved = groups[from].bulge - without;
            let mut best = (0.0, from, 0.0);
            if saved > 0.0 {
                for (to, group) in groups.iter().enumerate() {
                    if to != from {
                        let with = bulge(&mut group.members.iter().copied().chain([piece]));
                        let gain = saved - (with - group.bulge);
                        if gain > best.0 {
                            best = (gain, to, with);
                        }
                    }
                }
            }
            let (gain, to, with) = best;
            if to != from && gain > 1e-3 * groups[from].bulge {
                groups[from].members.remove(at);
                groups[from].bulge = without;
                groups[to].members.push(piece);
                groups[to].bulge = with;
                moved = true;
            } else {
                at += 1;
            }
        }
    }
    moved
}
