//! The optimizer's flow on a backend without physics: groups, resumption, stopping, assessment.

#![allow(missing_docs, clippy::unwrap_used)]

use glam::{DQuat, DVec3, Quat, Vec3};
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::cpu::search::{CpuSearch, Record, Rollout};
use rest3d_gpu::optimize::{
    Checkpoint, Config, Event, ObjectOutcome, Observer, OptimizeError, Outcome, ResultFrom, run, run_on,
};
use rest3d_gpu::scene::{self, Parent, Root, Scene};
use rest3d_gpu::shape::{Alternative, MassProperties, Mesh, Part, Shape};
use rest3d_gpu::world::{
    Backend, BackendError, Best, Distribution, Energy, Flow, IterationStats, OnStep, Pose, STATIC, Search,
    SearchSettings, SimSettings, Status, Stream, Velocity, World,
};
use serde_json::{Value, json};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A simulator without forces: in a rollout everything that moves slides by `slide`; elsewhere it keeps still, but for
/// `tumble`, by which the body of that number turns in every simulation.
#[derive(Default)]
struct Fake {
    slide: Vec3,
    fails: bool,
    /// In a rollout, bodies overlap by what their boxes do along x, were they 0.4 m wide.
    overlap: bool,
    tumble: Option<(usize, Quat)>,
    worlds: Mutex<Vec<World>>,
    free_bytes: Option<u64>,
}

struct Slide<'a>(&'a World, Vec3, bool, bool);

impl Rollout for Slide<'_> {
    type Scratch = ();

    fn scratch(&self) {}

    fn run(&self, (): &mut (), placed: &[Pose], records: &mut [Record]) {
        let record = &mut records[0];
        for ((settled, placed), body) in record.settled.iter_mut().zip(placed).zip(&self.0.bodies) {
            *settled = *placed;
            if body.unit != STATIC {
                settled.translation += self.1;
            }
        }
        record.snapshot.fill(Velocity::default());
        for (depth, [a, b]) in record.depths_placed.iter_mut().zip(&self.0.pairs) {
            let apart = (placed[*a as usize].translation.x - placed[*b as usize].translation.x).abs();
            *depth = if self.3 { (0.4 - apart).max(0.0) } else { 0.0 };
        }
        record.depths_settled.fill(0.0);
        record.status = if self.2 { Status::NOT_FINITE } else { Status::default() };
    }
}

impl Backend for Fake {
    fn describe(&self) -> String {
        "fake".into()
    }

    fn simulate(
        &self,
        _: &World,
        settings: &SimSettings,
        starts: &[Pose],
        on_step: &mut OnStep<'_>,
    ) -> Result<Vec<Status>, BackendError> {
        let mut poses = starts.to_vec();
        if let Some((body, turn)) = self.tumble {
            poses[body].rotation = turn * poses[body].rotation;
        }
        for step in 0..settings.steps {
            if on_step(step, &poses, &vec![Velocity::default(); starts.len()]) == Flow::Stop {
                break;
            }
        }
        Ok(vec![if self.fails { Status::NOT_FINITE } else { Status::default() }])
    }

    fn free_bytes(&self) -> Option<u64> {
        self.free_bytes
    }

    fn overlaps(&self, world: &World, _: &SimSettings, _: &[Pose]) -> Result<Vec<f32>, BackendError> {
        Ok(vec![0.0; world.pairs.len()])
    }

    fn search<'a>(
        &'a self,
        world: &'a World,
        settings: &'a SearchSettings,
        stream: Stream,
    ) -> Result<Box<dyn Search + 'a>, BackendError> {
        self.worlds.lock().unwrap().push(world.clone());
        Ok(Box::new(CpuSearch::new(world, settings, stream, Slide(world, self.slide, self.fails, self.overlap))))
    }
}

/// Remembers what it is told; stops at the given iteration.
#[derive(Default)]
struct Watch {
    groups: Vec<String>,
    candidates: Vec<u64>,
    checkpoints: Vec<String>,
    iterations: usize,
    stop_at: Option<usize>,
}

impl Observer for Watch {
    fn event(&mut self, event: Event<'_>) -> Flow {
        match event {
            Event::Plan { groups, candidates, memory } => {
                self.groups = groups.to_vec();
                self.candidates = candidates.to_vec();
                assert!(!memory.is_empty());
            }
            Event::Iteration { .. } => {
                self.iterations += 1;
                if self.stop_at == Some(self.iterations) {
                    return Flow::Stop;
                }
            }
            Event::GroupDone { checkpoint, .. } => self.checkpoints.push(checkpoint.to_json()),
            Event::Seating | Event::Placing | Event::Settling => {}
            Event::Reconsidering { .. } | Event::Parting | Event::Verifying => {}
        }
        Flow::Continue
    }
}

