//! Layouts that are known to stand: every `truth.json` of the shared scenes, with our own convex parts, for five
//! seconds; and the solver's settings compared on some of them.
//!
//! Slow, because every mesh is decomposed: `scripts/test-slow` runs them.

#![allow(clippy::unwrap_used)]

mod common;

use common::hulls::{cuboid, prism};
use common::scenario::{Scenario, State, box_inertia, run};
use common::scenes::as_it_stands;
use glam::{Quat, Vec3};
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::scene::Scene;
use rest3d_gpu::world::{Backend, Flow, NarrowPhase, Pose, SimSettings, World, angle_between};
use std::time::Instant;

/// Unstable beyond this, m and rad: the paper's metric.
const STABLE: f32 = 0.1;

/// Most that the mean object may drift, m.
const MEAN_DRIFT: f32 = 5e-3;

/// Most that any object may creep between steps 200 and 300, m.
const CREEP: f32 = 2e-4;

/// A room as it is known to stand.
fn room(name: &str) -> (Scene, World) {
    as_it_stands(&format!("../shared/scenes/{name}/truth.json"))
}

fn stands(name: &str) {
    let (scene, world) = room(name);
    let settings = SimSettings { steps: 300, ..Default::default() };
    let (mut at_200, mut end): (Vec<Pose>, Vec<Pose>) = Default::default();
    let status = CpuBackend.simulate(&world, &settings, &world.start, &mut |step, poses, _| {
        match step + 1 {
            200 => at_200 = poses.to_vec(),
            300 => end = poses.to_vec(),
            _ => {}
        }
        Flow::Continue
    });
    assert!(status.unwrap().iter().all(|status| status.is_usable()));
    let distance = |from: &[Pose], i: usize| from[i].translation.distance(end[i].translation);
    let moving: Vec<usize> = (0..world.bodies.len()).filter(|&i| !world.bodies[i].is_static()).collect();
    for &i in &moving {
        let (drift, turn) = (distance(&world.start, i), angle_between(world.start[i].rotation, end[i].rotation));
        assert!(drift <= STABLE && turn <= STABLE, "{}: {drift} m, {turn} rad", scene.objects[i].name);
        let creep = distance(&at_200, i);
        assert!(creep < CREEP, "{} creeps by {creep} m", scene.objects[i].name);
    }
    let mean = moving.iter().map(|&i| distance(&world.start, i)).sum::<f32>() / moving.len() as f32;
    let creep = moving.iter().map(|&i| distance(&at_200, i)).fold(0.0, f32::max);
    eprintln!("{name}: {} movable objects, mean drift {mean} m, largest creep {creep} m", moving.len());
    assert!(mean < MEAN_DRIFT, "mean drift {mean} m");
}

macro_rules! truths {
    ($($name:ident)*) => {$(
        #[test]
        #[ignore = "slow: scripts/test-slow"]
        fn $name() {
            stands(stringify!($name));
        }
    )*};
}

truths! {
    bedroom
    deep_interpenetration
    dining_room
    living_room
    minimal
    office
    study
    tabletop_desk
    wall_ceiling
}

/// Drift and creep of a simulation: mean way of what moves from its start, and farthest way in the last hundred steps,
/// m.
fn way(world: &World, states: &[State]) -> (f32, f32) {
    let moving: Vec<usize> = (0..world.bodies.len()).filter(|&i| !world.bodies[i].is_static()).collect();
    let end = &states[states.len() - 1].0;
    let before = &states[states.len() - 100].0;
    let from = |poses: &[Pose], i: usize| poses[i].translation.distance(end[i].translation);
    let drift = moving.iter().map(|&i| from(&world.start, i)).sum::<f32>() / moving.len() as f32;
    (drift, moving.iter().map(|&i| from(before, i)).fold(0.0, f32::max))
}

fn stack(shape: &[Vec3]) -> World {
    let mut s = Scenario::default();
    for i in 0..10 {
        let at = Pose::new(Quat::IDENTITY, Vec3::Y * (0.1 + 0.2 * i as f32));
        s.body(vec![shape.to_vec()], 1.0, box_inertia(1.0, Vec3::splat(0.1)), at);
    }
    s.world()
}

/// Prints the table of `docs/physics.md`: mean drift and creep of stacks and rooms, and the time of a step.
#[test]
#[ignore = "slow: scripts/test-slow"]
fn settings_compared() {
    let stacks = [stack(&cuboid(Vec3::splat(0.1))), stack(&prism(0.1, 0.1, 8))];
    let rooms = ["study", "living_room", "bedroom"].map(|name| room(name).1);
    let twin = [(2, 6), (1, 12), (4, 3), (4, 6), (2, 3), (1, 6)].map(|(a, b)| (a, b, NarrowPhase::Twin));
    for (substeps, small_steps, narrow_phase) in twin.into_iter().chain([(2, 6, NarrowPhase::Reference)]) {
        let settings = |steps| SimSettings {
            steps,
            substeps,
            position_iterations: small_steps,
            narrow_phase,
            ..Default::default()
        };
        let of = |world: &World, steps| way(world, &run(&CpuBackend, world, &settings(steps)));
        let [boxes, prisms] = [0, 1].map(|i| of(&stacks[i], 600));
        let start = Instant::now();
        let ways = rooms.each_ref().map(|room| of(room, 300));
        let step = start.elapsed().as_secs_f32() / 900.0;
        let drift = ways.iter().map(|w| w.0).sum::<f32>() / 3.0;
        let creep = ways.iter().map(|w| w.1).fold(0.0, f32::max);
        eprintln!(
            "| {substeps} × {small_steps} {narrow_phase:?} | {:.2} mm | {:.2} mm | {:.1} mm | {:.0} µm | {:.2} |",
            1e3 * boxes.0,
            1e3 * prisms.0,
            1e3 * drift,
            1e6 * creep,
            1e3 * step
        );
        if (substeps, small_steps, narrow_phase) == (2, 6, NarrowPhase::Twin) {
            assert!(boxes.0 < 1e-3 && prisms.0 < 1e-3 && drift < MEAN_DRIFT && creep < CREEP);
        }
    }
}
