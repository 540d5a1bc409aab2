//! From a reconstruction in any frame to a scene that is upright: +Y is up, the ground is at 0, objects stand straight
//! and at the heights of what bears them (REST3D's stage 2b).
//!
//! `stance` finds the flat bases of every mesh, `vertical` lets the objects vote for the direction that is up,
//! `upright` decides which objects are set straight, `columns` and `support` find the height at which each rests, from
//! the ground up. What is on a wall or ceiling, hangs or is not movable only follows. Scale is left alone.

mod columns;
mod report;
mod stance;
mod support;
mod tolerances;
mod upright;
mod vertical;

pub use report::{Canonicalization, ObjectChange, Rotation};

use crate::scene::{Parent, Pose, Relation, Root, Scene};
use crate::shape::Mesh;
use columns::Surface;
use glam::{DQuat, DVec3};
use stance::Stance;
use tolerances::FAR;
use upright::Verdict;
use vertical::Vertical;

/// Makes the scene canonical. `meshes` are the objects' meshes in the scene's order, scaled to metres. A canonical
/// scene stays as it is.
pub fn canonicalize(scene: &mut Scene, meshes: &[Mesh]) -> Canonicalization {
    let mut work = Work::new(scene, meshes);
    let vertical = work.vertical();
    let turn = DQuat::from_rotation_arc(vertical.up, DVec3::Y);
    let pivot = work.middle();
    work.transform(|point| pivot + turn * (point - pivot), turn);
    work.set_upright();
    let ground_shift = -work.ground();
    work.transform(|point| point + DVec3::Y * ground_shift, DQuat::IDENTITY);
    work.set_heights();
    let changes = work.changes;
    let (axis, angle) = turn.to_axis_angle();
    Canonicalization {
        rotation: Rotation { axis: scene.direction_in_file(axis).to_array(), degrees: angle.to_degrees() },
        tilt_degrees: vertical.tilt.to_degrees(),
        votes: vertical.votes,
        spread_degrees: vertical.spread.to_degrees(),
        ground_shift,
        objects: changes,
    }
}

/// What is known of each object, in the scene's order, and what was done with it.
struct Work<'a> {
    scene: &'a mut Scene,
    meshes: &'a [Mesh],
    stances: Vec<Vec<Stance>>,
    /// Middle of each object's convex hull, mesh frame, m.
    centers: Vec<DVec3>,
    /// True if the meshes' own +Y is up.
    trusted: bool,
    changes: Vec<ObjectChange>,
}

impl<'a> Work<'a> {
    fn new(scene: &'a mut Scene, meshes: &'a [Mesh]) -> Self {
        let (stances, centers): (Vec<_>, Vec<_>) = meshes.iter().map(|mesh| stance::stances(&mesh.vertices)).unzip();
        let trusted = vertical::axes_are_up(&scene.objects, &stances);
        let change = |name: &String| ObjectChange {
            name: name.clone(),
            turned_degrees: 0.0,
            raised: 0.0,
            why_turned: String::new(),
            why_raised: String::new(),
        };
        let changes = scene.objects.iter().map(|object| change(&object.name)).collect();
        Self { scene, meshes, stances, centers, trusted, changes }
    }

    fn on_ground(&self, i: usize) -> bool {
        matches!(self.scene.objects[i].parent, Parent::Root(Root::Ground | Root::GroundWall))
            && self.scene.objects[i].relation != Relation::Hanging
    }

    fn vertical(&self) -> Vertical {
        let objects = self.scene.objects.iter().enumerate();
        let votes: Vec<_> = objects
            .filter_map(|(i, object)| vertical::vote(object, &self.stances[i], self.held(i).is_none(), self.trusted))
            .collect();
        vertical::vertical(&votes)
    }

    fn center(&self, i: usize) -> DVec3 {
        let pose = &self.scene.objects[i].pose;
        pose.point(self.centers[i])
    }

    /// The point about which the scene is turned: the mean of the objects' middles.
    fn middle(&self) -> DVec3 {
        let count = self.centers.len().max(1) as f64;
        (0..self.centers.len()).map(|i| self.center(i)).sum::<DVec3>() / count
    }

    /// Moves objects, walls and ceiling rigidly.
    fn transform(&mut self, place: impl Fn(DVec3) -> DVec3, turn: DQuat) {
        // The ceiling stays level; the point of it above the middle of the scene moves along.
        let middle = self.middle();
        if let Some(ceiling) = &mut self.scene.room.ceiling {
            *ceiling = place(middle.with_y(*ceiling)).y;
        }
        for wall in &mut self.scene.room.walls {
            wall.point = place(wall.point);
            wall.normal = turn * wall.normal;
        }
        for object in &mut self.scene.objects {
            object.pose = Pose {
                rotation: if turn == DQuat::IDENTITY {
                    object.pose.rotation
                } else {
                    turned(turn, object.pose.rotation)
                },
                translation: place(object.pose.translation),
            };
        }
    }