/// A scene of boxes, built object by object.
#[derive(Default)]
struct Boxes {
    objects: Vec<Stored>,
    shapes: Vec<Shape>,
}

impl Boxes {
    /// A box of this size standing with its lowest face at the given place.
    fn add(&mut self, name: &'static str, parent: Parent, size: Vec3, foot: DVec3) -> usize {
        let half = 0.5 * size;
        let corner =
            |i: usize| half * Vec3::new((i & 1) as f32 - 0.5, (i >> 1 & 1) as f32 - 0.5, (i >> 2) as f32 - 0.5) * 2.0;
        // The mesh frame is off the centre of mass and off its axes, as real meshes are.
        let (center, axes) = (Vec3::new(0.3, 0.7, -0.2), Quat::from_rotation_y(0.4));
        let parts = vec![Part { vertices: (0..8).map(|i| axes * corner(i) + center).collect() }];
        let mass = MassProperties { mass: 2.0, center, axes, inertia: Vec3::splat(0.02) };
        self.shapes.push(Shape {
            // Nothing to part: what the exact step does is tested by itself.
            surface: Mesh::default(),
            alternative: Alternative { parts: parts.clone(), mass: mass.clone() },
            parts,
            mass,
            bounds: [Vec3::ZERO; 2],
            quality: Default::default(),
            notes: Vec::new(),
        });
        let rotation = DQuat::from_rotation_y(-0.4);
        let middle = foot + DVec3::Y * f64::from(half.y);
        let pose = scene::Pose { rotation, translation: middle - rotation * center.as_dvec3() };
        self.objects.push(Stored { name, parent, pose, movable: true });
        self.objects.len() - 1
    }

    /// The scene as a file says it, with poses that no decimal rounds.
    fn scene(&self) -> Scene {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("box.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        let parent = |parent| match parent {
            Parent::Object(i) => self.objects[i].name,
            WALL => "wall",
            _ => "ground",
        };
        let objects: Vec<_> = (self.objects.iter())
            .map(|o| json!({"name": o.name, "mesh": "box.obj", "parent": parent(o.parent), "movable": o.movable}))
            .collect();
        let file = folder.path().join("scene.json");
        let document = json!({"format": "rest3d-scene", "version": 1, "objects": objects});
        std::fs::write(&file, document.to_string()).unwrap();
        let mut scene = Scene::read(&file).unwrap();
        for (object, stored) in scene.objects.iter_mut().zip(&self.objects) {
            object.pose = stored.pose;
        }
        scene
    }
}

/// What a test says of an object.
struct Stored {
    name: &'static str,
    parent: Parent,
    pose: scene::Pose,
    movable: bool,
}

const GROUND: Parent = Parent::Root(Root::Ground);
const WALL: Parent = Parent::Root(Root::Wall);

/// table ← tray ← cup, chair, shelf on the wall ← vase, and a stone that may not move.
fn room() -> Boxes {
    let mut boxes = Boxes::default();
    let table = boxes.add("table", GROUND, Vec3::new(1.0, 0.7, 0.6), DVec3::new(1.0, 0.0, 0.0));
    let tray = boxes.add("tray", Parent::Object(table), Vec3::new(0.4, 0.02, 0.3), DVec3::new(1.0, 0.7, 0.0));
    boxes.add("cup", Parent::Object(tray), Vec3::new(0.1, 0.1, 0.1), DVec3::new(1.1, 0.72, 0.0));
    boxes.add("chair", GROUND, Vec3::new(0.4, 0.8, 0.4), DVec3::new(-1.0, 0.0, 0.0));
    let shelf = boxes.add("shelf", WALL, Vec3::new(0.8, 0.03, 0.2), DVec3::new(0.0, 1.5, -1.0));
    boxes.add("vase", Parent::Object(shelf), Vec3::new(0.1, 0.3, 0.1), DVec3::new(0.0, 1.53, -1.0));
    let stone = boxes.add("stone", GROUND, Vec3::splat(0.3), DVec3::new(0.0, 0.0, 2.0));
    boxes.objects[stone].movable = false;
    boxes
}

