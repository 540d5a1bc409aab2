//! The last, exact step: no two triangle meshes touch.
//!
//! Everything before works on convex parts, which cover the meshes but for a few hundredths of a millimetre, and rest
//! with as much overlap; ready-made parts may fall short of theirs by millimetres. So the settled layout is looked at
//! once more, triangle by triangle: meshes that touch are parted by the shortest of a set of shifts, up or sideways,
//! that leads to a free place. What rests on the moved object moves along; rotations stay. What hangs is parted too,
//! though no simulation moves it, and taken to the object that it hangs on; only what is not movable stays.

mod hold;
mod surface;
mod tolerances;
mod walls;

use super::directions::directions;
use super::room::Room;
use super::sweep::first_gap;
use crate::scene::{Parent, Pose, Root, Scene};
use crate::shape::Shape;
use glam::{DMat3, DVec3};
use std::cell::Cell;
use surface::{Budget, Surface};
use tolerances::{
    ASIDE, DROP, LOAD, MAX_MOVE, MAX_MOVE_HUNG, MAX_PAIRS, REACHES, REST, ROUNDS, SIDEWAYS, SINK, SPARES, TOO_NEAR,
    TOUCHING, UP,
};
use walls::Walls;

/// What the exact step found and did, for every object in the scene's order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clearances {
    /// How far the object was raised and shifted, m.
    pub shifts: Vec<DVec3>,
    /// How far it could fall before its mesh meets another or the ground, m; none if that is more than 5 cm.
    pub drops: Vec<Option<f64>>,
    /// Meshes that still meet.
    pub overlaps: Vec<MeshOverlap>,
    /// False if the meshes are too large, or overlap too much, for all of them to be looked at.
    pub complete: bool,
}

/// Two objects whose meshes meet.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshOverlap {
    /// The two, in the scene's order.
    pub objects: [usize; 2],
    /// The shortest of the shifts looked at that would part them, m; none if none within reach does.
    pub depth: Option<f64>,
}

/// Parts the meshes of a layout as far as that goes, and leaves on their walls what is there. `shapes` and `layout` are
/// in the scene's order.
pub fn part_meshes(scene: &Scene, shapes: &[Shape], room: &Room, layout: &mut [Pose]) -> Clearances {
    let mut exact = Exact::new(scene, shapes, room, layout);
    exact.part();
    exact.lower();
    exact.hold();
    exact.spread();
    for (pose, shift) in layout.iter_mut().zip(&exact.shifts) {
        pose.translation += *shift;
    }
    exact.clearances()
}

/// How the meshes of a layout lie.
pub(super) fn look(scene: &Scene, shapes: &[Shape], room: &Room, layout: &[Pose]) -> Clearances {
    Exact::new(scene, shapes, room, layout).clearances()
}

/// What a move is for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Aim {
    /// That two meshes come apart, any way.
    Apart,
    /// Room between two that stand side by side: sideways, and only where there is some.
    Room,
}

/// A direction in which an object may be moved.
struct Heading {
    /// Rows are three axes, the last is the direction.
    frame: DMat3,
    along: DVec3,
    /// Clearance that a move in this direction leaves, m.
    margin: f64,
    /// What a metre costs.
    cost: f64,
}

impl Heading {
    fn new(along: DVec3, margin: f64, cost: f64) -> Self {
        let (u, v) = along.any_orthonormal_pair();
        Self { frame: DMat3::from_cols(u, v, along).transpose(), along, margin, cost }
    }
}

/// A move that parts two objects.
#[derive(Clone, Copy)]
struct Move {
    mover: usize,
    shift: DVec3,
    cost: f64,
}

struct Exact<'a> {
    scene: &'a Scene,
    surfaces: Vec<Surface>,
    /// What moves along with each object, itself first; nothing for what is not movable.
    moving: Vec<Vec<usize>>,
    shifts: Vec<DVec3>,
    up: Heading,
    down: Heading,
    /// Sideways.
    aside: Vec<Heading>,
    /// Sideways and up: out of a corner.
    askew: Vec<Heading>,
    walls: Walls<'a>,
    /// For what hangs on a wall or ceiling: away from it and along it; nothing for all else.
    along: Vec<Vec<Heading>>,
    budget: Budget,
}

