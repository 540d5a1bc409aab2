//! Candidates that are sure to lose are given up, and everything else stays the same.

#![allow(missing_docs, clippy::unwrap_used)]

use glam::{Quat, Vec3};
use proptest::prelude::*;
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::cpu::energy::{Trial, energy, least};
use rest3d_gpu::world::{
    Backend, Best, BodyDef, CemSettings, Distribution, EnergyWeights, IterationStats, PenetrationMode, Pose, STATIC,
    SearchSettings, SimSettings, Status, Stream, Velocity, World,
};

const ITERATIONS: u32 = 4;
const STREAM: Stream = Stream { seed: 3, stage: 0 };

fn def(unit: u32, half: Vec3, start: Vec3) -> BodyDef {
    let corner = |i: usize| half * (Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0);
    let start = Pose::new(Quat::IDENTITY, start);
    let inertia = Vec3::splat(0.7 * half.max_element() * half.max_element());
    BodyDef { parts: vec![(0..8).map(corner).collect()], mass: 1.0, inertia, unit, start, reference: start }
}

/// A table, and three cubes just above it of which two overlap.
fn world() -> World {
    let cube = Vec3::splat(0.05);
    World::new(
        &[
            def(STATIC, Vec3::new(0.5, 0.1, 0.5), Vec3::Y * 0.1),
            def(0, cube, Vec3::new(0.0, 0.26, 0.0)),
            def(1, cube, Vec3::new(0.08, 0.26, 0.01)),
            def(2, cube, Vec3::new(-0.3, 0.27, 0.1)),
        ],
        &[1, 2, 3],
    )
}

/// To be stable is worth as much as to be in place, so that a candidate's place tells much of what it will cost.
fn settings(cem: CemSettings) -> SearchSettings {
    let cem = CemSettings { translation_std: [0.1, 0.02, 0.1], rotation_std: [0.1; 3], ..cem };
    let energy = EnergyWeights { stability: 6.0, penetration_mode: PenetrationMode::Depth, ..EnergyWeights::default() };
    SearchSettings { cem, energy, simulation: SimSettings { steps: 30, ..SimSettings::default() } }
}

/// What a search came to, iteration by iteration, and in the end.
struct Course {
    stats: Vec<IterationStats>,
    distributions: Vec<Distribution>,
    best: Option<Best>,
}

impl Course {
    fn of(world: &World, settings: &SearchSettings) -> Self {
        let mut search = CpuBackend.search(world, settings, STREAM).unwrap();
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

/// Searches with pruning and without, and compares everything but the number of steps; gives the first, and its share of steps.
fn pruned(cem: CemSettings) -> (Course, f64) {
    let world = world();
    let [pruned, full] = [true, false].map(|prune| Course::of(&world, &settings(CemSettings { prune, ..cem.clone() })));
    for (one, other) in pruned.stats.iter().zip(&full.stats) {
        assert_eq!(one, &IterationStats { steps: one.steps, ..other.clone() });
        assert_eq!(other.steps, settings(cem.clone()).steps());
    }
    assert_eq!(pruned.distributions, full.distributions);
    assert_eq!(pruned.best, full.best);
    let share = pruned.steps() as f64 / full.steps() as f64;
    (pruned, share)
}

#[test]
fn elites_means_and_result_are_the_same_with_fewer_steps() {
    let (course, share) = pruned(CemSettings { candidates: 1200, elite_fraction: 0.03, ..Default::default() });
    assert!(share < 0.9, "{share} of the steps");
    // Half a run is up to step τ: an odd number of halves says that some were given up there.
    assert!(course.stats.iter().any(|stats| stats.steps % 30 == 15), "none was given up at step τ");
}

#[test]
fn a_round_hands_on_the_same_candidates() {
    let cem =
        CemSettings { candidates: 1000, elite_fraction: 0.1, short_steps: 20, finalists: 0.1, ..Default::default() };
    let (_, share) = pruned(cem);
    assert!(share < 0.98, "{share} of the steps");
}

#[test]
fn too_few_usable_candidates_give_up_none() {
    // All are wanted, so none is sure to be one too many.
    let (_, share) = pruned(CemSettings { candidates: 300, elite_fraction: 1.0, ..Default::default() });
    assert!(share == 1.0, "{share} of the steps");
}

fn pose() -> impl Strategy<Value = Pose> {
    let number = -1.0f32..1.0;
    let turn = [number.clone(), number.clone(), number.clone()].prop_map(|turn| Vec3::from(turn) * 3.0);
    let place = [number.clone(), number.clone(), number].prop_map(Vec3::from);
    (turn, place).prop_map(|(turn, place)| Pose::new(Quat::from_scaled_axis(turn), place))
}

proptest! {
    #[test]
    fn what_is_sure_is_no_more_than_what_comes(
        poses in prop::collection::vec((pose(), pose()), 4),
        stay in 0.0f32..1.0,
        speed in 0.0f32..2.0,
        depths in prop::collection::vec(0.0f32..0.05, 6),
        weights in [0.0f32..3.0, 0.0f32..3.0, 0.0f32..3.0, 0.0f32..3.0, 0.0f32..10.0],
        count in any::<bool>(),
    ) {
        let world = world();
        let [stability, velocity, penetration, layout, position] = weights;
        let penetration_mode = if count { PenetrationMode::Count } else { PenetrationMode::Depth };
        let weights = EnergyWeights { stability, velocity, penetration, layout, position, penetration_mode,
            penetration_depth_unit: 0.02 };
        let (placed, aims): (Vec<Pose>, Vec<Pose>) = poses.into_iter().unzip();
        // Where it settles: anywhere between its placement, the reference and a third place, where the bound is sharp.
        let settled: Vec<Pose> = (0..4).map(|i| {
            let to = if i % 2 == 0 { world.reference[i] } else { aims[i] };
            let place = placed[i].translation.lerp(to.translation, stay);
            Pose::new(placed[i].rotation.slerp(to.rotation, stay), place)
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