fn config() -> Config {
    let mut config = Config::default();
    for cem in [&mut config.local, &mut config.global] {
        cem.candidates = 16;
        cem.iterations = 3;
        cem.elite_fraction = 0.25;
        cem.stop_energy = 0.0;
    }
    config
}

/// A search that does not move anything by more than the rounding of f32.
fn frozen() -> Config {
    let mut config = config();
    for cem in [&mut config.local, &mut config.global] {
        cem.translation_std = [0.0; 3];
        cem.rotation_std = [0.0; 3];
        cem.std_epsilon = 0.0;
    }
    config
}

fn go(
    boxes: &Boxes,
    backend: &Fake,
    config: &Config,
    seed: u64,
    resume: Option<Checkpoint>,
    watch: &mut Watch,
) -> Result<Outcome, OptimizeError> {
    run(&boxes.scene(), &boxes.shapes, backend, config, seed, resume, watch)
}

fn simple(boxes: &Boxes, backend: &Fake, config: &Config) -> Outcome {
    go(boxes, backend, config, 1, None, &mut Watch::default()).unwrap()
}

/// Everything but wall time.
fn results(mut outcome: Outcome) -> String {
    outcome.timings = Default::default();
    for group in &mut outcome.groups {
        group.seconds = 0.0;
    }
    format!("{outcome:?}")
}

fn shift(boxes: &Boxes, outcome: &Outcome, object: usize) -> DVec3 {
    outcome.objects[object].pose.translation - boxes.objects[object].pose.translation
}

#[test]
fn groups_go_from_the_leaves_to_the_whole_scene() {
    let (boxes, backend, mut watch) = (room(), Fake::default(), Watch::default());
    let outcome = go(&boxes, &backend, &config(), 1, None, &mut watch).unwrap();
    assert_eq!(watch.groups, ["tray", "table", "shelf", "global"]);
    assert_eq!(watch.candidates, [96; 4]);
    let units: Vec<_> = outcome.groups.iter().map(|group| group.units.join(" ")).collect();
    assert_eq!(units, ["cup", "tray", "vase", "table chair vase"]);
    let worlds = backend.worlds.lock().unwrap();
    let bodies: Vec<_> = worlds.iter().map(|world| world.bodies.iter().map(|b| b.unit).collect::<Vec<_>>()).collect();
    assert_eq!(bodies[0], [STATIC, 0], "tray, cup");
    assert_eq!(bodies[1], [STATIC, 0, 0], "table, tray, cup");
    assert_eq!(bodies[2], [STATIC, 0], "shelf, vase");
    assert_eq!(bodies[3], [0, 0, 0, 1, STATIC, 2, STATIC], "table, tray, cup, chair, shelf, vase, stone");
    assert!(outcome.finished && outcome.at_rest && outcome.notes.is_empty(), "{:?}", outcome.notes);
    assert_eq!(outcome.iterations.len(), 4 * 6);
}

#[test]
fn global_only_takes_every_object_by_itself() {
    let (boxes, backend, mut watch) = (room(), Fake::default(), Watch::default());
    let config = Config { global_only: true, ..config() };
    let outcome = go(&boxes, &backend, &config, 1, None, &mut watch).unwrap();
    assert_eq!(watch.groups, ["global"]);
    assert_eq!(outcome.groups[0].units.join(" "), "table tray cup chair vase");
    let bodies: Vec<_> = backend.worlds.lock().unwrap()[0].bodies.iter().map(|body| body.unit).collect();
    assert_eq!(bodies, [0, 1, 2, 3, STATIC, 4, STATIC]);
}

/// The projected layout is where a search without any spread ends if that costs less, and only then.
#[test]
fn a_search_goes_on_from_the_better_of_two_starts() {
    let mut boxes = Boxes::default();
    boxes.add("a", GROUND, Vec3::splat(0.4), DVec3::ZERO);
    boxes.add("b", GROUND, Vec3::splat(0.4), DVec3::X * 0.3);
    let moved = |project: bool, layout: f32| {
        let mut config = Config { project, ..frozen() };
        config.energy.layout = layout;
        for cem in [&mut config.local, &mut config.global] {
            cem.sample_mean = true;
        }
        let backend = Fake { overlap: true, ..Default::default() };
        let outcome = simple(&boxes, &backend, &config);
        shift(&boxes, &outcome, 1).x - shift(&boxes, &outcome, 0).x
    };
    assert_eq!(moved(false, 1.0), 0.0);
    assert!((moved(true, 0.1) - 0.1).abs() < 2e-3, "parted: {}", moved(true, 0.1));
    assert!(moved(true, 100.0).abs() < 1e-6, "to be moved costs more: {}", moved(true, 100.0));
}

