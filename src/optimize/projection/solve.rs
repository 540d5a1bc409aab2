//! Rounds of half-spaces and least moves until nothing overlaps, and the way back.

use super::Scope;
use super::halfspace::{HalfSpace, least_move};
use super::tolerances::{
    CHANGES, HALVINGS, LOYALTY, MARGIN, MAX_MOVE, OFF_THE_BEARER, ONTO_THE_OTHER, ROUNDS, SIDES, TOUCHING,
};
use super::unit::Unit;
use crate::scene::{Parent, Scene};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f32::consts::TAU;

/// Where the units have to go.
pub(super) struct Solved {
    /// False if something still overlaps.
    pub converged: bool,
    /// Rounds that it took.
    pub rounds: u32,
    /// m, in the order of the units.
    pub moves: Vec<DVec3>,
}

/// A direction in which the first of two units leaves the second, and what a metre of it costs.
#[derive(Clone, Copy)]
struct Heading {
    along: Vec3,
    cost: f32,
}

/// The half-space of a pair, and how often its direction was changed.
struct Parting {
    along: Vec3,
    least: f64,
    changes: u32,
}

/// Units of one stage.
pub(super) struct Solver<'a> {
    scene: &'a Scene,
    units: &'a [Unit],
    scope: Scope,
    /// 1 / weight of each unit: the sum of squared moves is over objects.
    mobility: Vec<f64>,
}

impl<'a> Solver<'a> {
    pub fn new(scene: &'a Scene, units: &'a [Unit], scope: Scope) -> Self {
        let mobility = units.iter().map(|unit| if unit.moves { 1.0 / unit.objects.len() as f64 } else { 0.0 });
        Self { scene, units, scope, mobility: mobility.collect() }
    }

    /// The moves after which nothing overlaps, as near to none as they were found.
    pub fn solve(&self) -> Solved {
        let mut partings: BTreeMap<(usize, usize), Parting> = BTreeMap::new();
        let ground = self.ground();
        let mut moves = least_move(&ground, &self.mobility);
        for rounds in 0..ROUNDS {
            let overlapping = self.overlapping(&moves);
            if overlapping.is_empty() {
                self.draw_back(&mut moves);
                return Solved { converged: true, rounds, moves };
            }
            let headings: Vec<(Vec3, f32)> =
                overlapping.par_iter().map(|&pair| self.heading(pair, &moves, partings.get(&pair))).collect();
            for (&pair, (along, exit)) in overlapping.iter().zip(headings) {
                let apart = moves[pair.0] - moves[pair.1];
                let least = apart.dot(along.as_dvec3()) + f64::from(exit + MARGIN);
                let parting = partings.entry(pair).or_insert(Parting { along, least, changes: 0 });
                parting.changes += u32::from(parting.along != along);
                (parting.along, parting.least) = (along, least);
            }
            let spaces = partings.iter().map(|(&(first, second), parting)| HalfSpace {
                first,
                second: Some(second),
                along: parting.along.as_dvec3(),
                least: parting.least,
            });
            moves = least_move(&ground.iter().copied().chain(spaces).collect::<Vec<_>>(), &self.mobility);
            if moves.iter().any(|shift| !shift.is_finite() || shift.length() > MAX_MOVE) {
                // The half-spaces contradict each other; the last round's moves are no use to anyone.
                return Solved { converged: false, rounds, moves: vec![DVec3::ZERO; moves.len()] };
            }
        }
        Solved { converged: false, rounds: ROUNDS, moves }
    }

    /// Nothing that moves goes below the ground; what reaches below it by no more than touching goes no deeper.
    fn ground(&self) -> Vec<HalfSpace> {
        let moving = self.units.iter().enumerate().filter(|(_, unit)| unit.moves && unit.lowest.is_finite());
        moving
            .map(|(first, unit)| {
                let touching = (-TOUCHING..=0.0).contains(&unit.lowest);
                let least = if touching { 0.0 } else { -f64::from(unit.lowest) };
                HalfSpace { first, second: None, along: DVec3::Y, least }
            })
            .collect()
    }

