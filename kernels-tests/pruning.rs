//! Candidates that are sure to lose are given up, and the search goes as without.

#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::hulls::cuboid;
use glam::{Quat, Vec3};
use proptest::prelude::*;
use rest3d_gpu::cpu::energy::{Trial, energy, least};
use rest3d_gpu::cpu::{CpuSearch, GoesOn, Group, Record, Rollout, Simulator};
use rest3d_gpu::world::{
    Best, BodyDef, CemSettings, Distribution, EnergyWeights, IterationStats, PenetrationMode, Pose, STATIC, Search,
    SearchSettings, SimSettings, Status, Stream, Velocity, World,
};
use std::ops::Range;

const ITERATIONS: u32 = 3;
const STEPS: u32 = 30;
const STREAM: Stream = Stream { seed: 3, stage: 0 };

fn def(unit: u32, half: Vec3, start: Vec3) -> BodyDef {
    let start = Pose::new(Quat::IDENTITY, start);
    let inertia = Vec3::splat(0.7 * half.max_element() * half.max_element());
    BodyDef { parts: vec![cuboid(half)], mass: 1.0, inertia, unit, start, reference: start }
}

/// A table, and three cubes on it of which two overlap.
fn world() -> World {
    let cube = Vec3::splat(0.05);
    World::new(
        &[
            def(STATIC, Vec3::new(0.5, 0.1, 0.5), Vec3::Y * 0.1),
            def(0, cube, Vec3::new(0.0, 0.251, 0.0)),
            def(1, cube, Vec3::new(0.08, 0.251, 0.01)),
            def(2, cube, Vec3::new(-0.3, 0.251, 0.1)),
        ],
        &[1, 2, 3],
    )
}

/// To be stable is worth as much as to be in place, so that a candidate's place tells much of what it will cost.
fn settings(cem: CemSettings) -> SearchSettings {
    let cem = CemSettings { translation_std: [0.1, 0.02, 0.1], rotation_std: [0.1; 3], ..cem };
    let energy = EnergyWeights { stability: 6.0, penetration_mode: PenetrationMode::Depth, ..EnergyWeights::default() };
    SearchSettings { cem, energy, simulation: SimSettings { steps: STEPS, ..SimSettings::default() } }
}

/// The simulator, in which all fail in the end but those whose cube that is placed farthest off along x is off by so
/// much, m.
struct Failing<'a> {
    world: &'a World,
    simulator: Simulator<'a>,
    works: Range<f32>,
}

impl Rollout for Failing<'_> {
    type Scratch = Group;

    fn at_once(&self) -> usize {
        self.simulator.at_once()
    }

    fn scratch(&self) -> Group {
        self.simulator.scratch()
    }

    fn run(&self, group: &mut Group, placed: &[Pose], steps: u32, records: &mut [Record], goes_on: &GoesOn<'_>) {
        self.simulator.run(group, placed, steps, records, goes_on);
        let bodies = placed.len() / records.len();
        for (record, placed) in records.iter_mut().zip(placed.chunks_exact(bodies)) {
            let off = placed.iter().zip(&self.world.reference).map(|(a, b)| (a.translation.x - b.translation.x).abs());
            if record.steps == STEPS && !self.works.contains(&off.fold(0.0, f32::max)) {
                record.status = Status::NOT_FINITE;
            }
        }
    }
}

/// What a search came to, iteration by iteration, and in the end.
#[derive(Debug, PartialEq)]
struct Course {
    stats: Vec<IterationStats>,
    distributions: Vec<Distribution>,
    best: Option<Best>,
}

impl Course {
    fn of(settings: &SearchSettings, works: Range<f32>) -> Self {
        let world = world();
        let rollout = Failing { world: &world, simulator: Simulator::new(&world, &settings.simulation), works };
        let mut search = CpuSearch::new(&world, settings, STREAM, rollout);
        let mut course = Self { stats: Vec::new(), distributions: Vec::new(), best: None };
        for _ in 0..ITERATIONS {
            course.stats.push(search.iterate().unwrap());
            course.distributions.push(search.distribution());
        }
        course.best = search.best().unwrap();
        course
    }

    fn steps(&self) -> u64 {
        self.stats.iter().map(|stats| stats.steps).sum()
    }
}

/// Searches with pruning and without, and compares everything but the number of steps and the flags of what was given
/// up; gives the first, and its share of steps.
fn pruned(settings: &SearchSettings, works: Range<f32>) -> (Course, f64) {
    let with = |prune| SearchSettings { cem: CemSettings { prune, ..settings.cem.clone() }, ..settings.clone() };
    let [pruned, full] = [true, false].map(|prune| Course::of(&with(prune), works.clone()));
    for (one, other) in pruned.stats.iter().zip(&full.stats) {
        assert_eq!(one, &IterationStats { steps: one.steps, flagged: one.flagged, ..other.clone() });
        assert_eq!(other.steps, settings.steps());
        assert!(one.flagged.iter().zip(other.flagged).all(|(one, other)| *one <= other));
    }
    assert_eq!(pruned.distributions, full.distributions);
    assert_eq!(pruned.best, full.best);
    let share = pruned.steps() as f64 / full.steps() as f64;
    (pruned, share)
}

const EVERYWHERE: Range<f32> = 0.0..f32::INFINITY;

#[test]
fn elites_means_and_result_are_the_same_with_fewer_steps() {
    let cem = CemSettings { candidates: 2500, elite_fraction: 0.03, ..Default::default() };
    let (course, share) = pruned(&settings(cem.clone()), EVERYWHERE);
    assert!(share < 0.98, "{share} of the steps");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(5).build().unwrap();
    assert_eq!(course, pool.install(|| Course::of(&settings(cem), EVERYWHERE)), "with other threads");
}