#[test]
fn an_unmovable_child_is_held_and_what_stands_on_it_is_a_unit() {
    let mut boxes = room();
    boxes.objects[1].movable = false;
    let (backend, mut watch) = (Fake::default(), Watch::default());
    let outcome = go(&boxes, &backend, &config(), 1, None, &mut watch).unwrap();
    assert_eq!(watch.groups, ["tray", "shelf", "global"]);
    assert_eq!(outcome.groups[2].units.join(" "), "table cup chair vase");
    assert_eq!(outcome.objects[1].pose, boxes.objects[1].pose);
}

#[test]
fn children_ride_along_and_settled_poses_are_kept() {
    let boxes = room();
    let backend = Fake { slide: Vec3::X * 0.01, ..Default::default() };
    let outcome = simple(&boxes, &backend, &frozen());
    // One slide for every group in which the object moves; rounding of f32 near 1 m, three times.
    let slides = [1.0, 2.0, 3.0, 1.0, 0.0, 2.0, 0.0];
    for (i, slides) in slides.into_iter().enumerate() {
        let moved = shift(&boxes, &outcome, i);
        assert!(moved.distance(DVec3::X * 0.01 * slides) < 2e-6, "{}: {moved}", boxes.objects[i].name);
        assert!((outcome.objects[i].moved - 0.01 * slides).abs() < 2e-6);
    }

    let mut config = frozen();
    config.settle.from = ResultFrom::Placed;
    config.settle.max_seconds = 0.0;
    let outcome = simple(&boxes, &backend, &config);
    for (i, slides) in [0.0, 1.0, 2.0, 0.0, 0.0, 1.0, 0.0].into_iter().enumerate() {
        assert!(shift(&boxes, &outcome, i).distance(DVec3::X * 0.01 * slides) < 2e-6);
    }
}

#[test]
fn what_is_held_keeps_its_pose_to_the_bit() {
    let boxes = room();
    let outcome = simple(&boxes, &Fake { slide: Vec3::Z * 0.1, ..Default::default() }, &config());
    for (i, (object, outcome)) in boxes.objects.iter().zip(&outcome.objects).enumerate() {
        let held = [4, 6].contains(&i);
        assert_eq!(outcome.simulated, !held);
        assert_eq!(outcome.pose == object.pose, held, "{}", object.name);
        assert!(!held || outcome.stable && !outcome.lost_support && outcome.moved == 0.0);
    }
}

#[test]
fn a_seed_repeats_and_another_differs() {
    let (boxes, backend) = (room(), Fake::default());
    let result = |seed| results(go(&boxes, &backend, &config(), seed, None, &mut Watch::default()).unwrap());
    assert_eq!(result(1), result(1));
    assert_ne!(result(1), result(2));
}

#[test]
fn a_resumed_run_ends_like_an_uninterrupted_one() {
    let boxes = room();
    let backend = Fake { slide: Vec3::new(0.001, -0.002, 0.0007), ..Default::default() };
    let mut watch = Watch::default();
    let whole = results(go(&boxes, &backend, &config(), 3, None, &mut watch).unwrap());
    assert_eq!(watch.checkpoints.len(), 4);
    for text in &watch.checkpoints {
        let checkpoint = Checkpoint::from_json(text).unwrap();
        assert_eq!(&checkpoint.to_json(), text);
        let mut second = Watch::default();
        let resumed = go(&boxes, &backend, &config(), 3, Some(checkpoint), &mut second).unwrap();
        assert_eq!(results(resumed), whole);
        assert!(second.checkpoints.len() < 4);
    }
}

#[test]
fn failed_iterations_survive_a_checkpoint() {
    let (boxes, backend, mut watch) = (room(), Fake { fails: true, ..Default::default() }, Watch::default());
    let whole = results(go(&boxes, &backend, &config(), 3, None, &mut watch).unwrap());
    let checkpoint = Checkpoint::from_json(&watch.checkpoints[1]).unwrap();
    assert_eq!(results(go(&boxes, &backend, &config(), 3, Some(checkpoint), &mut Watch::default()).unwrap()), whole);
}

