//! Kernels `place`, `energy`, `elites`, `moments` by hand-made numbers, and the search that joins them.

#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::hulls::cuboid;
use glam::{Quat, Vec3};
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::cpu::elites::{elites, orderable};
use rest3d_gpu::cpu::energy::{Trial, energy, penetration};
use rest3d_gpu::cpu::moments::moments;
use rest3d_gpu::cpu::place::place;
use rest3d_gpu::cpu::sample::sample;
use rest3d_gpu::cpu::search::{CpuSearch, GoesOn, Record, Rollout};
use rest3d_gpu::world::{
    Backend, BodyDef, CemSettings, Distribution, Energy, EnergyWeights, IterationStats, PenetrationMode, Pose, STATIC,
    Search, SearchSettings, Status, Stream, Velocity, World,
};
use std::f32::consts::FRAC_PI_2;

const STREAM: Stream = Stream { seed: 5, stage: 2 };

fn def(unit: u32, start: Pose, reference: Pose) -> BodyDef {
    let parts = vec![cuboid(Vec3::splat(0.1))];
    BodyDef { parts, mass: 1.0, inertia: Vec3::splat(0.01), unit, start, reference }
}

/// A static body, a unit of two bodies, a unit of one.
fn world() -> World {
    let at = |x: f32| Pose::new(Quat::from_rotation_y(0.1 * x), Vec3::new(x, 1.0, 0.0));
    let wanted = |x: f32| Pose::new(Quat::from_rotation_y(0.1 * x), Vec3::new(x + 0.03, 1.0, -0.02));
    World::new(
        &[
            def(STATIC, at(0.0), at(0.0)),
            def(0, at(1.0), wanted(1.0)),
            def(0, at(2.0), wanted(2.0)),
            def(1, at(5.0), at(5.0)),
        ],
        &[1, 3],
    )
}

#[test]
fn a_unit_turns_about_its_root_and_takes_its_bodies_along() {
    let world = world();
    let mut poses = world.start.clone();
    let mut delta = [0.0; 12];
    delta[..6].copy_from_slice(&[0.1, 0.2, 0.3, 0.0, FRAC_PI_2, 0.0]);
    place(&world, &delta, &mut poses);
    assert_eq!(poses[0], world.start[0]);
    // A quarter turn about y takes the second body from +x to −z of the root. f32 rounding at coordinates near 1.
    let near = |a: Vec3, b: Vec3| a.distance(b) < 1e-6;
    assert!(near(poses[1].translation, Vec3::new(1.1, 1.2, 0.3)), "{:?}", poses[1]);
    assert!(near(poses[2].translation, Vec3::new(1.1, 1.2, -0.7)), "{:?}", poses[2]);
    assert!(poses[2].rotation.dot(Quat::from_rotation_y(FRAC_PI_2 + 0.2)).abs() > 1.0 - 1e-6);
    assert!(near(poses[3].translation, world.start[3].translation));
}

#[test]
fn no_adjustment_leaves_everything_in_place() {
    let world = world();
    let mut poses = vec![Pose::IDENTITY; 4];
    place(&world, &[0.0; 12], &mut poses);
    for (pose, start) in poses.iter().zip(&world.start) {
        assert!(pose.translation.distance(start.translation) < 1e-6 && pose.rotation.dot(start.rotation) > 1.0 - 1e-6);
    }
}

