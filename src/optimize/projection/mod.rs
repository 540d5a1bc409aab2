//! The nearest layout in which nothing overlaps: a projection of the reconstruction onto the feasible layouts.
//!
//! Translations x are the variables, rotations stay: min Σ |xᵢ|² over the objects, subject to no two convex parts of
//! different units overlapping and nothing below the ground. For two units the forbidden differences xᵢ − xⱼ are a
//! union of convex sets; every round replaces it, where they overlap, by one half-space whose normal is the direction
//! in which they part with the least move, and solves for the least move of all that satisfies every half-space found
//! so far (`halfspace`). At the end each unit is drawn back towards the reconstruction as far as it stays clear.
//!
//! What lies inside something is meant to be in it: it moves with its container, and the two are not parted.

mod halfspace;
mod solve;
mod tolerances;
mod unit;

use super::groups::{Group, is_on_firm_ground, moving_along};
use super::rig::Rig;
use crate::scene::{Parent, Pose, Relation, Scene};
use crate::shape::Shape;
use glam::DVec3;
use solve::Solver;
use tolerances::MAX_SPREAD;
use unit::Unit;

/// What is free to move at a time (the two projection baselines of the paper).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// All objects at once, in any direction (global-only).
    Objects,
    /// Along the support tree (global-local): first the children of each object on their held parent, upwards out of it
    /// and sideways out of each other, then everything on the ground with what it bears, sideways.
    Groups,
}

/// What a projection came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Projection {
    /// False if something still overlaps, or is below the ground.
    pub converged: bool,
    /// Rounds that it took.
    pub rounds: u32,
    /// How far each object was moved, m.
    pub shifts: Vec<DVec3>,
}

/// Moves the objects of a layout apart. `shapes` and `layout` are in the scene's order. A layout in which nothing
/// overlaps by more than touching keeps every bit.
pub fn project(scene: &Scene, shapes: &[Shape], layout: &mut [Pose], scope: Scope) -> Projection {
    let rigs: Vec<Rig> = shapes.iter().map(Rig::new).collect();
    let mut projection = Projection { converged: true, rounds: 0, shifts: vec![DVec3::ZERO; layout.len()] };
    for stage in stages(scene, scope) {
        let units: Vec<Unit> =
            stage.into_iter().map(|(objects, moves)| Unit::new(objects, moves, &rigs, layout)).collect();
        let solved = Solver::new(scene, &units, scope).solve();
        projection.converged &= solved.converged;
        projection.rounds += solved.rounds;
        for (unit, shift) in units.iter().zip(&solved.moves) {
            for &object in unit.objects.iter().filter(|_| *shift != DVec3::ZERO) {
                layout[object].translation += *shift;
                projection.shifts[object] += *shift;
            }
        }
    }
    projection
}

/// The mean of a search that starts where a group's projection is: six numbers a unit, shift and no turn. None if
/// nothing overlaps or the projection does not converge.
pub(super) fn start(scene: &Scene, rigs: &[Rig], layout: &[Pose], group: &Group) -> Option<Vec<f32>> {
    let units: Vec<Unit> = (group.members().into_iter())
        .map(|(objects, moves)| {
            let moves = moves && !is_nested(scene, objects[0]);
            Unit::new(objects, moves, rigs, layout)
        })
        .collect();
    let solved = Solver::new(scene, &units, Scope::Groups).solve();
    let moved = solved.moves.iter().any(|shift| *shift != DVec3::ZERO);
    let mean = |shift: &DVec3| [shift.x as f32, shift.y as f32, shift.z as f32, 0.0, 0.0, 0.0];
    (solved.converged && moved).then(|| solved.moves.iter().take(group.unit_roots().count()).flat_map(mean).collect())
}

/// The layout with room between the units of a group that stand beside each other. None if nothing needs to move. What
/// could only get it by going far, out of a niche, say, stays.
pub(super) fn spread(scene: &Scene, rigs: &[Rig], layout: &[Pose], group: &Group) -> Option<Vec<Pose>> {
    let members = group.members();
    let mut moves: Vec<bool> = members.iter().map(|(objects, moves)| *moves && !is_nested(scene, objects[0])).collect();
    let shifts = loop {
        let make = |((objects, _), &moves): (&(Vec<usize>, bool), &bool)| {
            let unit = if moves { Unit::with_room } else { Unit::new };
            unit(objects.clone(), moves, rigs, layout)
        };
        let units: Vec<Unit> = members.iter().zip(&moves).map(make).collect();
        let shifts = Solver::new(scene, &units, Scope::Groups).solve().moves;
        let stays = |shift: &DVec3| shift.length() <= MAX_SPREAD;
        if shifts.iter().all(stays) {
            break shifts;
        }
        moves.iter_mut().zip(&shifts).for_each(|(moves, shift)| *moves &= stays(shift));
    };
    let mut spread = layout.to_vec();
    for ((objects, _), shift) in members.iter().zip(&shifts) {
        objects.iter().for_each(|&object| spread[object].translation += *shift);
    }
    shifts.iter().any(|shift| *shift != DVec3::ZERO).then_some(spread)
}

/// What is projected together, stage after stage: lists of objects that keep together, root first, and whether they
/// move.
fn stages(scene: &Scene, scope: Scope) -> Vec<Vec<(Vec<usize>, bool)>> {
    let free = |&object: &usize| !scene.is_static(object) && !is_nested(scene, object);
    match scope {
        Scope::Objects => {
            let with_nested = |object| match free(&object) {
                true => (with_nested(scene, object), true),
                false => (vec![object], false),
            };
            let carried =
                |&object: &usize| is_nested(scene, object) && !scene.is_static(object) && !stays(scene, object);
            vec![(0..scene.objects.len()).filter(|object| !carried(object)).map(with_nested).collect()]
        }
        Scope::Groups => {
            let mut stages: Vec<_> = (scene.post_order().into_iter())
                .map(|held| {
                    let children = scene.children(held).filter(free);
                    let units = children.map(|child| (moving_along(scene, child), true));
                    [(vec![held], false)].into_iter().chain(units).collect::<Vec<_>>()
                })
                .filter(|stage| stage.len() > 1)
                .collect();
            let units = (0..scene.objects.len()).filter_map(|object| {
                match (scene.is_static(object), is_on_firm_ground(scene, object)) {
                    (true, _) => Some((vec![object], false)),
                    (false, true) => Some((moving_along(scene, object), free(&object))),
                    (false, false) => None,
                }
            });
            stages.push(units.collect());
            stages
        }
    }
}

/// True for what lies inside another object.
fn is_nested(scene: &Scene, object: usize) -> bool {
    scene.objects[object].relation == Relation::Inside && matches!(scene.objects[object].parent, Parent::Object(_))
}

/// True for what lies inside something that never moves, at any depth: it stays, too.
fn stays(scene: &Scene, mut object: usize) -> bool {
    while let (true, Parent::Object(parent)) = (is_nested(scene, object), scene.objects[object].parent) {
        object = parent;
    }
    scene.is_static(object)
}

/// An object and what lies inside it, at any depth.
fn with_nested(scene: &Scene, root: usize) -> Vec<usize> {
    scene.subtree(root, |child| is_nested(scene, child) && !scene.is_static(child))
}
