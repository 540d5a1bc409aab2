//! The room around the objects: walls and a ceiling, given by the scene or else fitted to its objects (`fit`), and what
//! belongs on them put there (`place`, `free`).
//!
//! What hangs on a wall or ceiling is placed before the search, on the furniture's way from the ground up: what it
//! bears needs a parent that stands where it will stay, and what stands below has to know what it must not run into. A
//! wall also bears: it is a static body in every simulation, as far as the furniture really stands inside it.

mod fit;
mod free;
mod outline;
mod place;
mod tolerances;

pub(super) use place::Placer;
pub(super) use tolerances::{CONTACT, LEANING, TOUCHES};

use super::posture::{lean, up_axis};
use crate::scene::{Parent, Pose, Relation, Root, Scene, Wall};
use crate::shape::{Shape, box_corners};
use crate::world::{self, BodyDef, STATIC};
use glam::{DMat3, DQuat, DVec3, Vec3};
use outline::Outline;
use serde::Serialize;
use tolerances::{
    ASTRAY, BEYOND, DEPTH_SHARE, LEAST_LEAN, MAX_INSIDE, MAX_LEAN_ON, MAX_PULL, STEEPEST, THICKNESS, TOWARDS,
};

/// A wall or the ceiling.
#[derive(Clone, Debug, PartialEq)]
pub struct Side {
    /// The wall's name in the scene, else what it is.
    pub name: String,
    /// What hangs on it: `Root::Wall` or `Root::Ceiling`.
    pub kind: Root,
    /// A point of its plane, m.
    pub point: DVec3,
    /// Unit vector into the room.
    pub normal: DVec3,
    /// True if the scene does not give it.
    pub fitted: bool,
    /// True for a wall that things can lean on in the simulation.
    pub bears: bool,
    /// True if something was set to lean on it.
    pub leant_on: bool,
}

impl Side {
    /// How far a point is inside the room, m.
    pub fn height(&self, point: DVec3) -> f64 {
        (point - self.point).dot(self.normal)
    }

    /// How far the outermost of the points is inside the room, m; negative beyond the wall, +∞ without points.
    pub fn gap(&self, points: impl Iterator<Item = DVec3>) -> f64 {
        points.map(|p| self.height(p)).fold(f64::INFINITY, f64::min)
    }

    /// What it is called in a sentence.
    fn title(&self) -> String {
        if self.kind == Root::Wall { format!("wall \"{}\"", self.name) } else { self.name.clone() }
    }

    /// The rotation of an object that leans on this wall squarely: straight towards it, as far as it does, with its flat
    /// side along it. As it is if it leans elsewhere.
    pub(super) fn leant_on_by(&self, form: &Form, pose: &Pose) -> DQuat {
        let towards = -self.normal.with_y(0.0).normalize_or_zero();
        let up = up_axis(pose);
        if lean(pose) > LEANING && up.with_y(0.0).normalize_or_zero().dot(towards) < TOWARDS {
            return pose.rotation;
        }
        let lean = up.dot(towards).atan2(up.y).max(LEAST_LEAN);
        let level = DQuat::from_rotation_arc(up, DVec3::Y) * pose.rotation;
        let outline = Outline::new(form.mesh(&Pose { rotation: level, ..*pose }));
        let yaw = DQuat::from_rotation_y(outline.turn_to(towards).unwrap_or(0.0));
        (DQuat::from_axis_angle(DVec3::Y.cross(towards), lean) * yaw * level).normalize()
    }

    /// Two unit vectors along the plane; of a wall, sideways and up.
    fn along(&self) -> [DVec3; 2] {
        let sideways = DVec3::Y.cross(self.normal).try_normalize().unwrap_or(DVec3::X);
        [sideways, self.normal.cross(sideways)]
    }
}

/// The walls and the ceiling of a run; the ground is y = 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Room {
    /// Walls in the scene's order, then the ceiling.
    pub sides: Vec<Side>,
    /// For every object that was put onto a wall or ceiling: the index of that side.
    pub hung: Vec<Option<usize>>,
}

/// What was done to put an object onto its wall or ceiling, or inside the walls.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Placement {
    /// Index of the wall or ceiling among the room's sides; none if it was left alone.
    #[serde(skip)]
    pub side: Option<usize>,
    /// Its name.
    pub surface: Option<String>,
    /// By how much it was turned about the vertical, rad.
    pub yaw: f64,
    /// By how much a lean was corrected, rad.
    pub lean: f64,
    /// How far it was moved away from the surface (negative: towards it), m.
    pub shift: f64,
    /// How far it was moved along the surface to a free place, m.
    pub slide: f64,
    /// Distance of its mesh from the surface in the result, m; negative if it reaches through.
    pub clearance: Option<f64>,
    /// Why it does not touch, was left alone, or is worth a look; may be empty.
    pub note: String,
}