#[test]
fn energy_by_hand() {
    let world = world();
    let weights = EnergyWeights::default();
    let placed = world.start.clone();
    let mut settled = placed.clone();
    settled[0].translation.y -= 9.0; // static: must not count
    settled[1].translation.y -= 0.1;
    settled[3].rotation *= Quat::from_rotation_x(0.2);
    let mut snapshot = vec![Velocity::default(); 4];
    snapshot[0].linear = Vec3::X * 100.0;
    snapshot[2] = Velocity::new(Vec3::new(0.0, 0.3, 0.4), Vec3::splat(7.0));
    let depths_placed = [0.0, 0.002, 0.5, 0.0009, 0.0];
    let depths_settled = [0.0, 0.0, 0.0, 0.0, 0.0011];
    let trial = Trial {
        placed: &placed,
        settled: &settled,
        snapshot: &snapshot,
        depths_placed: &depths_placed,
        depths_settled: &depths_settled,
        status: Status::ITERATIONS,
    };
    let found = energy(&world, &weights, &trial);
    // Sums of a few f32 terms below 10.
    let near = |a: f32, b: f32| (a - b).abs() < 1e-5;
    assert!(near(found.stability, 0.1 + 0.2), "{found:?}");
    assert!(near(found.velocity, 0.5), "{found:?}");
    assert_eq!(found.penetration, 3.0);
    let layout = 6.0 * (Vec3::new(0.03, 0.1, 0.02).length() + Vec3::new(0.03, 0.0, 0.02).length()) + 0.2;
    assert!(near(found.layout, layout), "{found:?} {layout}");
    assert!(near(found.total, 0.3 + 0.5 + 0.5 * 3.0 + layout), "{found:?}");

    let failed = energy(&world, &weights, &Trial { status: Status::CONTACTS, ..trial });
    assert_eq!(failed.total, f32::INFINITY);
    let mut broken = settled.clone();
    broken[2].translation.x = f32::NAN;
    assert_eq!(energy(&world, &weights, &Trial { settled: &broken, ..trial }).total, f32::INFINITY);
}

#[test]
fn depth_counts_beyond_touching() {
    let weights = EnergyWeights { penetration_mode: PenetrationMode::Depth, ..Default::default() };
    // (21 mm + 11 mm − 2 · 1 mm) / 20 mm
    let found = penetration(&[0.021, 0.001, 0.0, 0.011], &weights);
    assert!((found - 1.5).abs() < 1e-5, "{found}");
}

fn of_total(total: f32) -> Energy {
    Energy { total, stability: 0.0, velocity: 0.0, penetration: 0.0, layout: 0.0 }
}

#[test]
fn keys_have_the_order_of_energies() {
    let sorted = [f32::NEG_INFINITY, -1.0, -0.0, 0.0, 1e-40, 1.0, f32::MAX, f32::INFINITY, f32::NAN];
    assert!(sorted.windows(2).all(|pair| orderable(pair[0]) < orderable(pair[1])));
}

#[test]
fn elites_are_in_rank_order_with_ties_to_the_lower_index() {
    let energies = [3.0, 1.0, f32::INFINITY, 1.0, 0.5, f32::NAN, 3.0].map(of_total);
    let mut order = [99; 7];
    assert_eq!(elites(&energies, 4, &mut order), 4);
    assert_eq!(order, [4, 1, 3, 0, 6, 2, 5]);
    assert_eq!(elites(&energies, 6, &mut order), 5, "failed candidates are no elites");
}

#[test]
fn moments_by_hand() {
    let deltas = [1.0, 10.0, f32::NAN, f32::NAN, 3.0, 10.0, 5.0, 10.0];
    let (mut mean, mut std) = ([0.0; 2], [0.0; 2]);
    moments(&deltas, &[3, 0, 2], 0.5, &[0.0, 2.0], &mut mean, &mut std);
    assert_eq!(mean, [3.0, 10.0]);
    assert!((std[0] - ((8.0_f32 / 3.0).sqrt() + 0.5)).abs() < 1e-6, "{std:?}");
    assert_eq!(std[1], 2.0, "floor");
    moments(&deltas, &[], 0.5, &[0.0, 2.0], &mut mean, &mut std);
    assert_eq!(mean, [3.0, 10.0]);
}

/// Things stay where they are placed; candidates with a first body left of `fail_below` fail.
struct Still {
    fail_below: f32,
}

/// Things stay, but what was placed to the right of the start is found out to be bad after some steps.
struct FoundOut;

impl Rollout for FoundOut {
    type Scratch = u32;

    fn scratch(&self) -> u32 {
        0
    }

    fn run(&self, scratch: &mut u32, placed: &[Pose], steps: u32, records: &mut [Record], _: &GoesOn<'_>) {
        NEVER.run(scratch, placed, steps, records, &|_, _| true);
        if steps > 0 && placed[1].translation.x > 1.0 {
            records[0].depths_settled.fill(1.0);
        }
    }
}

impl Rollout for Still {
    /// Counts its own rollouts, so that a search that leaks scratch into results can be caught.
    type Scratch = u32;

    /// Some, so that every population has a smaller run at its end.
    fn at_once(&self) -> usize {
        3
    }

