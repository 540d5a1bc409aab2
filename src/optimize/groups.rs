//! What is searched, in which order: local groups from the leaves up, then the whole scene.
//!
//! A local group is an object that bears movable ones: it is held, and each movable child is a unit together with
//! everything that stands on it. In the global stage every movable object that stands on the ground, or on something
//! that never moves, is a unit with everything on it; all objects are simulated (the paper; its released code simulates
//! the roots only).

use super::{rig::Rig, tolerances::LEAN};
use crate::scene::{self, Parent, Relation, Scene};
use crate::world::{BodyDef, Pose, STATIC, World};

/// Objects that are simulated together.
#[derive(Clone, Debug)]
pub(super) struct Group {
    /// The held object's name, or `global`.
    pub name: String,
    /// The held object of a local group.
    pub held: Option<usize>,
    /// Object of each body; the bodies after them are walls.
    pub objects: Vec<usize>,
    /// Unit of each body, or `STATIC`.
    units: Vec<u32>,
    /// Root body of each unit.
    roots: Vec<u32>,
}

impl Group {
    fn new(name: &str, held: Option<usize>) -> Self {
        Self { name: name.into(), held, objects: Vec::new(), units: Vec::new(), roots: Vec::new() }
    }

    fn add(&mut self, object: usize, unit: u32) {
        self.objects.push(object);
        self.units.push(unit);
    }

    /// Adds movable objects that move as one, their root first.
    fn add_unit(&mut self, objects: impl IntoIterator<Item = usize>) {
        let unit = self.roots.len() as u32;
        self.roots.push(self.objects.len() as u32);
        for object in objects {
            self.add(object, unit);
        }
    }

    /// The same objects in the same order, of which those move, each by itself, for which `moves` is true.
    pub fn with_moving(&self, moves: &[bool]) -> Self {
        let mut group = Self::new(&self.name, self.held);
        for &object in &self.objects {
            match moves[object] {
                true => group.add_unit([object]),
                false => group.add(object, STATIC),
            }
        }
        group
    }

    /// Objects that the search adjusts.
    pub fn unit_roots(&self) -> impl Iterator<Item = usize> + '_ {
        self.roots.iter().map(|&body| self.objects[body as usize])
    }

    /// Bodies that move, as (body, object).
    pub fn moving(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (0..self.objects.len()).filter(|&body| self.moves(body)).map(|body| (body, self.objects[body]))
    }

    /// True for a body that moves; walls do not.
    pub fn moves(&self, body: usize) -> bool {
        self.units.get(body).is_some_and(|&unit| unit != STATIC)
    }

    /// Takes over the poses of the bodies that moved; everything else keeps its pose to the bit.
    pub fn adopt(&self, rigs: &[Rig], starts: &[Pose], ends: &[Pose], layout: &mut [scene::Pose]) {
        for (body, object) in self.moving() {
            if starts[body] != ends[body] {
                layout[object] = rigs[object].object(&ends[body]);
            }
        }
    }

    /// The objects of each unit in turn, then each object that is held, and whether they move.
    pub fn members(&self) -> Vec<(Vec<usize>, bool)> {
        let of = |unit: u32| {
            let objects = self.objects.iter().zip(&self.units).filter(move |&(_, &own)| own == unit);
            objects.map(|(&object, _)| object).collect::<Vec<usize>>()
        };
        let units = (0..self.roots.len() as u32).map(|unit| (of(unit), true));
        units.chain(of(STATIC).into_iter().map(|object| (vec![object], false))).collect()
    }

    /// How far the group is raised for its simulation, m: a held object that reaches below the ground would have its
    /// children squeezed between itself and the ground.
    pub fn lift(&self, rigs: &[Rig], layout: &[scene::Pose]) -> f32 {
        self.held.map_or(0.0, |held| (-rigs[held].lowest(&rigs[held].body(&layout[held]))).max(0.0))
    }

    /// Poses of the bodies for a layout, the walls' last.
    pub fn starts(&self, rigs: &[Rig], walls: &[BodyDef], layout: &[scene::Pose]) -> Vec<Pose> {
        let objects = self.objects.iter().map(|&object| rigs[object].body(&layout[object]));
        objects.chain(walls.iter().map(|wall| wall.start)).collect()
    }

    /// The tables: starts from `layout`; the layout term compares with `reference`. The walls come after the objects.
    pub fn world(&self, rigs: &[Rig], walls: &[BodyDef], layout: &[scene::Pose], reference: &[scene::Pose]) -> World {
        let lift = self.lift(rigs, layout);
        let raised = |object: usize, pose: &scene::Pose| rigs[object].body(pose).raised(lift);
        let objects = (self.objects.iter().zip(&self.units))
            .map(|(&i, &unit)| rigs[i].def(unit, raised(i, &layout[i]), raised(i, &reference[i])));
        let defs: Vec<_> = objects.chain(walls.iter().cloned()).collect();
        World::new(&defs, &self.roots)
    }
}

