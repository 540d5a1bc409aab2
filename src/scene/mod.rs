//! The document: objects, poses and support tree of a `scene.json`, in metres, Y up, ground at y = 0.
//!
//! Reading (`read`, `fields`, `object`, `support`, `tree`) turns the file into checked objects and converts its frame
//! (`frame`); writing (`write`) puts the changed poses back into the document as it came, so that nothing that this
//! program does not know is lost. Every error names file, object, field and remedy (`error`).

mod error;
mod fields;
mod frame;
mod object;
mod read;
mod support;
mod tree;
mod write;

pub use error::SceneError;
pub use read::FILE;
pub use support::{Parent, Relation, Root};

use frame::Frame;
pub(crate) use frame::is_near;
use glam::{DQuat, DVec3};
use serde_json::Value;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// Longest side below which an object's size is taken for a mistake of unit, m.
pub const MIN_SIZE: f64 = 1e-3;
/// Longest side above which an object's size is taken for a mistake of unit, m.
pub const MAX_SIZE: f64 = 100.0;

/// Masses that an object may have, kg: from a needle of `MIN_SIZE` to a block of `MAX_SIZE`.
pub const MASSES: RangeInclusive<f64> = 1e-12..=1e10;

/// A rigid pose in metres, Y up: `world = rotation · (scale ∘ vertex) + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Unit quaternion.
    pub rotation: DQuat,
    /// Position of the mesh's origin, m.
    pub translation: DVec3,
}

impl Pose {
    /// The pose that leaves everything where it is.
    pub const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, translation: DVec3::ZERO };

    /// True if every number is.
    pub fn is_finite(&self) -> bool {
        self.rotation.is_finite() && self.translation.is_finite()
    }

    /// A point of the object, m, scale applied, in the world.
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.translation + self.rotation * point
    }
}

/// One object of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Unique, not empty.
    pub name: String,
    /// Free text; may be empty.
    pub category: String,
    /// The mesh file, resolved against the scene's folder; it existed when the scene was read.
    pub mesh: PathBuf,
    /// Where it is.
    pub pose: Pose,
    /// Metres per mesh unit along the mesh's axes, all > 0.
    pub scale: DVec3,
    /// What bears it.
    pub parent: Parent,
    /// How.
    pub relation: Relation,
    /// False: held where it is.
    pub movable: bool,
    /// kg, > 0, if the file gives it.
    pub mass: Option<f64>,
    /// Convex parts in the mesh's frame and unit, resolved as `mesh` is; empty if there are none.
    pub convex_parts: Vec<PathBuf>,
}

/// One wall: the plane through `point` with `normal` pointing into the room.
#[derive(Clone, Debug, PartialEq)]
pub struct Wall {
    /// May be empty.
    pub name: String,
    /// m.
    pub point: DVec3,
    /// Unit vector.
    pub normal: DVec3,
}

/// The room around the objects; its ground is y = 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Room {
    /// Height of the ceiling above the ground, m, if given.
    pub ceiling: Option<f64>,
    /// Walls in the file's order.
    pub walls: Vec<Wall>,
}

/// A scene that was read and found valid.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The document's `name`, else the name of its folder.
    pub name: String,
    /// The file it was read from.
    pub file: PathBuf,
    /// In the file's order. Poses, masses and convex parts may be changed; the rest stays as it was read.
    pub objects: Vec<Object>,
    /// Walls and ceiling; their places may be changed.
    pub room: Room,
    /// What the user should know although the scene is valid.
    pub warnings: Vec<String>,
    document: Value,
    frame: Frame,
    children: Vec<Vec<usize>>,
    /// Poses and convex parts as read: what still equals them is written back as it came.
    originals: Vec<(Pose, Vec<PathBuf>)>,
    /// The room as read.
    original_room: Room,
}

impl Scene {
    /// The objects that object `i` bears, in the scene's order.
    pub fn children(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        self.children[i].iter().copied()
    }

    /// Every object once, after all objects that it bears; otherwise in the scene's order.
    pub fn post_order(&self) -> Vec<usize> {
        tree::post_order(&self.objects, &self.children)
    }

    /// Every object once, after what bears it.
    pub fn bearers_first(&self) -> Vec<usize> {
        self.post_order().into_iter().rev().collect()
    }

    /// An object and its descendants, parents first, without those that `enter` refuses and theirs.
    pub fn subtree(&self, root: usize, enter: impl Fn(usize) -> bool) -> Vec<usize> {
        let mut found = vec![root];
        let mut next = 0;
        while next < found.len() {
            found.extend(self.children(found[next]).filter(|&child| enter(child)));
            next += 1;
        }
        found
    }

    /// What an object stands on, what that stands on, and so on.
    pub fn bearers(&self, object: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(self.parent(object), |&object| self.parent(object))
    }

    fn parent(&self, object: usize) -> Option<usize> {
        match self.objects[object].parent {
            Parent::Object(parent) => Some(parent),
            Parent::Root(_) => None,
        }
    }

    /// True for what takes no part in simulation: objects on a wall or ceiling, hanging ones and those not movable.
    pub fn is_static(&self, i: usize) -> bool {
        let object = &self.objects[i];
        !object.movable
            || object.relation == Relation::Hanging
            || matches!(object.parent, Parent::Root(Root::Wall | Root::Ceiling))
    }

    /// The scene with other poses, in its order.
    #[must_use]
    pub fn with_poses(&self, poses: impl IntoIterator<Item = Pose>) -> Self {
        let mut scene = self.clone();
        for (object, pose) in scene.objects.iter_mut().zip(poses) {
            object.pose = pose;
        }
        scene
    }

    /// The scene as if nothing were known of what bears what: every object stands by itself and may move.
    #[must_use]
    pub fn without_tree(&self) -> Self {
        let mut scene = self.clone();
        for object in &mut scene.objects {
            object.parent = Parent::Root(Root::Ground);
            object.relation = Relation::On;
            object.movable = true;
        }
        scene.children = vec![Vec::new(); scene.objects.len()];
        scene
    }

    /// Checks the longest side of object `i`, m, scale applied: reading a scene does not load its meshes.
    ///
    /// # Errors
    /// A side below [`MIN_SIZE`], above [`MAX_SIZE`] or not finite.
    pub fn check_size(&self, i: usize, extent: f64) -> Result<(), SceneError> {
        if (MIN_SIZE..=MAX_SIZE).contains(&extent) {
            return Ok(());
        }
        Err(SceneError::new(
            &self.file,
            format!("the object is {extent:.3e} m long, and only {MIN_SIZE} m to {MAX_SIZE} m are plausible"),
            "correct \"scale\", or \"frame\".\"meters_per_unit\" if all objects are concerned",
        )
        .object(&self.objects[i].name)
        .field("scale"))
    }
}