    fn scratch(&self) -> u32 {
        0
    }

    fn run(&self, scratch: &mut u32, placed: &[Pose], _: u32, records: &mut [Record], _: &GoesOn<'_>) {
        let bodies = placed.len() / records.len();
        for (record, placed) in records.iter_mut().zip(placed.chunks_exact(bodies)) {
            *scratch += 1;
            record.settled.copy_from_slice(placed);
            record.snapshot.fill(Velocity::default());
            record.depths_placed.fill(0.0);
            record.depths_settled.fill(0.0);
            let fails = placed[1].translation.x < self.fail_below;
            record.status = if fails { Status::NOT_FINITE } else { Status::default() };
        }
    }
}

const NEVER: Still = Still { fail_below: f32::NEG_INFINITY };
const ALWAYS: Still = Still { fail_below: f32::INFINITY };

fn settings(candidates: u32) -> SearchSettings {
    let cem = CemSettings { candidates, elite_fraction: 0.1, ..Default::default() };
    SearchSettings { cem, ..Default::default() }
}

#[test]
fn the_search_finds_the_optimum() {
    let (world, settings) = (world(), settings(500));
    let mut search = CpuSearch::new(&world, &settings, STREAM, NEVER);
    let mut best = f32::INFINITY;
    for iteration in 0..40 {
        let stats = search.iterate().unwrap();
        assert_eq!(stats.iteration, iteration);
        assert!(stats.best.total <= best && stats.best.total <= stats.iteration_best);
        best = stats.best.total;
    }
    let found = search.best().unwrap().unwrap();
    // The optimum is zero, at a shift of (0.03, 0, −0.02) of the first unit: 6 · 36 mm · 2 bodies = 0.43 at the start.
    assert!(found.energy.total < 0.01, "{found:?}");
    assert!((found.delta[0] - 0.03).abs() < 1e-3 && (found.delta[2] + 0.02).abs() < 1e-3, "{:?}", found.delta);
    let mut placed = world.start.clone();
    place(&world, &found.delta, &mut placed);
    assert_eq!(found.placed, placed);
    assert_eq!(found.settled, placed);
}

#[test]
fn an_energy_depends_on_neither_neighbours_nor_threads() {
    let world = world();
    let energies = |candidates: u32, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let settings = settings(candidates);
            let mut search = CpuSearch::new(&world, &settings, STREAM, NEVER);
            search.iterate().unwrap();
            search.energies().unwrap()
        })
    };
    let many = energies(333, 1);
    assert_eq!(many, energies(333, 3));
    assert_eq!(many[..37], energies(37, 2));
}

#[test]
fn a_seed_repeats_and_another_differs() {
    let (world, settings) = (world(), settings(123));
    let run = |stream| {
        let mut search = CpuSearch::new(&world, &settings, stream, Still { fail_below: 1.01 });
        let stats: Vec<_> = (0..5).map(|_| search.iterate().unwrap()).collect();
        (stats, search.best().unwrap().unwrap(), search.distribution())
    };
    let first = run(STREAM);
    assert_eq!(first, run(STREAM));
    assert_ne!(first.2, run(Stream { seed: 6, stage: 2 }).2);
    assert_ne!(first.2, run(Stream { seed: 5, stage: 3 }).2);
}

#[test]
fn failed_candidates_are_counted_and_never_win() {
    let (world, settings) = (world(), settings(200));
    let mut search = CpuSearch::new(&world, &settings, STREAM, Still { fail_below: 1.0 });
    let stats = search.iterate().unwrap();
    let failed = stats.flagged[2];
    // Placement is to the right of the start in one candidate of two: 100 ± 7.
    assert!((65..135).contains(&failed), "{failed}");
    assert_eq!(stats.flagged, [0, 0, failed, 0]);
    assert_eq!(search.energies().unwrap().iter().filter(|e| e.total == f32::INFINITY).count() as u32, failed);
    let best = search.best().unwrap().unwrap();
    assert!(best.placed[1].translation.x >= 1.0);
    assert_eq!(search.energies().unwrap()[best.candidate as usize], best.energy);
}