impl<'a> Exact<'a> {
    fn new(scene: &'a Scene, shapes: &[Shape], room: &'a Room, layout: &[Pose]) -> Self {
        let movable = |object: usize| scene.objects[object].movable;
        let moving = |object| if movable(object) { scene.subtree(object, movable) } else { Vec::new() };
        let surfaces: Vec<Surface> =
            shapes.iter().zip(layout).map(|(shape, pose)| Surface::new(&shape.surface, pose)).collect();
        let walls = Walls::new(room, &surfaces);
        let along_surface = |object: usize| match walls.surface(object) {
            Some(normal) => {
                let across = DVec3::Y.cross(normal).try_normalize().unwrap_or(DVec3::X);
                let plane = DMat3::from_cols(across, normal, normal.cross(across));
                let along = directions().map(|along| Heading::new((plane * along).normalize(), ASIDE, 1.0));
                [Heading::new(normal, ASIDE, 1.0)].into_iter().chain(along).collect()
            }
            None => Vec::new(),
        };
        Self {
            scene,
            budget: Cell::new(MAX_PAIRS),
            moving: (0..layout.len()).map(moving).collect(),
            shifts: vec![DVec3::ZERO; layout.len()],
            up: Heading::new(DVec3::Y, REST, UP),
            down: Heading::new(DVec3::NEG_Y, REST, 1.0),
            aside: directions().map(|aside| Heading::new(aside, ASIDE, 1.0)).collect(),
            askew: directions().map(|aside| Heading::new((aside + DVec3::Y).normalize(), ASIDE, 1.0)).collect(),
            along: (0..layout.len()).map(along_surface).collect(),
            walls,
            surfaces,
        }
    }

    /// Parts what touches, from the ground up, until nothing does or nothing helps.
    fn part(&mut self) {
        for _ in 0..ROUNDS {
            self.lift_from_ground();
            let mut touching = self.near(TOUCHING, false);
            // What an object rests on comes before what stands beside it.
            let bears = |bearer: usize, object: usize| self.scene.bearers(object).any(|other| other == bearer);
            touching.sort_by_key(|&(i, j, _)| (!bears(i, j) && !bears(j, i), i, j));
            let mut moved = false;
            for (i, j, _) in touching {
                if self.way(i, j, TOUCHING).is_some()
                    && let Some(step) = self.parting(i, j, TOUCHING, Aim::Apart)
                {
                    self.apply(step);
                    moved = true;
                }
            }
            if !moved {
                break;
            }
        }
    }

    /// Lowers what was raised farther than it had to be, and what its parts hold a little above its bearer; bearers
    /// first.
    fn lower(&mut self) {
        for object in self.scene.bearers_first() {
            let bearer = match self.scene.objects[object].parent {
                Parent::Object(bearer) => self.shifts[bearer].y,
                Parent::Root(_) => 0.0,
            };
            let raised = self.shifts[object].y - bearer;
            let moving = &self.moving[object];
            let stands = !self.scene.is_static(object);
            if raised > REST || stands {
                let drops = moving.iter().filter_map(|&part| self.drop(part, moving));
                let room = drops.min_by(f64::total_cmp).unwrap_or(raised) - REST;
                let down = if stands && room <= SINK { room } else { room.min(raised) };
                let step = Move { mover: object, shift: DVec3::NEG_Y * down, cost: 0.0 };
                if down > TOUCHING && self.is_free(&step) {
                    self.apply(step);
                }
            }
        }
    }

    /// Gives room to what stands too near beside something, where that touches nothing else.
    fn spread(&mut self) {
        for (i, j, _) in self.near(TOO_NEAR, false) {
            let sideways = self.way(i, j, TOO_NEAR).is_some_and(|way| {
                let length = way.length();
                length >= TOUCHING && way.y.abs() < SIDEWAYS * length
            });
            if sideways && let Some(step) = self.parting(i, j, TOO_NEAR, Aim::Room) {
                self.apply(step);
            }
        }
    }

