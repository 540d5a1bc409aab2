//! The optimizer with the CPU simulator on the benchmark scene; skipped where the shared scenes are absent.

#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::scenes::Keep;
use rest3d_gpu::cpu::{CpuBackend, CpuSearch, Simulator};
use rest3d_gpu::optimize::{
    Candidate, Checkpoint, Config, OptimizeError, Outcome, ResultFrom, Rig, replay, run, shape_requests,
};
use rest3d_gpu::scene::Scene;
use rest3d_gpu::shape::{Shape, ShapeSettings, build_shapes};
use rest3d_gpu::world::{
    Backend, BackendError, Energy, Flow, OnStep, Pose, Search, SearchSettings, SimSettings, Status, Stream, World,
};
use std::path::Path;
use std::sync::Mutex;

/// Twelve bodies with ready-made parts: no decomposition is waited for.
fn bench12() -> (Scene, Vec<Shape>) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes/bench12");
    let scene = Scene::read(&folder).unwrap();
    let shapes = build_shapes(&shape_requests(&scene), &ShapeSettings::default(), None, &|_, _, _| ()).unwrap();
    (scene, shapes)
}

fn config(candidates: u32) -> Config {
    let mut config = Config { seat: true, ..Default::default() };
    (config.settle.max_seconds, config.settle.from) = (5.0, ResultFrom::Settled);
    for cem in [&mut config.local, &mut config.global] {
        cem.candidates = candidates;
        cem.iterations = 2;
        cem.episodes = 1;
        cem.elite_fraction = 0.3;
        cem.sample_mean = true;
    }
    config
}

fn bits(outcome: &Outcome) -> Vec<[u64; 7]> {
    let numbers = |o: &rest3d_gpu::optimize::ObjectOutcome| {
        let ([x, y, z], [i, j, k, w]) = (o.pose.translation.to_array(), o.pose.rotation.to_array());
        [x, y, z, i, j, k, w].map(f64::to_bits)
    };
    outcome.objects.iter().map(numbers).collect()
}

#[test]
#[cfg_attr(not(shared_files), ignore = "needs ../shared")]
fn a_table_with_dishes_stands_and_the_seed_decides_every_bit() {
    let (scene, shapes) = bench12();
    let mut keep = Keep::default();
    let mut go = |resume| run(&scene, &shapes, &CpuBackend, &config(6), 1, resume, &mut keep).unwrap();
    let first = go(None);
    for (object, outcome) in scene.objects.iter().zip(&first.objects) {
        // The input stands, half a millimetre above its supports.
        let rolled = object.name == "fruit";
        assert!(outcome.stable && !outcome.fallen && !outcome.lost_support, "{}: {outcome:?}", object.name);
        // The fruit may roll to another place in its bowl; everything else stays where it was put.
        let reach = if rolled { 0.05 } else { 0.02 };
        assert!(outcome.moved < reach && outcome.drift < 1e-3, "{}: {outcome:?}", object.name);
    }
    // V-HACD closes the bowl that the fruit is in.
    assert!(first.at_rest && first.notes.iter().all(|note| note.starts_with("\"bowl1\"")), "{:?}", first.notes);
    let second = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(|| go(None));
    assert_eq!(bits(&first), bits(&second));
    assert_eq!(first.iterations, second.iterations);
    let checkpoint = Checkpoint::from_json(&keep.0[3]).unwrap();
    let resumed = run(&scene, &shapes, &CpuBackend, &config(6), 1, Some(checkpoint), &mut Keep::default()).unwrap();
    assert_eq!(bits(&first), bits(&resumed));
}

#[test]
#[cfg_attr(not(shared_files), ignore = "needs ../shared")]
fn a_replayed_winner_ends_where_the_run_left_it() {
    let (scene, shapes) = bench12();
    let mut config = config(6);
    config.settle.max_seconds = 0.0;
    let outcome = run(&scene, &shapes, &CpuBackend, &config, 1, None, &mut Keep::default()).unwrap();
    let stage = outcome.groups.len() - 1;
    let (iteration, index) = outcome.groups[stage].winner.unwrap();
    let again = |candidate| replay(&scene, &shapes, &CpuBackend, &config, 1, candidate, &mut Keep::default());
    let found = again(Candidate { stage, iteration, index }).unwrap();
    let mut ends = found.placed.clone();
    CpuBackend
        .simulate(&found.world, &found.simulation, &found.placed, &mut |_, poses, _| {
            ends.copy_from_slice(poses);
            Flow::Continue
        })
        .unwrap();
    for (&object, end) in found.objects.iter().zip(&ends) {
        assert_eq!(Rig::new(&shapes[object]).object(end), outcome.objects[object].pose, "object {object}");
    }
    for candidate in [
        Candidate { stage: stage + 1, iteration, index },
        Candidate { stage, iteration: 99, index },
        Candidate { stage, iteration, index: 6 },
    ] {
        assert!(matches!(again(candidate), Err(OptimizeError::Candidate(_))), "{candidate:?}");
    }
}

/// The CPU backend, remembering the worlds that it searches.
#[derive(Default)]
struct Spy(Mutex<Vec<World>>);

impl Backend for Spy {
    fn describe(&self) -> String {
        CpuBackend.describe()
    }

    fn simulate(
        &self,
        world: &World,
        settings: &SimSettings,
        starts: &[Pose],
        on_step: &mut OnStep<'_>,
    ) -> Result<Vec<Status>, BackendError> {
        CpuBackend.simulate(world, settings, starts, on_step)
    }

    fn overlaps(&self, world: &World, settings: &SimSettings, poses: &[Pose]) -> Result<Vec<f32>, BackendError> {
        CpuBackend.overlaps(world, settings, poses)
    }

    fn search<'a>(
        &'a self,
        world: &'a World,
        settings: &'a SearchSettings,
        stream: Stream,
    ) -> Result<Box<dyn Search + 'a>, BackendError> {
        self.0.lock().unwrap().push(world.clone());
        CpuBackend.search(world, settings, stream)
    }
}

#[test]
#[cfg_attr(not(shared_files), ignore = "needs ../shared")]
fn an_energy_depends_on_neither_neighbours_nor_threads() {
    let (scene, shapes) = bench12();
    let spy = Spy::default();
    run(&scene, &shapes, &spy, &config(1), 1, None, &mut Keep::default()).unwrap();
    let worlds = spy.0.lock().unwrap();
    let world = worlds.last().unwrap();
    let energies = |candidates: u32, threads: usize| -> Vec<Energy> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut settings = SearchSettings::default();
            settings.cem.candidates = candidates;
            let simulator = Simulator::new(world, &settings.simulation);
            let mut search = CpuSearch::new(world, &settings, Stream { seed: 9, stage: 0 }, simulator);
            search.iterate().unwrap();
            search.energies().unwrap()
        })
    };
    let many = energies(9, 2);
    assert_eq!(many[..5], energies(5, 1));
    assert_eq!(many, energies(9, 3));
    assert!(many.windows(2).all(|pair| pair[0] != pair[1]), "candidates differ");
}
