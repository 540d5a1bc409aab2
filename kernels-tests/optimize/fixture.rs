//! Scenes of boxes, and a simulator without forces.

use crate::common::hulls::cuboid;
use glam::{DQuat, DVec3, Quat, Vec3};
use rest3d_gpu::cpu::search::{CpuSearch, GoesOn, Record, Rollout};
use rest3d_gpu::optimize::{
    Checkpoint, Config, Event, ObjectOutcome, Observer, OptimizeError, Outcome, ResultFrom, run,
};
use rest3d_gpu::scene::{self, Parent, Root, Scene};
use rest3d_gpu::shape::{Alternative, MassProperties, Mesh, Part, Shape};
use rest3d_gpu::world::{
    Backend, BackendError, Flow, OnStep, Pose, STATIC, Search, SearchSettings, SimSettings, Status, Stream, Velocity,
    World,
};
use serde_json::json;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// A simulator without forces: in a rollout everything that moves slides by `slide`; elsewhere it keeps still, but for
/// `tumble`, by which the body of that number turns in every simulation.
#[derive(Default)]
pub struct Fake {
    pub slide: Vec3,
    pub fails: bool,
    /// In a rollout, bodies overlap by what their boxes do along x, were they 0.4 m wide.
    pub overlap: bool,
    pub tumble: Option<(usize, Quat)>,
    pub worlds: Mutex<Vec<World>>,
    pub free_bytes: Option<u64>,
    /// It simulates so many candidates at once at most, and says so only after a step.
    pub room: Option<usize>,
}

pub struct Slide<'a>(&'a World, Vec3, bool, bool);

impl Rollout for Slide<'_> {
    type Scratch = ();

    fn scratch(&self) {}

    fn run(&self, (): &mut (), placed: &[Pose], _: u32, records: &mut [Record], _: &GoesOn<'_>) {
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
        world: &World,
        settings: &SimSettings,
        starts: &[Pose],
        on_step: &mut OnStep<'_>,
    ) -> Result<Vec<Status>, BackendError> {
        let candidates = starts.len() / world.bodies.len();
        if self.room.is_some_and(|room| candidates > room) {
            let wrong: Vec<Pose> = starts.iter().map(|_| Pose::IDENTITY).collect();
            on_step(0, &wrong, &vec![Velocity::new(Vec3::ONE, Vec3::ONE); starts.len()]);
            return Err(BackendError::Capacity("too many".into()));
        }
        let mut poses = starts.to_vec();
        if let Some((body, turn)) = self.tumble {
            for pose in poses.iter_mut().skip(body).step_by(world.bodies.len()) {
                pose.rotation = turn * pose.rotation;
            }
        }
        for step in 0..settings.steps {
            if on_step(step, &poses, &vec![Velocity::default(); starts.len()]) == Flow::Stop {
                break;
            }
        }
        let status = if self.fails { Status::NOT_FINITE } else { Status::default() };
        Ok(vec![status; candidates])
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

/// Remembers what it is told; stops at the given iteration or round of the second opinion.
#[derive(Default)]
pub struct Watch {
    pub groups: Vec<String>,
    pub candidates: Vec<u64>,
    pub checkpoints: Vec<String>,
    pub iterations: usize,
    pub stop_at: Option<usize>,
    pub rounds: usize,
    pub stop_at_round: Option<usize>,
    /// Asks for the end of that round while it goes on, not before it.
    pub within_round: bool,
    /// Before something is set down anew.
    pub stop_at_anew: bool,
    pub stop: Arc<AtomicBool>,
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
            Event::SettingAnew { .. } if self.stop_at_anew => return Flow::Stop,
            Event::Seating | Event::Placing | Event::Settling | Event::SettingAnew { .. } => {}
            Event::Parting | Event::Verifying => {}
            Event::Reconsidering { checkpoint, .. } => {
                self.checkpoints.push(checkpoint.to_json());
                self.rounds += 1;
                if self.stop_at_round == Some(self.rounds) {
                    self.stop.store(self.within_round, Ordering::Relaxed);
                    return if self.within_round { Flow::Continue } else { Flow::Stop };
                }
            }
        }
        Flow::Continue
    }

    fn stop(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.stop)
    }
}

/// A scene of boxes, built object by object.
#[derive(Default)]
pub struct Boxes {
    pub objects: Vec<Stored>,
    pub shapes: Vec<Shape>,
}