#[test]
fn a_checkpoint_of_another_run_is_refused() {
    let (boxes, backend, mut watch) = (room(), Fake::default(), Watch::default());
    go(&boxes, &backend, &config(), 3, None, &mut watch).unwrap();
    let refused = |boxes: &Boxes, config: &Config, seed, word: &str| {
        let checkpoint = Checkpoint::from_json(&watch.checkpoints[0]).unwrap();
        let error = go(boxes, &backend, config, seed, Some(checkpoint), &mut Watch::default()).unwrap_err();
        assert!(matches!(&error, OptimizeError::Checkpoint(text) if text.contains(word)), "{error}");
    };
    refused(&boxes, &config(), 4, "seed (3 instead of 4)");
    let mut other = config();
    other.energy.layout = 2.0;
    refused(&boxes, &other, 3, "configuration");
    let mut other = room();
    other.objects[2].pose.translation.x += 1e-9;
    refused(&other, &config(), 3, "scene");
    let mut other = room();
    other.shapes[2].parts[0].vertices[0].x += 1e-4;
    refused(&other, &config(), 3, "convex parts");
    assert!(matches!(Checkpoint::from_json("{\"version\": 1}"), Err(OptimizeError::Checkpoint(_))));
}

#[test]
fn a_checkpoint_whose_content_does_not_fit_together_is_refused() {
    let (boxes, backend, mut watch) = (room(), Fake::default(), Watch::default());
    go(&boxes, &backend, &config(), 3, None, &mut watch).unwrap();
    let whole: Value = serde_json::from_str(&watch.checkpoints[1]).unwrap();
    let damaged = |damage: fn(&mut Value)| {
        let mut value = whole.clone();
        damage(&mut value);
        let checkpoint = Checkpoint::from_json(&value.to_string()).unwrap();
        let error = go(&boxes, &backend, &config(), 3, Some(checkpoint), &mut Watch::default()).unwrap_err();
        assert!(matches!(&error, OptimizeError::Checkpoint(text) if text.contains("delete it")), "{error}");
    };
    damaged(|value| value["completed"] = 99.into());
    damaged(|value| value["completed"] = 0.into());
    damaged(|value| value["groups"] = Value::Array(Vec::new()));
    damaged(|value| value["iterations"][0]["group"] = 77.into());
    damaged(|value| value["layout"][0] = vec![0.0; 7].into());
    damaged(|value| value["layout"][0][0] = 1e300.into());
}

#[test]
fn nothing_movable_is_done_at_once() {
    let mut boxes = room();
    for object in &mut boxes.objects {
        object.movable = false;
    }
    for boxes in [boxes, Boxes::default()] {
        let mut watch = Watch::default();
        let outcome = go(&boxes, &Fake::default(), &config(), 1, None, &mut watch).unwrap();
        assert!(outcome.finished && watch.iterations == 0 && watch.groups.is_empty());
        assert!(outcome.notes[0].contains("nothing in the scene is movable"));
        assert!(outcome.objects.iter().zip(&boxes.objects).all(|(o, b)| o.pose == b.pose && o.stable));
    }
}

#[test]
fn one_object_is_a_scene() {
    let mut boxes = Boxes::default();
    boxes.add("box", GROUND, Vec3::ONE, DVec3::ZERO);
    let outcome = simple(&boxes, &Fake::default(), &config());
    assert_eq!(outcome.groups.len(), 1);
    assert!(outcome.objects[0].stable && !outcome.objects[0].fallen && !outcome.objects[0].lost_support);
}

#[test]
fn a_simulator_that_always_fails_leaves_the_layout_and_says_so() {
    let boxes = room();
    let outcome = simple(&boxes, &Fake { fails: true, ..Default::default() }, &config());
    assert!(outcome.objects.iter().zip(&boxes.objects).all(|(o, b)| o.pose == b.pose));
    assert!(outcome.groups.iter().all(|group| group.best.is_none() && group.flagged == [0, 0, 96, 0]));
    // Four groups, settling, check.
    assert_eq!(outcome.notes.len(), 6, "{:?}", outcome.notes);
    assert!(outcome.objects.iter().all(|object| object.stable != object.simulated));
}

