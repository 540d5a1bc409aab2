//! Bottom-up: joins pieces until the budget is met, always the two whose common hull adds the least bulge.
//!
//! Then pieces change sides as long as that lowers the total (the greedy order is not the best one).

use super::hull::{Hull, directions};
use super::solid::Solid;
use super::split::{Piece, outline};
use super::tolerances::merge::SWEEPS;
use glam::Vec3;

/// A set of pieces that shares one hull.
struct Group {
    members: Vec<usize>,
    bulge: f32,
}

/// What merging may cost.
pub(super) struct Limits {
    /// Parts that the category allows.
    pub budget: usize,
    /// Parts beyond the budget that may be used to keep compartments open.
    pub extra: usize,
    /// Merges that add less than this are made in any case, m⁴.
    pub free: f32,
    /// A part beyond the budget has to save this much, m⁴.
    pub compartment: f32,
    /// What a part costs for what it holds beyond its pieces' own hulls, m⁴ for each m³.
    pub shared: f32,
}

/// A distribution of pieces over parts.
pub(super) struct Merged {
    /// Piece numbers of every part.
    pub groups: Vec<Vec<usize>>,
    /// Sum of the parts' bulges, m⁴.
    pub bulge: f32,
    /// A compartment is filled for want of parts.
    pub closed: bool,
}

/// Distributes the pieces over parts.
pub(super) fn merge(pieces: &[Piece], solid: &Solid, limits: &Limits) -> Merged {
    let &Limits { budget, extra, free, compartment, shared } = limits;
    let probes = directions(42);
    let points: Vec<Vec<Vec3>> = pieces.iter().map(|p| outline(&p.hull, &probes)).collect();
    let volumes: Vec<f32> = points.iter().map(|p| Hull::coarse(p, &probes).map_or(0.0, |hull| hull.volume())).collect();
    let bulge = |members: &mut dyn Iterator<Item = usize>| {
        let mut own = 0.0;
        let all: Vec<Vec3> = members.inspect(|&m| own += volumes[m]).flat_map(|m| points[m].iter().copied()).collect();
        let cost = |hull: Hull| solid.protrusion(&hull).0 + shared * (hull.volume() - own).max(0.0);
        Hull::coarse(&all, &probes).map_or(f32::INFINITY, cost)
    };
    let mut groups: Vec<Option<Group>> =
        (0..pieces.len()).map(|i| Some(Group { members: vec![i], bulge: bulge(&mut std::iter::once(i)) })).collect();
    let joined = |a: &Group, b: &Group| bulge(&mut a.members.iter().chain(&b.members).copied());
    // cost[i][j], i > j: what joining adds. Distant pieces are not tried until nothing else is left.
    let near = Near::new(pieces, solid.cell());
    let added = |a: &Group, b: &Group, far: bool| {
        if far || near.groups(a, b) { joined(a, b) - a.bulge - b.bulge } else { f32::INFINITY }
    };
    let all = |groups: &[Option<Group>], far: bool| -> Vec<Vec<f32>> {
        (0..groups.len())
            .map(|i| {
                (0..i)
                    .map(|j| match (&groups[i], &groups[j]) {
                        (Some(a), Some(b)) => added(a, b, far),
                        _ => f32::INFINITY,
                    })
                    .collect()
            })
            .collect()
    };
    let mut cost = all(&groups, false);
    let mut far = false;
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
        let (least, i, j) = best;
        if left <= budget && least > free {
            break;
        }
        if !least.is_finite() {
            if far {
                break;
            }
            far = true;
            cost = all(&groups, far);
            continue;
        }
        let (Some(a), Some(b)) = (groups[i].take(), groups[j].take()) else {
            break;
        };
        let bulge = least + a.bulge + b.bulge;
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
                cost[j.max(k)][j.min(k)] = added(a, b, far);
            }
        }
    }
    let mut groups: Vec<Group> = groups.into_iter().flatten().collect();
    for _ in 0..SWEEPS {
        let moved = exchange(&mut groups, &bulge, &near);
        let regrouped = regroup(&mut groups, &bulge, free);
        if !moved && !regrouped {
            break;
        }
    }
    let closed = loop {
        let halves = groups.iter().enumerate().filter(|(_, g)| g.bulge > compartment).filter_map(|(i, g)| {
            halve(g, &bulge).map(|h| (g.bulge - h[0].bulge - h[1].bulge, i, h)).filter(|h| h.0 > compartment)
        });
        let Some((_, divided, [left, right])) = halves.max_by(|a, b| a.0.total_cmp(&b.0)) else {
            break false;
        };
        if groups.len() >= budget + extra {
            break true;
        }
        groups[divided] = left;
        groups.push(right);
        exchange(&mut groups, &bulge, &near);
    };
    Merged {
        bulge: groups.iter().map(|g| g.bulge).sum(),
        groups: groups.into_iter().map(|g| g.members).collect(),
        closed,
    }
}

/// Which pieces are close to each other.
struct Near(Vec<Vec<bool>>);