impl Boxes {
    /// A box of this size standing with its lowest face at the given place.
    pub fn add(&mut self, name: &'static str, parent: Parent, size: Vec3, foot: DVec3) -> usize {
        let half = 0.5 * size;
        // The mesh frame is off the centre of mass and off its axes, as real meshes are.
        let (center, axes) = (Vec3::new(0.3, 0.7, -0.2), Quat::from_rotation_y(0.4));
        let parts = vec![Part { vertices: cuboid(half).into_iter().map(|corner| axes * corner + center).collect() }];
        let mass =
            MassProperties { mass: 2.0, volume: size.element_product(), center, axes, inertia: Vec3::splat(0.02) };
        self.shapes.push(Shape {
            // Nothing to part: what the exact step does is tested by itself.
            surface: Mesh::default(),
            alternatives: vec![Alternative { parts: parts.clone(), mass: mass.clone() }; 2],
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

    /// Hollows a box out from above and leaves walls and a floor of this thickness, m; its other parts stay full.
    pub fn hollow(&mut self, object: usize, thickness: f32) {
        let shape = &mut self.shapes[object];
        let MassProperties { center, axes, .. } = shape.mass;
        let half = (axes.conjugate() * (shape.parts[0].vertices[7] - center)).abs();
        let plate = |thin: Vec3, side: Vec3| {
            let plate = half * (Vec3::ONE - thin) + 0.5 * thickness * thin;
            let middle = side * (half - 0.5 * thickness);
            Part { vertices: cuboid(plate).into_iter().map(|corner| axes * (corner + middle) + center).collect() }
        };
        let sides = [Vec3::NEG_Y, Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z];
        shape.parts = sides.map(|side| plate(side.abs(), side)).into();
    }

    /// Makes a box of blocks instead, each given by two corners from the middle of its foot, m; its other parts stay full.
    pub fn carve(&mut self, object: usize, blocks: &[[Vec3; 2]]) {
        let shape = &mut self.shapes[object];
        let MassProperties { center, axes, .. } = shape.mass;
        let height = (axes.conjugate() * (shape.parts[0].vertices[7] - center)).y.abs();
        let part = |[low, high]: &[Vec3; 2]| {
            let corner = |i: usize| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
            let place = |i| *low + (*high - *low) * corner(i) - Vec3::Y * height;
            Part { vertices: (0..8).map(|i| axes * place(i) + center).collect() }
        };
        shape.parts = blocks.iter().map(part).collect();
    }

    /// Height of the lowest face of a box that stands upright in a result, m.
    pub fn foot(&self, object: usize, result: &ObjectOutcome) -> f64 {
        let corners = self.shapes[object].parts[0].vertices.iter();
        corners.map(|v| result.pose.point(v.as_dvec3()).y).fold(f64::INFINITY, f64::min)
    }

    /// Turns a box about the z axis (rad) and puts its middle elsewhere.
    pub fn turn(&mut self, object: usize, angle: f64, middle: DVec3) {
        let rotation = DQuat::from_rotation_z(angle) * self.objects[object].pose.rotation;
        let center = self.shapes[object].mass.center.as_dvec3();
        self.objects[object].pose = scene::Pose { rotation, translation: middle - rotation * center };
    }

    /// The scene as a file says it, with poses that no decimal rounds.
    pub fn scene(&self) -> Scene {
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
pub struct Stored {
    pub name: &'static str,
    pub parent: Parent,
    pub pose: scene::Pose,
    pub movable: bool,
}

pub const GROUND: Parent = Parent::Root(Root::Ground);
pub const WALL: Parent = Parent::Root(Root::Wall);

/// table ← tray ← cup, chair, shelf on the wall ← vase, and a stone that may not move.
pub fn room() -> Boxes {
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

pub fn config() -> Config {
    let mut config = Config::default();
    (config.settle.max_seconds, config.settle.from) = (5.0, ResultFrom::Settled);
    for cem in [&mut config.local, &mut config.global] {
        cem.candidates = 16;
        cem.iterations = 3;
        cem.elite_fraction = 0.25;
        cem.stop_energy = 0.0;
    }
    config
}

/// A search that does not move anything by more than the rounding of f32.
pub fn frozen() -> Config {
    let mut config = config();
    for cem in [&mut config.local, &mut config.global] {
        cem.translation_std = [0.0; 3];
        cem.rotation_std = [0.0; 3];
        cem.std_epsilon = 0.0;
    }
    config
}

pub fn go(
    boxes: &Boxes,
    backend: &dyn Backend,
    config: &Config,
    seed: u64,
    resume: Option<Checkpoint>,
    watch: &mut Watch,
) -> Result<Outcome, OptimizeError> {
    run(&boxes.scene(), &boxes.shapes, backend, config, seed, resume, watch)
}

pub fn simple(boxes: &Boxes, backend: &dyn Backend, config: &Config) -> Outcome {
    go(boxes, backend, config, 1, None, &mut Watch::default()).unwrap()
}

/// Everything but wall time.
pub fn results(mut outcome: Outcome) -> String {
    outcome.timings = Default::default();
    for group in &mut outcome.groups {
        group.seconds = 0.0;
    }
    format!("{outcome:?}")
}

pub fn shift(boxes: &Boxes, outcome: &Outcome, object: usize) -> DVec3 {
    outcome.objects[object].pose.translation - boxes.objects[object].pose.translation
}