/// All groups in the order in which they are searched; none if nothing is movable. `global_only`: one group, in which
/// every movable object is a unit by itself. `bearers`: what each object stands on besides its parent.
pub(super) fn plan(scene: &Scene, global_only: bool, bearers: &[Vec<usize>]) -> Vec<Group> {
    let mut groups = if global_only { Vec::new() } else { local(scene, bearers) };
    let mut global = Group::new("global", None);
    for object in 0..scene.objects.len() {
        if scene.is_static(object) {
            global.add(object, STATIC);
        } else if global_only {
            global.add_unit([object]);
        } else if is_on_firm_ground(scene, object) {
            global.add_unit(moving_along(scene, object));
        }
    }
    if !global.roots.is_empty() {
        groups.push(global);
    }
    groups
}

/// The local groups, from the leaves up.
fn local(scene: &Scene, bearers: &[Vec<usize>]) -> Vec<Group> {
    let movable = |&object: &usize| !scene.is_static(object);
    let mut groups = Vec::new();
    for held in scene.post_order() {
        let mut group = Group::new(&scene.objects[held].name, Some(held));
        group.add(held, STATIC);
        for child in scene.children(held).filter(movable) {
            group.add_unit(moving_along(scene, child));
        }
        if group.roots.is_empty() {
            continue;
        }
        let shared = group.objects.iter().flat_map(|&object| bearers[object].iter().copied());
        let others: Vec<usize> = scene.subtree(held, |_| true).into_iter().chain(shared).collect();
        for object in others {
            if !group.objects.contains(&object) {
                group.add(object, STATIC);
            }
        }
        groups.push(group);
    }
    groups
}

/// True for what stands on the ground, or on something that never moves.
pub(super) fn is_on_firm_ground(scene: &Scene, object: usize) -> bool {
    match scene.objects[object].parent {
        Parent::Root(_) => true,
        Parent::Object(parent) => scene.is_static(parent),
    }
}

/// A movable object and everything on it that moves along, itself first.
pub(super) fn moving_along(scene: &Scene, root: usize) -> Vec<usize> {
    scene.subtree(root, |child| !scene.is_static(child))
}

/// Moves an object to `pose`, and everything on it that `along` lets through rigidly with it.
pub(super) fn carry(
    scene: &Scene,
    object: usize,
    pose: scene::Pose,
    layout: &mut [scene::Pose],
    along: impl Fn(usize) -> bool,
) {
    let old = layout[object];
    let turn = pose.rotation * old.rotation.conjugate();
    for moved in scene.subtree(object, along) {
        let place = &mut layout[moved];
        place.translation = pose.translation + turn * (place.translation - old.translation);
        place.rotation = (turn * place.rotation).normalize();
    }
}

/// Moves something that stands to `pose`, and everything movable on it as its centre moves, up or down with what is below.
/// What leans or stands askew was reconstructed wrongly, not what is on it: that is turned along only if it is inside or
/// hangs there, or the object turns far.
pub(super) fn carry_standing(scene: &Scene, rig: &Rig, object: usize, pose: scene::Pose, layout: &mut [scene::Pose]) {
    let (old, moves) = (layout[object], |child: usize| scene.objects[child].movable);
    let turn = pose.rotation * old.rotation.conjugate();
    let way = rig.center_of(&pose) - rig.center_of(&old);
    let little = old.rotation.angle_between(pose.rotation) <= LEAN.end;
    for child in scene.children(object).filter(|&child| moves(child)) {
        let here = layout[child];
        let rigid = pose.translation + turn * (here.translation - old.translation);
        let there = match little && scene.objects[child].relation == Relation::On {
            true => scene::Pose { translation: (here.translation + way).with_y(rigid.y), ..here },
            false => scene::Pose { translation: rigid, rotation: (turn * here.rotation).normalize() },
        };
        carry(scene, child, there, layout, moves);
    }
    layout[object] = pose;
}