#[test]
fn a_stop_keeps_the_best_so_far() {
    let boxes = room();
    let backend = Fake { slide: Vec3::X * 0.01, ..Default::default() };
    let mut watch = Watch { stop_at: Some(8), ..Default::default() };
    let outcome = go(&boxes, &backend, &frozen(), 1, None, &mut watch).unwrap();
    assert!(!outcome.finished);
    assert_eq!((outcome.groups.len(), outcome.iterations.len(), watch.checkpoints.len()), (2, 8, 1));
    assert!(shift(&boxes, &outcome, 2).distance(DVec3::X * 0.02) < 2e-6, "cup moved in both groups");
    assert!(outcome.objects.iter().all(|object| object.stable), "the check ran");

    let checkpoint = Checkpoint::from_json(&watch.checkpoints[0]).unwrap();
    let resumed = go(&boxes, &backend, &frozen(), 1, Some(checkpoint), &mut Watch::default()).unwrap();
    assert_eq!(results(resumed), results(simple(&boxes, &backend, &frozen())));
}

#[test]
fn a_sunk_table_is_raised_for_its_group_only() {
    let mut boxes = room();
    for object in &mut boxes.objects[..3] {
        object.pose.translation.y -= 0.5;
    }
    let backend = Fake::default();
    let outcome = simple(&boxes, &backend, &frozen());
    let worlds = backend.worlds.lock().unwrap();
    let height = |world: usize, body: usize| worlds[world].start[body].translation.y;
    // Half heights: table 0.35 m, tray 0.01 m; rounding of f32 below 1 m.
    assert!((height(1, 0) - 0.35).abs() < 1e-6 && (height(1, 1) - 0.71).abs() < 1e-6);
    assert!((height(3, 0) - -0.15).abs() < 1e-6 && (height(3, 1) - 0.21).abs() < 1e-6);
    assert!(shift(&boxes, &outcome, 1).length() < 1e-6);
}

#[test]
fn lost_support_is_seen() {
    let mut boxes = Boxes::default();
    let size = Vec3::splat(0.2);
    let table = boxes.add("table", GROUND, Vec3::new(1.0, 0.5, 1.0), DVec3::ZERO);
    let on = Parent::Object(table);
    boxes.add("near", on, size, DVec3::new(-0.3, 0.504, 0.0));
    boxes.add("far", on, size, DVec3::new(0.0, 0.506, 0.0));
    boxes.add("first book", on, size, DVec3::new(0.3, 0.5, 0.0));
    boxes.add("second book", on, size, DVec3::new(0.3, 0.702, 0.0));
    boxes.add("on the floor", on, size, DVec3::new(2.0, 0.0, 0.0));
    boxes.add("floats", GROUND, size, DVec3::new(3.0, 0.02, 0.0));
    let rug = boxes.add("rug", GROUND, Vec3::new(1.0, 0.02, 1.0), DVec3::new(5.0, 0.0, 0.0));
    boxes.add("chair on the rug", GROUND, size, DVec3::new(5.0, 0.02, 0.0));
    boxes.add("picture", WALL, size, DVec3::new(8.0, 1.0, 0.0));
    boxes.objects[rug].movable = false;
    let outcome = simple(&boxes, &Fake::default(), &frozen());
    let lost: Vec<&str> = (boxes.objects.iter().zip(&outcome.objects))
        .filter(|(_, outcome)| outcome.lost_support)
        .map(|(object, _)| object.name)
        .collect();
    assert_eq!(lost, ["far", "on the floor", "floats"]);
}

#[test]
fn what_tumbles_is_fallen_and_unstable() {
    let boxes = room();
    let check = |config: &Config, angle: f32| -> ObjectOutcome {
        let backend = Fake { tumble: Some((3, Quat::from_rotation_x(angle))), ..Default::default() };
        simple(&boxes, &backend, config).objects[3].clone()
    };
    let mut unsettled = frozen();
    unsettled.settle.max_seconds = 0.0;
    // In the check alone. The angle is exact to f32 rounding.
    let chair = check(&unsettled, 0.6);
    assert!(chair.fallen && !chair.stable && chair.turned < 1e-6 && (chair.drift_turn - 0.6).abs() < 1e-6, "{chair:?}");
    let chair = check(&unsettled, 0.2);
    assert!(!chair.fallen && !chair.stable, "{chair:?}");
    let chair = check(&unsettled, 0.05);
    assert!(!chair.fallen && chair.stable, "{chair:?}");
    // While settling too.
    let chair = check(&frozen(), 0.55);
    assert!(chair.fallen && (chair.turned - 0.55).abs() < 1e-6, "{chair:?}");
}