impl Near {
    /// Pieces whose boxes are at most four cells apart.
    fn new(pieces: &[Piece], cell: f32) -> Self {
        let boxes: Vec<(Vec3, Vec3)> = pieces.iter().map(|p| p.hull.bounds()).collect();
        let gap = Vec3::splat(4.0 * cell);
        let meet = |a: &(Vec3, Vec3), b: &(Vec3, Vec3)| a.0.cmple(b.1 + gap).all() && b.0.cmple(a.1 + gap).all();
        Self(boxes.iter().map(|a| boxes.iter().map(|b| meet(a, b)).collect()).collect())
    }

    fn piece(&self, piece: usize, group: &Group) -> bool {
        group.members.iter().any(|&m| self.0[piece][m])
    }

    fn groups(&self, a: &Group, b: &Group) -> bool {
        a.members.iter().any(|&m| self.piece(m, b))
    }
}

/// Moves every piece to the group where it lowers the total most. False if nothing moved.
fn exchange(groups: &mut [Group], bulge: &dyn Fn(&mut dyn Iterator<Item = usize>) -> f32, near: &Near) -> bool {
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
                    if to != from && near.piece(piece, group) {
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

/// Joins two groups to divide a third one while that lowers the total. False if it never did.
fn regroup(groups: &mut [Group], bulge: &dyn Fn(&mut dyn Iterator<Item = usize>) -> f32, free: f32) -> bool {
    let mut halves: Vec<Option<[Group; 2]>> = groups.iter().map(|g| halve(g, bulge)).collect();
    let joined = |a: &Group, b: &Group| bulge(&mut a.members.iter().chain(&b.members).copied());
    let mut join: Vec<Vec<f32>> =
        (0..groups.len()).map(|i| (0..i).map(|j| joined(&groups[i], &groups[j])).collect()).collect();
    let mut changed = false;
    for _ in 0..groups.len() {
        let mut best: Option<(f32, usize, usize, usize)> = None;
        for (divided, pair) in halves.iter().enumerate() {
            let Some(pair) = pair else { continue };
            let saved = groups[divided].bulge - pair[0].bulge - pair[1].bulge;
            for i in (0..groups.len()).filter(|i| *i != divided) {
                for j in (0..i).filter(|j| *j != divided) {
                    let gain = saved - (join[i][j] - groups[i].bulge - groups[j].bulge);
                    if gain > free && best.is_none_or(|b| gain > b.0) {
                        best = Some((gain, divided, i, j));
                    }
                }
            }
        }
        let Some((_, divided, i, j)) = best else { break };
        let Some([left, right]) = halves[divided].take() else { break };
        let union = Group { members: [&groups[j].members[..], &groups[i].members[..]].concat(), bulge: join[i][j] };
        for (at, group) in [(divided, left), (j, union), (i, right)] {
            groups[at] = group;
        }
        for at in [divided, i, j] {
            halves[at] = halve(&groups[at], bulge);
            for k in (0..groups.len()).filter(|k| *k != at) {
                join[at.max(k)][at.min(k)] = joined(&groups[at], &groups[k]);
            }
        }
        changed = true;
    }
    changed
}

/// The group as two: grown from the two members that are worst together, each other member where it adds least.
fn halve(group: &Group, bulge: &dyn Fn(&mut dyn Iterator<Item = usize>) -> f32) -> Option<[Group; 2]> {
    let members = &group.members;
    if members.len() < 2 || group.bulge <= 0.0 {
        return None;
    }
    let alone: Vec<f32> = members.iter().map(|&m| bulge(&mut std::iter::once(m))).collect();
    let mut worst = (f32::NEG_INFINITY, 0, 1);
    for i in 0..members.len() {
        for j in 0..i {
            let added = bulge(&mut [members[i], members[j]].into_iter()) - alone[i] - alone[j];
            if added > worst.0 {
                worst = (added, i, j);
            }
        }
    }
    let mut halves = [worst.1, worst.2].map(|i| Group { members: vec![members[i]], bulge: alone[i] });
    let mut rest: Vec<usize> =
        (0..members.len()).filter(|i| *i != worst.1 && *i != worst.2).map(|i| members[i]).collect();
    while !rest.is_empty() {
        // The member whose choice is clearest goes first.
        let mut best: Option<(f32, usize, usize, f32)> = None;
        for (at, &m) in rest.iter().enumerate() {
            let with = [0, 1].map(|h: usize| bulge(&mut halves[h].members.iter().copied().chain([m])));
            let added = [0, 1].map(|h: usize| with[h] - halves[h].bulge);
            let side = usize::from(added[1] < added[0]);
            let clear = added[1 - side] - added[side];
            if best.is_none_or(|b| clear > b.0) {
                best = Some((clear, at, side, with[side]));
            }
        }
        let (_, at, side, with) = best?;
        halves[side].members.push(rest.remove(at));
        halves[side].bulge = with;
    }
    Some(halves)
}
