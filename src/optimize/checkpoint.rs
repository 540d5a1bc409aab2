//! What a run needs to go on after an interruption: written after every group and before every round of the second
//! opinion, read by `--resume`.
//!
//! Hashes of the scene, the shapes and the configuration guard against going on with something else. Poses are stored
//! as shortest decimals that read back to the same bits, so a resumed run ends exactly where an uninterrupted one does.

use super::{Config, GroupRecord, IterationRecord, OptimizeError};
use crate::scene::{self, Scene};
use crate::shape::Shape;
use blake3::Hasher;
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

const VERSION: u32 = 3;

/// State of a run between two groups, or between two rounds of its second opinion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Checkpoint {
    version: u32,
    seed: u64,
    config: String,
    scene: String,
    shapes: String,
    /// Groups that are done, in the order of the plan.
    pub(super) completed: usize,
    /// Pose of every object: translation, then rotation xyzw.
    layout: Vec<[f64; 7]>,
    pub(super) groups: Vec<GroupRecord>,
    pub(super) iterations: Vec<IterationRecord>,
    pub(super) notes: Vec<String>,
    opinion: Option<Opinion>,
}

/// State of the second opinion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Opinion {
    progress: Progress,
    /// Pose of every object in the best layout so far.
    layout: Vec<[f64; 7]>,
}

/// How far the second opinion is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Progress {
    /// Rounds that are done.
    pub rounds: u32,
    /// How many of the last of them found nothing better.
    pub idle: u32,
}

impl Checkpoint {
    /// The state before the first group.
    pub(super) fn start(scene: &Scene, shapes: &[Shape], config: &Config, seed: u64) -> Self {
        let layout: Vec<scene::Pose> = scene.objects.iter().map(|object| object.pose).collect();
        let mut checkpoint = Self {
            version: VERSION,
            seed,
            config: hash_config(config),
            scene: hash_scene(scene),
            shapes: hash_shapes(shapes),
            completed: 0,
            layout: Vec::new(),
            groups: Vec::new(),
            iterations: Vec::new(),
            notes: Vec::new(),
            opinion: None,
        };
        checkpoint.set_layout(&layout);
        checkpoint
    }

    /// Reads what `to_json` wrote.
    ///
    /// # Errors
    /// `OptimizeError::Checkpoint` if the text is no checkpoint.
    pub fn from_json(text: &str) -> Result<Self, OptimizeError> {
        serde_json::from_str(text).map_err(|error| {
            OptimizeError::Checkpoint(format!("it cannot be read ({error}); delete it and start without --resume"))
        })
    }

    /// The checkpoint as one JSON object.
    pub fn to_json(&self) -> String {
        // Plain numbers and strings cannot fail to serialize.
        serde_json::to_string(self).unwrap_or_default()
    }

    /// What only a damaged file violates: records of exactly the groups that are done, and poses.
    fn is_whole(&self, groups: usize) -> bool {
        let records = self.groups.len() == self.completed && self.completed <= groups;
        let iterations = self.iterations.iter().all(|record| record.group < self.completed);
        let poses = |layout: &[[f64; 7]]| {
            let mut poses = layout.iter().map(pose);
            poses.all(|pose| scene::is_near(pose.translation) && pose.rotation.is_normalized())
        };
        let opinion = self.opinion.as_ref().is_none_or(|opinion| {
            self.completed == groups && opinion.layout.len() == self.layout.len() && poses(&opinion.layout)
        });
        records && iterations && poses(&self.layout) && opinion
    }