    /// Sets objects upright, bearers first.
    fn set_upright(&mut self) {
        for i in self.scene.bearers_first() {
            let trusted = self.trusted;
            let (turn, why) = match self.held(i) {
                Some(why) => (DQuat::IDENTITY, why),
                None => match upright::judge(&self.stances[i], &self.scene.objects[i].pose, trusted) {
                    Verdict::Upright => (DQuat::IDENTITY, "stands upright"),
                    Verdict::Leans(turn) if self.is_at_wall(i) && self.falls_over(i, turn) => {
                        (DQuat::IDENTITY, "leans on its wall: alone it would fall over")
                    }
                    Verdict::Leans(turn) => (turn, "leaned on a flat base"),
                    Verdict::TurnedOver(turn) => (turn, "was upside down on next to nothing, has a base to stand on"),
                    Verdict::UpsideDown => (DQuat::IDENTITY, "upside down, but stands well so"),
                    Verdict::NoBase => (DQuat::IDENTITY, "no flat base below it"),
                },
            };
            self.changes[i].why_turned = why.to_owned();
            if turn != DQuat::IDENTITY {
                self.changes[i].turned_degrees = turn.to_axis_angle().1.to_degrees();
                let center = self.center(i);
                self.carry(i, |point| center + turn * (point - center), turn);
            }
        }
    }

    fn is_at_wall(&self, i: usize) -> bool {
        self.scene.objects[i].parent == Parent::Root(Root::GroundWall)
    }

    /// True if an object that `turn` would set upright has its centre of mass beside its base as it is.
    fn falls_over(&self, i: usize, turn: DQuat) -> bool {
        let pose = &self.scene.objects[i].pose;
        let vertices: Vec<DVec3> = self.meshes[i].vertices.iter().map(|v| turn * pose.point(v.as_dvec3())).collect();
        !stance::is_over_base(&vertices, turn * self.center(i), turn * DVec3::NEG_Y)
    }

    /// Why an object only follows; none for what stands or lies on something.
    fn held(&self, i: usize) -> Option<&'static str> {
        let object = &self.scene.objects[i];
        match (object.movable, object.relation, object.parent) {
            (false, ..) => Some("not movable"),
            (_, _, Parent::Root(Root::Wall)) => Some("on a wall"),
            (_, _, Parent::Root(Root::Ceiling)) => Some("on the ceiling"),
            (_, Relation::Hanging, _) => Some("hangs"),
            // A radiator is fastened to the wall, but it stands on the ground.
            (_, Relation::Attached, Parent::Object(_)) => Some("attached"),
            _ => None,
        }
    }

    /// Height of the ground as the objects on it tell: the median of their lowest points, m.
    fn ground(&self) -> f64 {
        let mut lowest: Vec<f64> =
            (0..self.meshes.len()).filter(|&i| self.on_ground(i)).map(|i| self.surface(i).low.y).collect();
        lowest.sort_by(f64::total_cmp);
        match lowest.len() {
            0 => 0.0,
            n => 0.5 * (lowest[(n - 1) / 2] + lowest[n / 2]),
        }
    }

    /// Raises or lowers every object onto what bears it, bearers first, each with everything on it.
    fn set_heights(&mut self) {
        for i in self.scene.bearers_first() {
            let (raise, why) = match (self.held(i), self.scene.objects[i].parent) {
                (Some(why), _) => (0.0, why.to_owned()),
                (None, Parent::Root(_)) => (-self.surface(i).low.y, "stands on the ground".to_owned()),
                (None, Parent::Object(bearer)) => self.rest(i, bearer),
            };
            self.changes[i].raised = raise;
            self.changes[i].why_raised = why;
            self.carry(i, |point| point + DVec3::Y * raise, DQuat::IDENTITY);
        }
    }

    fn rest(&self, i: usize, bearer: usize) -> (f64, String) {
        let name = &self.scene.objects[bearer].name;
        match support::rest(&self.surface(i), &self.surface(bearer)) {
            None => (0.0, format!("nothing of \"{name}\" to stand on")),
            Some(rest) if rest.beside > 0.0 => (
                rest.raise,
                format!("{:.0} mm beside \"{name}\", at the height of its nearest place", 1e3 * rest.beside),
            ),
            Some(rest) if rest.raise.abs() > FAR => {
                (rest.raise, format!("stands on \"{name}\", far from where it was"))
            }
            Some(rest) => (rest.raise, format!("stands on \"{name}\"")),
        }
    }

    /// The mesh of an object in the world.
    fn surface(&self, i: usize) -> Surface {
        let (pose, mesh) = (&self.scene.objects[i].pose, &self.meshes[i]);
        let vertices: Vec<DVec3> = mesh.vertices.iter().map(|v| pose.point(v.as_dvec3())).collect();
        Surface::new(mesh.triangles.iter().map(|t| t.map(|i| vertices[i as usize])).collect())
    }

    /// Moves an object and everything movable on it.
    fn carry(&mut self, i: usize, place: impl Fn(DVec3) -> DVec3, turn: DQuat) {
        for i in self.scene.subtree(i, |child| self.scene.objects[child].movable) {
            let pose = &mut self.scene.objects[i].pose;
            pose.translation = place(pose.translation);
            if turn != DQuat::IDENTITY {
                pose.rotation = turned(turn, pose.rotation);
            }
        }
    }
}

fn turned(turn: DQuat, rotation: DQuat) -> DQuat {
    (turn * rotation).normalize()
}