/// The corners of an object in its own frame, m.
pub(super) struct Form {
    /// Of its mesh; of its parts if that is empty.
    mesh: Vec<DVec3>,
    /// Of its mesh and its parts.
    solid: Vec<DVec3>,
}

impl Form {
    fn new(shape: &Shape) -> Self {
        let parts = || shape.parts.iter().flat_map(|part| &part.vertices).map(|v| v.as_dvec3());
        let mut mesh: Vec<DVec3> = shape.surface.vertices.iter().map(|v| v.as_dvec3()).collect();
        let solid = mesh.iter().copied().chain(parts()).collect();
        if mesh.is_empty() {
            mesh = parts().collect();
        }
        Self { mesh, solid }
    }

    /// Of all objects, in the scene's order.
    pub fn all(shapes: &[Shape]) -> Vec<Self> {
        shapes.iter().map(Self::new).collect()
    }

    /// The corners of the mesh in the world.
    pub fn mesh(&self, pose: &Pose) -> impl Iterator<Item = DVec3> {
        posed(&self.mesh, *pose)
    }

    /// The corners of the mesh and the parts in the world: what a simulated wall must not meet.
    pub fn solid(&self, pose: &Pose) -> impl Iterator<Item = DVec3> {
        posed(&self.solid, *pose)
    }

    /// Lowest and highest corner of the mesh in the world.
    pub fn bounds(&self, pose: &Pose) -> [DVec3; 2] {
        bounds(self.mesh(pose))
    }
}

fn posed(points: &[DVec3], pose: Pose) -> impl Iterator<Item = DVec3> {
    points.iter().map(move |p| pose.point(*p))
}

fn bounds(points: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    points.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

/// What a wall of the scene is called, the `i`-th.
fn name_of(i: usize, wall: &Wall) -> String {
    if wall.name.is_empty() { format!("wall {}", i + 1) } else { wall.name.clone() }
}

/// False for what a scene calls a wall, but is a floor or a ceiling.
fn stands_upright(wall: &Wall) -> bool {
    wall.normal.y.abs() < STEEPEST
}

impl Room {
    /// The scene's walls and ceiling; what it does not give but its objects imply is fitted to their `layout`.
    pub(super) fn new(scene: &Scene, forms: &[Form], layout: &[Pose]) -> Self {
        let mut sides: Vec<Side> = (scene.room.walls.iter().enumerate())
            .filter(|(_, wall)| stands_upright(wall))
            .map(|(i, wall)| Side {
                name: name_of(i, wall),
                kind: Root::Wall,
                point: wall.point,
                normal: wall.normal,
                fitted: false,
                bears: true,
                leant_on: false,
            })
            .collect();
        let needs = |roots: &[Root]| {
            (scene.objects.iter()).any(|object| roots.iter().any(|root| object.parent == Parent::Root(*root)))
        };
        if sides.is_empty() && needs(&[Root::Wall, Root::GroundWall]) {
            sides = fit::walls(scene, forms, layout);
        }
        let fitted = scene.room.ceiling.is_none();
        if !fitted || needs(&[Root::Ceiling]) {
            let height = scene.room.ceiling.unwrap_or_else(|| fit::ceiling(scene, forms, layout));
            let (point, normal) = (DVec3::Y * height, DVec3::NEG_Y);
            sides.push(Side {
                name: "ceiling".into(),
                kind: Root::Ceiling,
                point,
                normal,
                fitted,
                bears: false,
                leant_on: false,
            });
        }
        let mut room = Self { sides, hung: vec![None; layout.len()] };
        for side in &mut room.sides {
            let beyond = |&i: &usize| stands(scene, i) && side.gap(forms[i].mesh(&layout[i])) < -MAX_INSIDE;
            side.bears &= !(0..layout.len()).any(|i| beyond(&i));
        }
        room
    }

    /// The side that an object was put onto.
    pub(super) fn side_of(&self, object: usize) -> Option<usize> {
        self.hung.get(object).copied().flatten()
    }

    /// The walls, with their indices.
    pub(super) fn walls(&self) -> impl Iterator<Item = (usize, &Side)> {
        self.sides.iter().enumerate().filter(|(_, side)| side.kind == Root::Wall)
    }

    /// Height of the ceiling, m.
    pub(super) fn ceiling(&self) -> Option<f64> {
        self.sides.iter().find(|side| side.kind == Root::Ceiling).map(|side| side.point.y)
    }

    /// The side of a kind that an object belongs to which `hangs` on it, or else stands at it, as an index.
    pub(super) fn nearest(&self, kind: Root, hangs: bool, form: &Form, pose: &Pose) -> Option<usize> {
        let of_kind = self.sides.iter().enumerate().filter(|(_, side)| side.kind == kind);
        let costs = of_kind.map(|(i, side)| (i, remoteness(form, pose, hangs, side.normal, side.point)));
        costs.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    }

    /// The wall that an object may lean on: the nearest, unless it is too far away or nothing can lean on it.
    pub(super) fn wall_to_lean_on(&self, form: &Form, pose: &Pose) -> Option<&Side> {
        let wall = &self.sides[self.nearest(Root::Wall, false, form, pose)?];
        let near = (-MAX_INSIDE..=MAX_PULL).contains(&wall.gap(form.solid(pose)));
        (near && (wall.bears || wall.fitted)).then_some(wall)
    }

    /// Lets fitted walls bear what leans on them, and leaves out those that nothing hangs or leans on: a guess that is
    /// not needed changes nothing.
    pub(super) fn keep_needed(&mut self, scene: &Scene, forms: &[Form], leaning: &[usize], layout: &[Pose]) {
        for &object in leaning {
            if let Some(wall) = self.nearest(Root::Wall, false, &forms[object], &layout[object]) {
                self.sides[wall].bears = true;
                self.sides[wall].leant_on = true;
            }
        }
        let hung = (0..scene.objects.len()).filter(|&i| hangs_on(scene, i) == Some(Root::Wall));
        let hung_on: Vec<usize> = hung.filter_map(|i| self.nearest(Root::Wall, true, &forms[i], &layout[i])).collect();
        let mut index = 0..;
        self.sides.retain(|side| {
            let is_hung_on = index.next().is_some_and(|index| hung_on.contains(&index));
            side.kind != Root::Wall || !side.fitted || side.bears || is_hung_on
        });
    }

    /// Static bodies for such walls that bear, around the objects of a layout.
    pub(super) fn bodies(&self, which: fn(&Side) -> bool, forms: &[Form], layout: &[Pose]) -> Vec<BodyDef> {
        let extents = bounds(forms.iter().zip(layout).flat_map(|(form, pose)| form.solid(pose)));
        self.sides.iter().filter(|side| side.bears && which(side)).map(|side| body(side, extents)).collect()
    }
}

/// A wall as a box behind its plane, beside everything between `low` and `high`.
pub(super) fn body(side: &Side, [low, high]: [DVec3; 2]) -> BodyDef {
    let [sideways, up] = side.along();
    let corners = (0..8).map(|i| DVec3::select(glam::BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), low, high));
    let span = |axis: DVec3| {
        let along = corners.clone().map(|corner| corner.dot(axis));
        along.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)])
    };
    let [[left, right], [bottom, top]] = [span(sideways), span(up)];
    let half = DVec3::new(0.5 * (right - left) + BEYOND, 0.5 * (top - bottom) + BEYOND, 0.5 * THICKNESS);
    let behind = side.point.dot(side.normal) - half.z;
    let center = sideways * (0.5 * (left + right)) + up * (0.5 * (bottom + top)) + side.normal * behind;
    let rotation = DQuat::from_mat3(&DMat3::from_cols(sideways, up, side.normal)).normalize();
    let pose = world::Pose::new(rotation.as_quat().normalize(), center.as_vec3());
    BodyDef {
        parts: vec![box_corners(half.as_vec3())],
        mass: 1.0,
        inertia: Vec3::ONE,
        unit: STATIC,
        start: pose,
        reference: pose,
    }
}