#[test]
fn a_search_without_usable_candidates_has_no_best_and_keeps_its_distribution() {
    let (world, settings) = (world(), settings(50));
    let mut search = CpuSearch::new(&world, &settings, STREAM, ALWAYS);
    let before = search.distribution();
    let stats = search.iterate().unwrap();
    assert_eq!(
        (stats.best.total, stats.iteration_best, stats.elite_mean),
        (f32::INFINITY, f32::INFINITY, f32::INFINITY)
    );
    assert_eq!(stats.flagged, [0, 0, 50, 0]);
    assert!(search.best().unwrap().is_none());
    assert_eq!(search.distribution(), before);
}

#[test]
fn the_best_ever_replaces_the_worst_elite() {
    let (world, settings) = (world(), settings(40));
    let mut search = CpuSearch::new(&world, &settings, STREAM, NEVER);
    search.iterate().unwrap();
    let best = search.best().unwrap().unwrap();
    // Far from everything wanted: all candidates of the second iteration are worse.
    let far = Distribution { mean: vec![2.0; 12], std: vec![0.1; 12] };
    search.set_distribution(&far);
    let stats = search.iterate().unwrap();
    assert!(stats.iteration_best > stats.best.total);
    assert_eq!(search.best().unwrap().unwrap(), best);

    let mut order = vec![0; 40];
    elites(&search.energies().unwrap(), 4, &mut order);
    let mut rows = vec![0.0; 4 * 12];
    rows[..12].copy_from_slice(&best.delta);
    for (row, &candidate) in rows.chunks_exact_mut(12).skip(1).zip(&order) {
        sample(&far.mean, &far.std, STREAM, 1, candidate, row);
    }
    let mut wanted = far;
    moments(&rows, &[0, 1, 2, 3], 1e-5, &[0.0; 12], &mut wanted.mean, &mut wanted.std);
    assert_eq!(search.distribution(), wanted);
}

#[test]
fn candidate_zero_can_be_the_mean() {
    let world = world();
    let mut settings = settings(20);
    settings.cem.sample_mean = true;
    let mut search = CpuSearch::new(&world, &settings, STREAM, NEVER);
    search.iterate().unwrap();
    let mut placed = world.start.clone();
    place(&world, &[0.0; 12], &mut placed);
    let layout: f32 = (1..4).map(|i| 6.0 * placed[i].translation.distance(world.reference[i].translation)).sum();
    // The angle of a rotation to itself is only zero to f32 rounding (a few 1e-4 at worst after normalizing).
    let energy = search.energies().unwrap()[0];
    assert!((energy.total - layout).abs() < 2e-3, "{energy:?} {layout}");
}

#[test]
fn deviations_keep_their_floor() {
    let world = world();
    let mut settings = settings(30);
    settings.cem.std_floor = 0.5;
    let mut search = CpuSearch::new(&world, &settings, STREAM, NEVER);
    for _ in 0..20 {
        search.iterate().unwrap();
    }
    let floor = settings.cem.initial(2).std.iter().map(|std| 0.5 * std).collect::<Vec<_>>();
    let found = search.distribution().std;
    assert!(found.iter().zip(&floor).all(|(std, floor)| std >= floor), "{found:?}");
    // Twenty iterations on a convex energy narrow every dimension to the floor.
    assert!(found.iter().zip(&floor).any(|(std, floor)| std == floor), "{found:?}");
}

/// As `settings`, in three rounds.
fn narrowing(candidates: u32, draws: u32, elite_fraction: f32, finalists: f32) -> SearchSettings {
    let cem = CemSettings { candidates, draws, short_steps: 16, finalists, elite_fraction, ..settings(candidates).cem };
    SearchSettings { cem, ..Default::default() }
}

#[test]
fn rounds_narrow_down_to_no_fewer_than_the_elites() {
    let rounds = |settings: SearchSettings, steps| -> Vec<[u32; 2]> {
        settings.cem.rounds(steps).iter().map(|round| [round.candidates, round.steps]).collect()
    };
    assert_eq!(rounds(settings(50), 60), [[50, 60]], "the paper's");
    assert_eq!(rounds(narrowing(50, 4, 0.1, 0.25), 60), [[200, 0], [50, 16], [13, 60]]);
    assert_eq!(rounds(narrowing(50, 4, 0.5, 0.25), 60), [[200, 0], [50, 16], [25, 60]], "elites");
    assert_eq!(rounds(narrowing(50, 1, 0.1, 0.25), 60), [[50, 16], [13, 60]]);
    assert_eq!(rounds(narrowing(50, 4, 0.1, 0.25), 16), [[200, 0], [50, 16]], "no longer than short");
}

