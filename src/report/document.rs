//! `report.json`: everything that a run can tell about its result.

use super::Summary;
use crate::canonicalize::Canonicalization;
use crate::optimize::{Config, GroupRecord, IterationRecord, MeshOverlap, ObjectOutcome, Outcome, Placement, Side};
use crate::scene::{Pose, Scene};
use crate::shape::{Quality, Shape};
use crate::world::{Energy, KernelTime, Status};
use serde::Serialize;
use std::collections::BTreeMap;

/// What the report says of the run as such.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Run<'a> {
    /// The scene as the user named it.
    pub input: &'a str,
    /// Name and processor of the simulator.
    pub backend: &'a str,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Time that the convex parts took, s.
    #[serde(skip)]
    pub shape_seconds: f64,
    /// What was done to the scene before, if it was made canonical; all distances count from there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub canonicalization: Option<&'a Canonicalization>,
}

/// The document. Lengths in m, angles in rad, times in s, unless a name says otherwise.
#[derive(Debug, Serialize)]
pub struct Report<'a> {
    tool: &'static str,
    version: &'static str,
    pub(super) scene: &'a str,
    #[serde(flatten)]
    pub(super) run: Run<'a>,
    pub(super) finished: bool,
    pub(super) summary: Summary,
    pub(super) notes: Vec<&'a str>,
    pub(super) objects: Vec<Object<'a>>,
    /// Walls and ceiling as the run took them.
    room: Vec<RoomSide<'a>>,
    /// Pairs whose meshes still meet.
    pub(super) mesh_overlaps: Vec<Overlap<'a>>,
    pub(super) groups: Vec<Group<'a>>,
    pub(super) iterations: Vec<Iteration<'a>>,
    /// Candidates of the whole run by status bit.
    status: BTreeMap<&'static str, u64>,
    settled_after: f64,
    at_rest: bool,
    seconds: Seconds,
    /// What each kernel took in all groups, ms, where the backend tells.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "KernelTime::by_name")]
    kernels_ms: Vec<KernelTime>,
    config: &'a Config,
}

#[derive(Debug, Serialize)]
pub(super) struct Object<'a> {
    pub(super) name: &'a str,
    pub(super) simulated: bool,
    pub(super) moved: f64,
    pub(super) turned: f64,
    pub(super) stable: bool,
    stable_otherwise: bool,
    pub(super) fallen: bool,
    pub(super) lost_support: bool,
    /// What put it onto its wall or ceiling, or inside the walls.
    #[serde(skip_serializing_if = "Option::is_none")]
    placement: Option<&'a Placement>,
    exact: Exact,
    pub(super) check: Check,
    mass: f32,
    shape: &'a Quality,
    notes: &'a [String],
}

/// A wall or the ceiling, in the frame and unit of the file.
#[derive(Debug, Serialize)]
struct RoomSide<'a> {
    name: &'a str,
    /// `wall` or `ceiling`.
    kind: &'static str,
    point: [f64; 3],
    /// Into the room.
    normal: [f64; 3],
    /// True if the scene does not give it.
    fitted: bool,
    /// True if it was a body in the simulation.
    bears: bool,
}

/// What the exact step did with the object, m.
#[derive(Debug, Serialize)]
struct Exact {
    /// Upwards.
    raised: f64,
    /// Sideways.
    shifted: f64,
    /// How far its mesh could fall before it meets another or the ground: the clearance at which it rests. None if that
    /// is more than 5 cm.
    clearance: Option<f64>,
}

#[derive(Debug, Serialize)]
pub(super) struct Overlap<'a> {
    pub(super) a: &'a str,
    pub(super) b: &'a str,
    /// The shortest shift that would part them, m; none if none within reach does.
    pub(super) depth: Option<f64>,
}

/// What the check measured from the result on.
#[derive(Debug, Serialize)]
pub(super) struct Check {
    pub(super) drift: f64,
    turn: f64,
    peak_speed: f64,
    peak_spin: f64,
    /// The object's share of the energy, measured over the check instead of a candidate's simulation.
    pub(super) terms: Terms,
}

/// Unweighted: stability in m + rad, velocity in m/s, penetration (the deepest overlap with another object) in m,
/// layout in λ_pos m + rad.
#[derive(Debug, Serialize)]
pub(super) struct Terms {
    stability: f64,
    velocity: f64,
    pub(super) penetration: f64,
    layout: f64,
}

#[derive(Debug, Serialize)]
pub(super) struct Group<'a> {
    pub(super) name: &'a str,
    units: &'a [String],
    best: Option<Energy>,
    /// Iteration and candidate, for a replay.
    winner: Option<(u32, u32)>,
    status: BTreeMap<&'static str, u64>,
    /// Steps of candidates: simulated, and without pruning.
    candidate_steps: u64,
    candidate_steps_unpruned: u64,
    seconds: f64,
}

#[derive(Debug, Serialize)]
pub(super) struct Iteration<'a> {
    pub(super) group: usize,
    pub(super) iteration: u32,
    pub(super) best: &'a Energy,
    iteration_best: f32,
    elite_mean: f32,
    status: BTreeMap<&'static str, u64>,
}

#[derive(Debug, Serialize)]
struct Seconds {
    shapes: f64,
    seat: f64,
    local: f64,
    global: f64,
    settle: f64,
    exact: f64,
    verify: f64,
}