/// How little an object belongs to a plane, m. What hangs: how far its middle is from it and how deep it is across, so
/// that a picture in a corner belongs to the wall that it is flat on. What stands: how far its back is from it, and if
/// that is about as far from two, how deep it is. What leans belongs to the wall that it leans towards.
pub(super) fn remoteness(form: &Form, pose: &Pose, hangs: bool, normal: DVec3, point: DVec3) -> f64 {
    let [low, high] = form
        .mesh(pose)
        .map(|p| (p - point).dot(normal))
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], height| [low.min(height), high.max(height)]);
    let leans = (LEANING..MAX_LEAN_ON).contains(&lean(pose));
    let astray = leans && up_axis(pose).with_y(0.0).normalize_or_zero().dot(-normal) < TOWARDS;
    let depth = high - low;
    let far = if hangs { (0.5 * (low + high)).abs() + depth } else { low.abs() + DEPTH_SHARE * depth };
    far + if astray { ASTRAY } else { 0.0 }
}

/// The root that a static, movable object is placed on: what is on a wall or ceiling, or hangs at a wall down to the
/// ground, as curtains do.
pub(super) fn hangs_on(scene: &Scene, object: usize) -> Option<Root> {
    let object = &scene.objects[object];
    match (object.parent, object.relation) {
        (Parent::Root(kind @ (Root::Wall | Root::Ceiling)), _) => Some(kind),
        (Parent::Root(Root::GroundWall), Relation::Hanging) => Some(Root::Wall),
        _ => None,
    }
}

/// True for what moves in the simulation and stands on the ground, or on something that does.
pub(super) fn stands(scene: &Scene, object: usize) -> bool {
    let lowest = scene.bearers(object).last().unwrap_or(object);
    !scene.is_static(object) && hangs_on(scene, lowest).is_none()
}