#[test]
fn few_that_were_chosen_are_as_good_as_all() {
    // What a candidate costs is known as it is placed, so the best of all reach the last round.
    let world = world();
    let (few, all) = (narrowing(25, 4, 0.24, 0.3), narrowing(100, 1, 0.06, 1.0));
    let mut few = CpuSearch::new(&world, &few, STREAM, NEVER);
    let mut all = CpuSearch::new(&world, &all, STREAM, NEVER);
    for iteration in 0..5 {
        let found = few.iterate().unwrap();
        assert_eq!(found, IterationStats { steps: found.steps, ..all.iterate().unwrap() }, "{iteration}");
        assert_eq!(few.distribution(), all.distribution(), "{iteration}");
    }
    assert_eq!(few.best().unwrap(), all.best().unwrap());
    let (few, all) = (few.energies().unwrap(), all.energies().unwrap());
    assert_eq!(few.len(), 100);
    let finalists: Vec<usize> = (0..100).filter(|&candidate| few[candidate].total.is_finite()).collect();
    assert_eq!(finalists.len(), 8);
    let worst = finalists.iter().map(|&candidate| few[candidate].total).fold(0.0, f32::max);
    for candidate in 0..100 {
        let chosen = finalists.contains(&candidate);
        assert!(if chosen { few[candidate] == all[candidate] } else { all[candidate].total >= worst }, "{candidate}");
    }
}

#[test]
fn what_is_found_out_does_not_go_on() {
    let (world, settings) = (world(), narrowing(40, 4, 0.1, 0.25));
    let mut search = CpuSearch::new(&world, &settings, STREAM, FoundOut);
    search.iterate().unwrap();
    let energies = search.energies().unwrap();
    let finalists = |&candidate: &u32| energies[candidate as usize].total.is_finite();
    let finalists: Vec<u32> = (0..160).filter(finalists).collect();
    assert_eq!(finalists.len(), 10);
    for candidate in finalists {
        assert!(search.placed(candidate).unwrap()[1].translation.x <= 1.0, "{candidate} had been found out");
    }
    // It was a near thing: the wanted place is on the right, so more than half of those chosen as placed were there.
    let right = |candidate: &u32| search.placed(*candidate).unwrap()[1].translation.x > 1.0;
    let chosen = (0..160).filter(|&candidate| energies[candidate as usize].penetration > 0.0);
    assert!(chosen.clone().all(|candidate| right(&candidate)) && (20..40).contains(&chosen.count()));
}

#[test]
fn what_is_passed_over_is_known_as_it_was_placed() {
    let (world, settings) =
        (world(), SearchSettings { cem: CemSettings { draws: 6, ..settings(5).cem }, ..Default::default() });
    let mut search = CpuBackend.search(&world, &settings, STREAM).unwrap();
    for iteration in 0..2 {
        search.iterate().unwrap();
        let energies = search.energies().unwrap();
        let out: Vec<u32> = (0..30).filter(|&candidate| energies[candidate as usize].total.is_infinite()).collect();
        assert_eq!(out.len(), 25, "{iteration}");
        for candidate in out {
            let placed = search.placed(candidate).unwrap();
            let depths = CpuBackend.overlaps(&world, &settings.simulation, &placed).unwrap();
            let snapshot = vec![Velocity::default(); placed.len()];
            let trial = Trial {
                placed: &placed,
                settled: &placed,
                snapshot: &snapshot,
                depths_placed: &depths,
                depths_settled: &depths,
                status: Status::default(),
            };
            let expected = Energy { total: f32::INFINITY, ..energy(&world, &settings.energy, &trial) };
            assert_eq!(energies[candidate as usize], expected, "{iteration}: {candidate}");
        }
    }
}

#[test]
fn a_world_without_units_is_an_error() {
    let world = World::new(&[def(STATIC, Pose::IDENTITY, Pose::IDENTITY)], &[]);
    let settings = settings(3);
    assert!(CpuSearch::new(&world, &settings, STREAM, NEVER).iterate().is_err());
}