    /// Refuses a checkpoint of another run. `fresh` is the start of this one, which has so many `groups`.
    pub(super) fn check(&self, fresh: &Self, groups: usize) -> Result<(), OptimizeError> {
        let of_another = |what: &str| {
            let again = format!("give the same {what} again, or start without --resume");
            Err(OptimizeError::Checkpoint(format!("it was made with another {what}; {again}")))
        };
        if self.version != fresh.version {
            return of_another("version of this program");
        }
        if self.seed != fresh.seed {
            let (was, is) = (self.seed, fresh.seed);
            let problem =
                format!("it was made with seed {was}, not {is}; give --seed {was}, or start without --resume");
            return Err(OptimizeError::Checkpoint(problem));
        }
        if self.config != fresh.config {
            return of_another("configuration");
        }
        if self.scene != fresh.scene || self.layout.len() != fresh.layout.len() {
            return of_another("scene");
        }
        if self.shapes != fresh.shapes {
            return of_another("set of convex parts");
        }
        if !self.is_whole(groups) {
            let problem = "its content does not fit together; delete it and start without --resume";
            return Err(OptimizeError::Checkpoint(problem.into()));
        }
        Ok(())
    }

    /// Pose of every object.
    pub(super) fn layout(&self) -> Vec<scene::Pose> {
        self.layout.iter().map(pose).collect()
    }

    /// How far the second opinion is, and the best layout that it has found; none before its first round.
    pub(super) fn opinion(&self) -> Option<(Progress, Vec<scene::Pose>)> {
        self.opinion.as_ref().map(|opinion| (opinion.progress, opinion.layout.iter().map(pose).collect()))
    }

    pub(super) fn set_opinion(&mut self, progress: Progress, layout: &[scene::Pose]) {
        self.opinion = Some(Opinion { progress, layout: layout.iter().map(numbers).collect() });
    }

    pub(super) fn set_layout(&mut self, layout: &[scene::Pose]) {
        self.layout = layout.iter().map(numbers).collect();
    }
}

fn numbers(pose: &scene::Pose) -> [f64; 7] {
    let ([x, y, z], [i, j, k, w]) = (pose.translation.to_array(), pose.rotation.to_array());
    [x, y, z, i, j, k, w]
}

fn pose(&[x, y, z, i, j, k, w]: &[f64; 7]) -> scene::Pose {
    scene::Pose { rotation: DQuat::from_xyzw(i, j, k, w), translation: DVec3::new(x, y, z) }
}

/// Names what a run depends on: poses and tree of the scene, the bodies, and the configuration. Equal for equal runs.
pub fn identity(scene: &Scene, shapes: &[Shape], config: &Config) -> String {
    let parts = [hash_scene(scene), hash_shapes(shapes), hash_config(config)];
    blake3::hash(parts.concat().as_bytes()).to_hex().to_string()
}

fn hash_config(config: &Config) -> String {
    blake3::hash(serde_json::to_string(config).unwrap_or_default().as_bytes()).to_hex().to_string()
}

fn hash_scene(scene: &Scene) -> String {
    let mut hasher = Hasher::new();
    for (i, object) in scene.objects.iter().enumerate() {
        let held = (object.relation, object.movable);
        let tree = format!("{:?} {:?} {held:?} {}", object.name, object.parent, scene.is_static(i));
        hasher.update(tree.as_bytes());
        hasher.update(bytemuck::bytes_of(&numbers(&object.pose)));
    }
    hasher.update(format!("{:?}", scene.room).as_bytes());
    hasher.finalize().to_hex().to_string()
}

fn hash_shapes(shapes: &[Shape]) -> String {
    let mut hasher = Hasher::new();
    for shape in shapes {
        let mass = &shape.mass;
        hasher.update(bytemuck::bytes_of(&[mass.mass.to_bits(), shape.parts.len() as u32]));
        hasher.update(bytemuck::bytes_of(&[mass.center, mass.inertia]));
        hasher.update(bytemuck::bytes_of(&mass.axes));
        let others = shape.alternatives.iter().flat_map(|other| &other.parts);
        for part in shape.parts.iter().chain(others) {
            hasher.update(&(part.vertices.len() as u64).to_le_bytes());
            hasher.update(bytemuck::cast_slice(&part.vertices));
        }
    }
    hasher.finalize().to_hex().to_string()
}