/// A crate at the edge of a stone block, which stands with its own parts and tips with the others, whose centre of mass is
/// 20 mm farther out.
#[test]
fn what_stands_on_one_decomposition_only_is_searched_again() {
    let mut boxes = Boxes::default();
    let stone = boxes.add("stone", GROUND, Vec3::new(1.0, 0.5, 1.0), DVec3::ZERO);
    boxes.objects[stone].movable = false;
    let at_edge = DVec3::new(0.49, 0.5, 0.0);
    let crate_ = boxes.add("crate", Parent::Object(stone), Vec3::splat(0.2), at_edge);
    let mass = &mut boxes.shapes[crate_].alternative.mass;
    mass.center += mass.axes * Vec3::X * 0.02;
    let with = |second_opinion: bool| {
        let config = Config { second_opinion, ..frozen() };
        let outcome = run(&boxes.scene(), &boxes.shapes, &CpuBackend, &config, 1, None, &mut Watch::default()).unwrap();
        outcome.objects[crate_].clone()
    };
    let object = with(false);
    assert!(object.stable && !object.stable_otherwise && object.moved < 1e-3, "{object:?}");
    let object = with(true);
    assert!(object.stable && object.stable_otherwise && !object.fallen && !object.lost_support, "{object:?}");
    assert!(object.moved < 0.05, "{object:?}");
}

#[test]
fn searches_end_early() {
    let mut boxes = Boxes::default();
    boxes.add("box", GROUND, Vec3::ONE, DVec3::ZERO);
    let iterations = |change: &dyn Fn(&mut Config)| {
        let mut config = config();
        config.global.iterations = 20;
        change(&mut config);
        simple(&boxes, &Fake::default(), &config).iterations.len()
    };
    assert_eq!(iterations(&|_| ()), 40);
    assert_eq!(iterations(&|c| c.global.stop_energy = 1e9), 1);
    // Frozen: the first iteration improves on nothing, then three do not; twice.
    let frozen_std = |c: &mut Config| {
        c.global.translation_std = [0.0; 3];
        c.global.rotation_std = [0.0; 3];
        c.global.std_epsilon = 0.0;
        c.global.patience = 3;
    };
    assert_eq!(iterations(&frozen_std), 2 * 4 - 1);
}

#[test]
fn later_episodes_are_widened() {
    let mut boxes = Boxes::default();
    boxes.add("box", GROUND, Vec3::ONE, DVec3::ZERO);
    let spread = |restart_std: f32| {
        let mut config = config();
        config.global.iterations = 10;
        config.global.restart_std = restart_std;
        let records = simple(&boxes, &Fake::default(), &config).iterations;
        records[10].stats.elite_mean
    };
    // After ten iterations the samples lie close to the optimum; widened ones do not.
    assert!(spread(1.0) > 3.0 * spread(0.0), "{} {}", spread(1.0), spread(0.0));
}

#[test]
fn a_search_that_does_not_fit_into_memory_is_refused_before_it_starts() {
    let (boxes, backend, mut watch) = (room(), Fake { free_bytes: Some(1000), ..Default::default() }, Watch::default());
    let refused = go(&boxes, &backend, &config(), 1, None, &mut watch).unwrap_err();
    let OptimizeError::Backend(BackendError::Capacity(message)) = refused else { unreachable!("{refused}") };
    assert!(message.contains("memory") && message.contains("fewer"), "{message}");
    assert!(backend.worlds.lock().unwrap().is_empty());
}

#[test]
fn settings_without_sense_are_refused() {
    let boxes = room();
    let refused = |key: &str, change: &dyn Fn(&mut Config)| {
        let mut config = config();
        change(&mut config);
        let error = go(&boxes, &Fake::default(), &config, 1, None, &mut Watch::default()).unwrap_err();
        assert!(matches!(&error, OptimizeError::Config { key: found, .. } if found == key), "{error}");
    };
    refused("global.candidates", &|c| c.global.candidates = 0);
    refused("local.iterations", &|c| c.local.iterations = 0);
    refused("local.elite_fraction", &|c| c.local.elite_fraction = 1.5);
    refused("local.elite_fraction", &|c| c.local.elite_fraction = f32::NAN);
    refused("simulation.dt", &|c| c.simulation.dt = 0.0);
    refused("simulation.snapshot_step", &|c| c.simulation.steps = 10);
    refused("energy.penetration", &|c| c.energy.penetration = -1.0);
    refused("global.rotation_std", &|c| c.global.rotation_std[1] = f32::INFINITY);
    refused("verify.seconds", &|c| c.verify.seconds = 0.0);
}