#[test]
fn a_round_hands_on_the_same_candidates() {
    let cem = CemSettings {
        candidates: 2500,
        elite_fraction: 0.02,
        short_steps: 20,
        finalists: 0.2,
        sample_mean: true,
        ..Default::default()
    };
    // The best of the finalists fail, so that others matter even beyond the number of elites.
    let (_, share) = pruned(&settings(cem), 0.08..f32::INFINITY);
    assert!(share < 0.98, "{share} of the steps");
}

#[test]
fn what_falls_is_given_up_for_its_own_speed() {
    // An early look at speeds that matter: what stands by then costs much less than what still falls.
    let cem = CemSettings { candidates: 2500, elite_fraction: 0.03, ..Default::default() };
    let mut settings = settings(cem);
    settings.simulation.snapshot_step = 3;
    settings.energy.velocity = 10.0;
    let (course, share) = pruned(&settings, EVERYWHERE);
    assert!(share < 0.98, "{share} of the steps");
    // No multiple of whole runs.
    assert!(course.stats.iter().any(|stats| stats.steps % u64::from(STEPS) != 0), "none was given up at step τ");
    for step in [0, 99] {
        settings.simulation.snapshot_step = step;
        pruned(&settings, EVERYWHERE);
    }
}

#[test]
fn as_long_as_too_few_are_usable_none_is_given_up() {
    let cem = CemSettings { candidates: 2500, elite_fraction: 0.1, ..Default::default() };
    // A few in a thousand, and they are cheap.
    let few = settings(cem);
    let (course, _) = pruned(&few, 0.0..0.02);
    assert!(course.stats[0].iteration_best.is_finite());
    assert_eq!(course.stats[0].steps, few.steps());
    // Nine of ten, without the cheapest.
    let cem = CemSettings { candidates: 2500, elite_fraction: 0.03, ..Default::default() };
    let (_, share) = pruned(&settings(cem), 0.05..f32::INFINITY);
    assert!(share < 0.98, "{share} of the steps");
}

/// A turn and a shift.
fn motion() -> impl Strategy<Value = (Vec3, Vec3)> {
    let vector = || [-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0].prop_map(Vec3::from);
    (vector(), vector())
}

/// Of this size, and only turns, only shifts, or both: what rounding does to one of them must not hide behind the
/// other.
fn sized(size: f32, kind: u8, (turn, shift): (Vec3, Vec3)) -> (Vec3, Vec3) {
    let (turn, shift) = (3.0 * size * turn, size * shift);
    match kind {
        0 => (turn, Vec3::ZERO),
        1 => (Vec3::ZERO, shift),
        _ => (turn, shift),
    }
}

fn moved(pose: &Pose, (turn, shift): (Vec3, Vec3)) -> Pose {
    Pose::new((Quat::from_scaled_axis(turn) * pose.rotation).normalize(), pose.translation + shift)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]
    #[test]
    fn what_is_sure_is_no_more_than_what_comes(
        motions in prop::collection::vec((motion(), motion()), 4),
        size in -7.0f32..0.0,
        kind in 0u8..3,
        still in any::<bool>(),
        stay in 0.0f32..1.0,
        speed in 0.0f32..2.0,
        depths in prop::collection::vec(0.0f32..0.05, 6),
        weights in [0.0f32..3.0, 0.0f32..3.0, 0.0f32..3.0, 0.0f32..3.0, 0.0f32..10.0],
        heavy in 0.0f32..6.0,
        count in any::<bool>(),
    ) {
        let mut world = world();
        let sized = |motion| sized(10f32.powf(size), kind, motion);
        let motions: Vec<_> = motions.into_iter().map(|(one, other)| (sized(one), sized(other))).collect();
        let (speed, depths) = if still { (0.0, vec![0.0; 6]) } else { (speed, depths) };
        // Half-way and at either end the bound is sharp.
        let stay = if still { (2.0 * stay).round() / 2.0 } else { stay };
        let [stability, velocity, penetration, layout, position] = weights;
        let heavy = 10f32.powf(heavy);
        let penetration_mode = if count { PenetrationMode::Count } else { PenetrationMode::Depth };
        let weights = EnergyWeights { stability: heavy * stability, velocity, penetration, layout: heavy * layout,
            position, penetration_mode, penetration_depth_unit: 0.02 };
        let placed: Vec<Pose> = world.start.iter().zip(&motions).map(|(pose, (one, _))| moved(pose, *one)).collect();
        world.reference = placed.iter().zip(&motions).map(|(pose, (_, other))| moved(pose, *other)).collect();
        // Where it settles: between its placement and the reference.
        let settled: Vec<Pose> = placed.iter().zip(&motions).map(|(pose, (_, (turn, shift)))| {
            moved(pose, (stay * *turn, stay * *shift))
        }).collect();
        let snapshot = vec![Velocity::new(Vec3::X * speed, Vec3::ZERO); 4];
        let depths = &depths[..world.pairs.len()];
        let none = vec![0.0; depths.len()];
        let trial = Trial { placed: &placed, settled: &settled, snapshot: &snapshot, depths_placed: depths,
            depths_settled: &none, status: Status::default() };
        let cost = energy(&world, &weights, &trial).total;
        let rest = vec![Velocity::default(); 4];
        for snapshot in [&rest, &snapshot] {
            let sure = least(&world, &weights, &placed, snapshot, depths);
            prop_assert!(sure <= cost, "{sure} > {cost}");
        }
    }
}