    /// Raises what reaches below the ground.
    fn lift_from_ground(&mut self) {
        for object in 0..self.surfaces.len() {
            let lowest = self.surfaces[object].low.y + self.shifts[object].y;
            let step = Move { mover: object, shift: DVec3::Y * (REST - lowest), cost: 0.0 };
            if lowest < 0.0 && lowest > -MAX_MOVE && !self.moving[object].is_empty() && self.stays_in_room(&step) {
                self.apply(step);
            }
        }
    }

    /// Pairs of objects nearer than `reach`, with their distance; all of them, or those of which at least one may move.
    fn near(&self, reach: f64, all: bool) -> Vec<(usize, usize, f64)> {
        let count = self.surfaces.len();
        (0..count)
            .flat_map(|i| (i + 1..count).map(move |j| (i, j)))
            .filter(|&(i, j)| all || !self.moving[i].is_empty() || !self.moving[j].is_empty())
            .filter_map(|(i, j)| self.way(i, j, reach).map(|way| (i, j, way.length())))
            .collect()
    }

    fn way(&self, i: usize, j: usize, reach: f64) -> Option<DVec3> {
        self.surfaces[i].way(&self.surfaces[j], self.shifts[i] - self.shifts[j], reach, &self.budget)
    }

    /// The cheapest move that parts two objects by `reach` and leads to a place that is free of all others; without one
    /// and if they are to come apart, the cheapest that parts the two.
    fn parting(&self, i: usize, j: usize, reach: f64, aim: Aim) -> Option<Move> {
        let mut nearest = None;
        for within in REACHES.into_iter().chain([MAX_MOVE_HUNG]) {
            let moves = self.moves(i, j, reach, within, aim);
            let clear = moves.iter().find(|step| self.is_free(step)).copied();
            if clear.is_some() {
                return clear;
            }
            nearest = nearest.or(moves.iter().find(|step| self.stays_in_room(step)).copied());
        }
        nearest.filter(|_| aim == Aim::Apart)
    }

    /// The moves of at most `within` that part two objects by `reach`, cheapest first.
    fn moves(&self, i: usize, j: usize, reach: f64, within: f64, aim: Aim) -> Vec<Move> {
        let mut moves: Vec<Move> = Vec::new();
        for (mover, other) in [(i, j), (j, i)] {
            let moving = &self.moving[mover];
            if moving.is_empty() || moving.contains(&other) {
                continue;
            }
            let burden = 1.0 + LOAD * (moving.len() - 1) as f64;
            for heading in self.headings(mover, aim) {
                let Some(least) = self.distance(moving, other, heading, heading.margin, within) else {
                    continue;
                };
                // The margin is along the direction: past something steep it takes more to be clear of it.
                let clear = SPARES.map(|spare| least + spare * heading.margin).into_iter().find(|distance| {
                    let shift = heading.along * *distance;
                    *distance > 0.0 && moving.iter().all(|&part| self.leaves(part, other, shift, reach))
                });
                if let Some(distance) = clear {
                    moves.push(Move { mover, shift: heading.along * distance, cost: burden * heading.cost * distance });
                }
            }
        }
        moves.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        moves
    }

    /// Where an object may go: what rests on something not down, what hangs along its surface.
    fn headings(&self, object: usize, aim: Aim) -> impl Iterator<Item = &Heading> {
        let level = aim == Aim::Room;
        let along = &self.along[object];
        let hung = matches!(self.scene.objects[object].parent, Parent::Root(Root::Wall | Root::Ceiling));
        let vertical = (!level).then_some(&self.up).into_iter().chain((hung && !level).then_some(&self.down));
        let anywhere = vertical.chain(&self.aside).chain(self.askew.iter().filter(move |_| !level));
        anywhere
            .filter(|_| along.is_empty())
            .chain(along.iter().filter(move |heading| !level || heading.along.y.abs() < SIDEWAYS))
    }