/// The same, but its device fails for good after so many iterations, and another slide tells it from `Fake`.
struct Mortal {
    fake: Fake,
    left: AtomicUsize,
}

impl Mortal {
    fn boxed(left: usize) -> Box<dyn Backend> {
        let fake = Fake { slide: Vec3::X * 0.003, ..Default::default() };
        Box::new(Self { fake, left: AtomicUsize::new(left) })
    }

    fn check(&self) -> Result<(), BackendError> {
        match self.left.load(Ordering::Relaxed) {
            0 => Err(BackendError::Device("device lost".into())),
            _ => Ok(()),
        }
    }
}

struct MortalSearch<'a>(&'a Mortal, Box<dyn Search + 'a>);

impl Search for MortalSearch<'_> {
    fn iterate(&mut self) -> Result<IterationStats, BackendError> {
        self.0.check()?;
        self.0.left.fetch_sub(1, Ordering::Relaxed);
        self.1.iterate()
    }
    fn energies(&self) -> Vec<Energy> {
        self.1.energies()
    }
    fn distribution(&self) -> Distribution {
        self.1.distribution()
    }
    fn set_distribution(&mut self, distribution: &Distribution) {
        self.1.set_distribution(distribution);
    }
    fn placed(&self, candidate: u32) -> Vec<Pose> {
        self.1.placed(candidate)
    }
    fn best(&mut self) -> Option<Best> {
        self.1.best()
    }
}

impl Backend for Mortal {
    fn describe(&self) -> String {
        "mortal".into()
    }

    fn simulate(
        &self,
        world: &World,
        settings: &SimSettings,
        starts: &[Pose],
        on_step: &mut OnStep<'_>,
    ) -> Result<Vec<Status>, BackendError> {
        self.check()?;
        self.fake.simulate(world, settings, starts, on_step)
    }

    fn overlaps(&self, world: &World, settings: &SimSettings, poses: &[Pose]) -> Result<Vec<f32>, BackendError> {
        self.check()?;
        self.fake.overlaps(world, settings, poses)
    }

    fn search<'a>(
        &'a self,
        world: &'a World,
        settings: &'a SearchSettings,
        stream: Stream,
    ) -> Result<Box<dyn Search + 'a>, BackendError> {
        Ok(Box::new(MortalSearch(self, self.fake.search(world, settings, stream)?)))
    }
}

#[test]
fn a_failed_device_ends_as_a_resumed_run_on_the_next_backend() {
    let boxes = room();
    let (scene, config) = (boxes.scene(), config());
    // Every group takes six iterations: the first device fails in the third group, the second in its settling or in
    // the fourth group, the first in its seating or in the first group.
    for (first, second, groups) in [(14, 3, 2), (14, 6, 3), (14, 12, 4), (2, 3, 0), (0, 0, 0)] {
        let mut watch = Watch::default();
        let mut failures = Vec::new();
        let mut next = |failure: &str| -> Option<Box<dyn Backend>> {
            failures.push(failure.to_owned());
            match failures.len() {
                1 => Some(Mortal::boxed(second)),
                2 => Some(Box::new(Fake::default())),
                _ => None,
            }
        };
        let mortal = Mortal::boxed(first);
        let (mut outcome, backend) =
            run_on(&scene, &boxes.shapes, mortal, &mut next, &config, 3, None, &mut watch).unwrap();
        assert_eq!((failures, backend.describe()), (vec!["device lost".to_owned(); 2], "fake".into()));
        assert_eq!(outcome.notes.len(), 2, "{:?}", outcome.notes);
        assert!(outcome.notes[1].contains(&format!("fake went on after {groups} groups")), "{:?}", outcome.notes);
        outcome.notes.clear();

        let resume = (groups > 0).then(|| Checkpoint::from_json(&watch.checkpoints[groups - 1]).unwrap());
        let resumed = go(&boxes, &Fake::default(), &config, 3, resume, &mut Watch::default()).unwrap();
        assert_eq!(results(outcome), results(resumed), "{first} and {second} iterations");
    }
}

#[test]
fn a_failed_device_is_an_error_when_nothing_is_left() {
    let boxes = room();
    let failed = run_on(
        &boxes.scene(),
        &boxes.shapes,
        Mortal::boxed(4),
        &mut |_| None,
        &config(),
        3,
        None,
        &mut Watch::default(),
    );
    assert!(matches!(failed.err(), Some(OptimizeError::Backend(BackendError::Device(_)))));
}