impl<'a> Report<'a> {
    /// Puts together what is known. All lists are in the scene's order.
    pub fn new(run: Run<'a>, scene: &'a Scene, shapes: &'a [Shape], config: &'a Config, outcome: &'a Outcome) -> Self {
        let objects = (scene.objects.iter().zip(shapes).zip(&outcome.objects).zip(exact(outcome)))
            .zip(&outcome.placements)
            .map(|((((object, shape), outcome), exact), placement)| {
                let object = self::object(&object.name, shape, config, outcome, exact);
                Object { placement: placement.as_ref(), ..object }
            })
            .collect();
        let name = |object: usize| scene.objects[object].name.as_str();
        let overlap = |&MeshOverlap { objects: [a, b], depth }: &MeshOverlap| Overlap { a: name(a), b: name(b), depth };
        let mut flagged = [0; Status::FAULTS.len()];
        for group in &outcome.groups {
            for (sum, count) in flagged.iter_mut().zip(group.flagged) {
                *sum += count;
            }
        }
        let timings = &outcome.timings;
        Self {
            tool: env!("CARGO_PKG_NAME"),
            version: env!("CARGO_PKG_VERSION"),
            scene: &scene.name,
            run,
            finished: outcome.finished,
            summary: Summary::new(scene, outcome),
            notes: scene.warnings.iter().chain(&outcome.notes).map(String::as_str).collect(),
            objects,
            room: outcome.room.sides.iter().map(|side| room_side(scene, side)).collect(),
            mesh_overlaps: outcome.clearances.overlaps.iter().map(overlap).collect(),
            groups: outcome.groups.iter().map(group).collect(),
            iterations: (outcome.iterations.iter())
                .map(|IterationRecord { group, stats }| Iteration {
                    group: *group,
                    iteration: stats.iteration,
                    best: &stats.best,
                    iteration_best: stats.iteration_best,
                    elite_mean: stats.elite_mean,
                    status: named(&stats.flagged.map(u64::from)),
                })
                .collect(),
            status: named(&flagged),
            settled_after: outcome.settled_after,
            at_rest: outcome.at_rest,
            seconds: Seconds {
                shapes: run.shape_seconds,
                seat: timings.seat,
                local: timings.local,
                global: timings.global,
                settle: timings.settle,
                exact: timings.exact,
                verify: timings.verify,
            },
            kernels_ms: kernels(&outcome.groups),
            config,
        }
    }

    /// The short version for people.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }
}

fn room_side<'a>(scene: &Scene, side: &'a Side) -> RoomSide<'a> {
    let [x, y, z, ..] = scene.pose_in_file(&Pose { translation: side.point, ..Pose::IDENTITY });
    RoomSide {
        name: &side.name,
        kind: side.kind.name(),
        point: [x, y, z],
        normal: scene.direction_in_file(side.normal).to_array(),
        fitted: side.fitted,
        bears: side.bears,
    }
}

fn exact(outcome: &Outcome) -> impl Iterator<Item = Exact> {
    let clearances = &outcome.clearances;
    clearances.shifts.iter().zip(&clearances.drops).map(|(shift, &clearance)| Exact {
        raised: shift.y,
        shifted: shift.x.hypot(shift.z),
        clearance,
    })
}

fn object<'a>(name: &'a str, shape: &'a Shape, config: &Config, outcome: &ObjectOutcome, exact: Exact) -> Object<'a> {
    Object {
        name,
        simulated: outcome.simulated,
        moved: outcome.moved,
        turned: outcome.turned,
        stable: outcome.stable,
        stable_otherwise: outcome.stable_otherwise,
        fallen: outcome.fallen,
        lost_support: outcome.lost_support,
        placement: None,
        exact,
        check: Check {
            drift: outcome.drift,
            turn: outcome.drift_turn,
            peak_speed: outcome.peak_speed,
            peak_spin: outcome.peak_spin,
            terms: Terms {
                stability: outcome.drift + outcome.drift_turn,
                velocity: outcome.peak_speed,
                penetration: outcome.overlap,
                layout: f64::from(config.energy.position) * outcome.moved + outcome.turned,
            },
        },
        mass: shape.mass.mass,
        shape: &shape.quality,
        notes: &shape.notes,
    }
}

fn group(record: &GroupRecord) -> Group<'_> {
    let [candidate_steps, candidate_steps_unpruned] = record.steps;
    Group {
        name: &record.name,
        units: &record.units,
        best: record.best,
        winner: record.winner,
        status: named(&record.flagged),
        candidate_steps,
        candidate_steps_unpruned,
        seconds: record.seconds,
    }
}

/// The sums over all groups, in the order of the first.
fn kernels(groups: &[GroupRecord]) -> Vec<KernelTime> {
    let mut sums: Vec<KernelTime> = Vec::new();
    for time in groups.iter().flat_map(|group| &group.kernels) {
        match sums.iter_mut().find(|sum| sum.name == time.name) {
            Some(sum) => sum.milliseconds += time.milliseconds,
            None => sums.push(time.clone()),
        }
    }
    sums
}

fn named(flagged: &[u64; Status::FAULTS.len()]) -> BTreeMap<&'static str, u64> {
    Status::FAULTS.iter().zip(flagged).map(|(fault, &count)| (fault.name, count)).collect()
}