    /// How far all of `moving` must go to leave `other`, m; none if that is farther than `within` or allowed.
    fn distance(&self, moving: &[usize], other: usize, heading: &Heading, margin: f64, within: f64) -> Option<f64> {
        let hung = moving.iter().all(|&part| self.scene.is_static(part));
        let range = [0.0, within.min(if hung { MAX_MOVE_HUNG } else { MAX_MOVE })];
        let mut blocked = Vec::new();
        for &part in moving {
            let apart = self.shifts[part] - self.shifts[other];
            let (part, other) = (&self.surfaces[part], &self.surfaces[other]);
            blocked.extend(part.blocked(other, apart, &heading.frame, range, margin, &self.budget)?);
        }
        let free = first_gap(blocked);
        (free <= range[1]).then_some(free)
    }

    /// True if `part` is at least `reach` from `other` after a shift.
    fn leaves(&self, part: usize, other: usize, shift: DVec3, reach: f64) -> bool {
        let apart = self.shifts[part] + shift - self.shifts[other];
        self.surfaces[part].way(&self.surfaces[other], apart, reach, &self.budget).is_none()
    }

    /// True if nothing that moves touches anything else after the move.
    fn is_free(&self, step: &Move) -> bool {
        let moving = &self.moving[step.mover];
        let clear = |part: usize| {
            let above_ground = self.surfaces[part].low.y + self.shifts[part].y + step.shift.y >= 0.0;
            let mut others = (0..self.surfaces.len()).filter(|other| !moving.contains(other));
            above_ground && others.all(|other| self.leaves(part, other, step.shift, TOUCHING))
        };
        self.stays_in_room(step) && moving.iter().all(|&part| clear(part))
    }

    /// True if nothing that moves goes through a wall or off the surface that it hangs on.
    fn stays_in_room(&self, step: &Move) -> bool {
        self.moving[step.mover].iter().all(|&part| self.walls.allow(part, self.shifts[part], step.shift))
    }

    fn apply(&mut self, step: Move) {
        for &object in &self.moving[step.mover] {
            self.shifts[object] += step.shift;
        }
    }

    fn clearances(self) -> Clearances {
        let parted = self.budget.replace(MAX_PAIRS) > 0;
        let overlaps = (self.near(TOUCHING, true).into_iter())
            .filter(|&(_, _, distance)| distance == 0.0)
            .map(|(i, j, _)| MeshOverlap { objects: [i, j], depth: self.depth(i, j) })
            .collect();
        let drops =
            (0..self.surfaces.len()).map(|object| self.drop(object, &self.scene.subtree(object, |_| true))).collect();
        Clearances { drops, overlaps, complete: parted && self.budget.get() > 0, shifts: self.shifts }
    }

    /// The shortest shift that parts two objects, m.
    fn depth(&self, i: usize, j: usize) -> Option<f64> {
        let headings = || [&self.up, &self.down].into_iter().chain(&self.aside);
        let ways = |mover: usize, other: usize| {
            headings()
                .filter_map(move |heading| self.distance(&[mover], other, heading, 0.0, MAX_MOVE_HUNG))
                .collect::<Vec<f64>>()
        };
        ways(i, j).into_iter().chain(ways(j, i)).min_by(f64::total_cmp)
    }

    /// How far an object could fall before it meets the ground or anything but `along`, m.
    fn drop(&self, object: usize, along: &[usize]) -> Option<f64> {
        let surface = &self.surfaces[object];
        let ground = (surface.low.y + self.shifts[object].y).max(0.0);
        let others = (0..self.surfaces.len()).filter(|other| !along.contains(other));
        let gaps = others.filter_map(|other| self.above(object, other)).map(|gap| gap.max(0.0));
        gaps.chain([ground]).min_by(f64::total_cmp).filter(|gap| *gap <= DROP)
    }

    /// How far an object can come down before it meets another, m; none if that is not below it within `DROP`.
    fn above(&self, object: usize, other: usize) -> Option<f64> {
        let apart = self.shifts[object] - self.shifts[other];
        let (surface, other) = (&self.surfaces[object], &self.surfaces[other]);
        let blocked = surface.blocked(other, apart, &self.down.frame, [0.0, DROP], 0.0, &self.budget)?;
        blocked.into_iter().map(|[low, _]| low).min_by(f64::total_cmp)
    }
}
