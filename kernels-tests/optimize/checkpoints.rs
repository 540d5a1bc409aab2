//! Runs that are interrupted, and go on.

use crate::fixture::*;
use glam::{DVec3, Quat, Vec3};
use rest3d_gpu::optimize::{Checkpoint, Config, OptimizeError, run_on};
use rest3d_gpu::scene::Parent;
use rest3d_gpu::world::{
    Backend, BackendError, Best, Distribution, Energy, IterationStats, OnStep, Pose, Search, SearchSettings,
    SimSettings, Status, Stream, World,
};
use serde_json::{Value, json};
use std::sync::atomic::{AtomicUsize, Ordering};

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

/// A cup that the search pushes off its table and that no simulation leaves as it is: the second opinion sets it back,
/// and then looks in vain for a place where it stays.
#[test]
fn a_run_that_is_stopped_in_its_second_opinion_is_not_finished_and_resumes() {
    let mut boxes = Boxes::default();
    let table = boxes.add("table", GROUND, Vec3::new(1.0, 0.5, 1.0), DVec3::ZERO);
    boxes.add("cup", Parent::Object(table), Vec3::splat(0.1), DVec3::Y * 0.5);
    boxes.objects[table].movable = false;
    let tumble = Some((1, Quat::from_rotation_y(0.3)));
    let backend = Fake { slide: Vec3::X * 0.8, tumble, ..Default::default() };
    let config = Config { second_opinion: true, ..frozen() };
    let mut watch = Watch::default();
    let whole = go(&boxes, &backend, &config, 1, None, &mut watch).unwrap();
    let rounds = watch.rounds;
    assert!(whole.finished && rounds > 1, "{rounds} rounds");
    for stop_at in 1..=rounds {
        let stop = |within_round| {
            let mut watch = Watch { stop_at_round: Some(stop_at), within_round, ..Default::default() };
            let stopped = go(&boxes, &backend, &config, 1, None, &mut watch).unwrap();
            assert!(!stopped.finished && watch.rounds == stop_at, "{} rounds", watch.rounds);
            (results(stopped), watch)
        };
        let (before, watch) = stop(false);
        assert_eq!(stop(true).0, before, "what was found until then does not count");
        let last = Checkpoint::from_json(watch.checkpoints.last().unwrap()).unwrap();
        let mut watch = Watch::default();
        let resumed = go(&boxes, &backend, &config, 1, Some(last), &mut watch).unwrap();
        assert!(resumed.finished);
        assert_eq!(watch.rounds, rounds + 1 - stop_at, "rounds that are done are not repeated");
        assert_eq!(results(resumed), results(whole.clone()));
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
    refused(&boxes, &config(), 4, "seed 3, not 4; give --seed 3");
    let mut other = config();
    other.energy.layout = 2.0;
    refused(&boxes, &other, 3, "configuration");
    let mut other = room();
    other.objects[2].pose.translation.x += 1e-9;
    refused(&other, &config(), 3, "scene");
    let mut other = room();
    other.shapes[2].parts[0].vertices[0].x += 1e-4;
    refused(&other, &config(), 3, "convex parts");
    let mut other = room();
    other.shapes[2].alternatives[1].parts[0].vertices[0].x += 1e-4;
    refused(&other, &config(), 3, "convex parts");
    assert!(matches!(Checkpoint::from_json("{\"version\": 1}"), Err(OptimizeError::Checkpoint(_))));
}

#[test]
fn a_checkpoint_whose_content_does_not_fit_together_is_refused() {
    let (boxes, backend, mut watch) = (room(), Fake::default(), Watch::default());
    go(&boxes, &backend, &config(), 3, None, &mut watch).unwrap();
    let damaged = |of: usize, damage: fn(&mut Value)| {
        let mut value: Value = serde_json::from_str(&watch.checkpoints[of]).unwrap();
        damage(&mut value);
        let checkpoint = Checkpoint::from_json(&value.to_string()).unwrap();
        let error = go(&boxes, &backend, &config(), 3, Some(checkpoint), &mut Watch::default()).unwrap_err();
        assert!(matches!(&error, OptimizeError::Checkpoint(text) if text.contains("delete it")), "{error}");
    };
    damaged(1, |value| value["completed"] = 99.into());
    damaged(1, |value| value["completed"] = 0.into());
    damaged(1, |value| value["groups"] = Value::Array(Vec::new()));
    damaged(1, |value| value["iterations"][0]["group"] = 77.into());
    damaged(1, |value| value["layout"][0] = vec![0.0; 7].into());
    damaged(1, |value| value["layout"][0][0] = 1e300.into());
    let opinion = |value: &mut Value| {
        value["opinion"] = json!({ "progress": { "rounds": 1, "idle": 0 }, "layout": value["layout"] });
    };
    damaged(1, opinion);
    damaged(3, |value| value["opinion"] = json!({ "progress": { "rounds": 1, "idle": 0 }, "layout": [] }));
    let mut value: Value = serde_json::from_str(&watch.checkpoints[3]).unwrap();
    opinion(&mut value);
    let checkpoint = Checkpoint::from_json(&value.to_string()).unwrap();
    go(&boxes, &backend, &config(), 3, Some(checkpoint), &mut Watch::default()).unwrap();
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
    fn energies(&self) -> Result<Vec<Energy>, BackendError> {
        self.1.energies()
    }
    fn distribution(&self) -> Distribution {
        self.1.distribution()
    }
    fn set_distribution(&mut self, distribution: &Distribution) {
        self.1.set_distribution(distribution);
    }
    fn placed(&self, candidate: u32) -> Result<Vec<Pose>, BackendError> {
        self.1.placed(candidate)
    }
    fn best(&mut self) -> Result<Option<Best>, BackendError> {
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
        let mut next = |failure: &BackendError| -> Option<Box<dyn Backend>> {
            failures.push(failure.to_string());
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
fn too_little_room_goes_on_with_the_next_backend() {
    let boxes = room();
    let cramped = Box::new(Fake { room: Some(0), ..Default::default() });
    let mut capacity = Vec::new();
    let mut next = |failure: &BackendError| -> Option<Box<dyn Backend>> {
        capacity.push(matches!(failure, BackendError::Capacity(_)));
        Some(Box::new(Fake::default()))
    };
    let (outcome, _) =
        run_on(&boxes.scene(), &boxes.shapes, cramped, &mut next, &config(), 3, None, &mut Watch::default()).unwrap();
    assert_eq!(capacity, [true]);
    assert!(outcome.notes.iter().any(|note| note.contains("too many")), "{:?}", outcome.notes);
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