    /// Pairs of units that overlap by more than touching.
    fn overlapping(&self, moves: &[DVec3]) -> Vec<(usize, usize)> {
        let count = self.units.len();
        let pairs: Vec<(usize, usize)> = (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j))).collect();
        pairs.into_par_iter().filter(|&pair| self.overlap(pair, moves)).collect()
    }

    fn overlap(&self, (i, j): (usize, usize), moves: &[DVec3]) -> bool {
        let (a, b) = (&self.units[i], &self.units[j]);
        (a.moves || b.moves) && a.overlaps(b, moves[i] - moves[j], self.scene)
    }

    /// The direction in which the first of two that overlap leaves the second at the least cost, and how far that is,
    /// m.
    fn heading(&self, (i, j): (usize, usize), moves: &[DVec3], parting: Option<&Parting>) -> (Vec3, f32) {
        let (a, b) = (&self.units[i], &self.units[j]);
        let apart = moves[i] - moves[j];
        // What lies on the other touches it: a direction along the surface is not blocked by that.
        let lies_on = f64::from(a.middle() - b.middle()) + apart.y > 0.0;
        let clear = DVec3::Y * f64::from(if lies_on { TOUCHING } else { -TOUCHING });
        let exit = |along: Vec3, clear: DVec3| {
            let apart = if along.y.abs() < 0.5 { apart + clear } else { apart };
            a.exit(b, apart, along, self.scene)
        };
        if let Some(kept) = parting.filter(|parting| parting.changes >= CHANGES) {
            return (kept.along, exit(kept.along, clear));
        }
        let cheapest = |clear: DVec3| {
            let exits: Vec<(Heading, f32)> =
                self.headings(i, j).into_par_iter().map(|heading| (heading, exit(heading.along, clear))).collect();
            let cost = |&(heading, length): &(Heading, f32)| {
                let loyal = parting.is_some_and(|parting| parting.along == heading.along);
                length * heading.cost * if loyal { LOYALTY } else { 1.0 }
            };
            // What overlaps deeper than touching is not left within less: there the other was cleared, or not met at
            // all.
            let real = exits.into_iter().filter(|(_, length)| *length > TOUCHING);
            real.min_by(|a, b| cost(a).total_cmp(&cost(b))).map(|(heading, length)| (heading.along, length))
        };
        cheapest(clear).or_else(|| cheapest(DVec3::ZERO)).unwrap_or((Vec3::X, 0.0))
    }

    /// Where the first of two units may go to leave the second.
    fn headings(&self, i: usize, j: usize) -> Vec<Heading> {
        let (a, b) = (&self.units[i], &self.units[j]);
        let side = |k: usize| TAU * k as f32 / SIDES as f32;
        let sideways =
            |cost: f32| (0..SIDES).map(move |k| Heading { along: Vec3::new(side(k).cos(), 0.0, side(k).sin()), cost });
        let vertical = |along: Vec3, cost: f32| [Heading { along, cost }];
        let upwards = |first: bool| if first { Vec3::Y } else { Vec3::NEG_Y };
        if self.scope == Scope::Objects {
            let askew =
                |y: f32| sideways(1.0).map(move |h| Heading { along: (h.along + Vec3::Y * y).normalize(), cost: 1.0 });
            let level = sideways(1.0).chain(vertical(Vec3::Y, 1.0)).chain(vertical(Vec3::NEG_Y, 1.0));
            return level.chain(askew(1.0)).chain(askew(-1.0)).collect();
        }
        let bears = |bearer: &Unit, borne: &Unit| match self.scene.objects[borne.root].parent {
            Parent::Object(parent) => bearer.objects.contains(&parent),
            Parent::Root(_) => false,
        };
        let on_ground = |unit: &Unit| matches!(self.scene.objects[unit.root].parent, Parent::Root(_));
        match (bears(b, a), bears(a, b)) {
            (true, _) => sideways(OFF_THE_BEARER).chain(vertical(Vec3::Y, 1.0)).collect(),
            (_, true) => sideways(OFF_THE_BEARER).chain(vertical(Vec3::NEG_Y, 1.0)).collect(),
            _ if on_ground(a) || on_ground(b) => sideways(1.0).collect(),
            _ => sideways(1.0).chain(vertical(upwards(a.middle() > b.middle()), ONTO_THE_OTHER)).collect(),
        }
    }

    /// Draws each unit back towards where it was as far as it stays clear, the farthest first: a half-space that was
    /// needed on the way may not be at the end.
    fn draw_back(&self, moves: &mut [DVec3]) {
        let mut farthest: Vec<usize> = (0..moves.len()).filter(|&i| moves[i] != DVec3::ZERO).collect();
        farthest.sort_by(|&i, &j| moves[j].length().total_cmp(&moves[i].length()));
        for i in farthest {
            let (whole, lowest) = (moves[i], f64::from(self.units[i].lowest));
            let (mut blocked, mut clear) = (0.0, 1.0);
            for halving in 0..HALVINGS {
                let share = if halving == 0 { 0.0 } else { 0.5 * (blocked + clear) };
                moves[i] = share * whole;
                let buried = lowest + moves[i].y < -f64::from(TOUCHING);
                let free =
                    !buried && (0..moves.len()).filter(|&j| j != i).all(|j| !self.overlap((i.min(j), i.max(j)), moves));
                (blocked, clear) = if free { (blocked, share) } else { (share, clear) };
                if clear == 0.0 {
                    break;
                }
            }
            moves[i] = if clear == 0.0 { DVec3::ZERO } else { clear * whole };
        }
    }
}
