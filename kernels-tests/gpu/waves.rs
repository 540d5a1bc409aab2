//! Kernel `solve_waves` beside `solve`, at the limits of what it takes.

use super::Test;
use super::fixture::Device;
use super::solver::solved;
use super::states::{State, Tables, course};
use crate::common::hulls::cuboid;
use crate::common::scenario::{Scenario, any};
use glam::{EulerRot, Quat, Vec3};
use libtest_mimic::Failed;
use rest3d_gpu::gpu::{Sim, Way};
use rest3d_gpu::world::{SimSettings, World};

pub const TESTS: &[Test] = &[("waves::end_where_solve_ends_at_every_limit", end_where_solve_ends)];

/// So many boxes, heavy and light. The first `aloft` touch nothing, so that the first patches are between bodies of
/// other invocations than their own; the others lie in a heap, a few of them fixed.
fn heap(bodies: usize, aloft: usize, fixed: usize) -> World {
    let mut scenario = Scenario::default();
    for i in 0..aloft {
        scenario.cuboid(Vec3::splat(0.1), 1.0, Vec3::new(5.0 * i as f32, 3.0, 9.0), Quat::from_rotation_x(i as f32));
    }
    for i in 0..bodies - aloft {
        let noise = |which: usize| any(bodies * 100 + i, which);
        let cell = Vec3::new((i % 3) as f32, (i / 9) as f32 + 0.5, (i / 3 % 3) as f32);
        let at = 0.195 * cell + 0.005 * Vec3::new(noise(1), noise(2), noise(3));
        let turn = Quat::from_euler(EulerRot::XYZ, 0.03 * noise(4), 0.1 * noise(5), 0.03 * noise(6));
        if i % 5 == 2 && i / 5 < fixed {
            scenario.fixed(vec![cuboid(Vec3::splat(0.1))], at, turn);
        } else {
            scenario.cuboid(Vec3::splat(0.1), 0.2 + 4.0 * noise(7).abs(), at, turn);
        }
    }
    scenario.world()
}

/// The first patches of a state, with as many points as that takes, or as many as are wanted; none if it has fewer
/// patches, or they do not hold so many.
fn cut(state: &State, patches: usize, points: Option<usize>) -> Option<State> {
    let mut cut = state.clone();
    cut.patches.truncate(patches);
    let mut counts: Vec<usize> = cut.patches.iter().map(|patch| patch.count as usize).collect();
    if let Some(points) = points {
        while counts.iter().sum::<usize>() > points {
            *counts.iter_mut().max()? -= 1;
        }
        while counts.iter().sum::<usize>() < points {
            *counts.iter_mut().min().filter(|count| **count < 8)? += 1;
        }
    }
    cut.contacts.clear();
    for (patch, count) in cut.patches.iter_mut().zip(counts) {
        let own = &state.contacts[patch.first as usize..][..patch.count as usize];
        (patch.first, patch.count) = (cut.contacts.len() as u32, count as u32);
        cut.contacts.extend(own.iter().cycle().take(count));
    }
    (cut.patches.len() == patches).then_some(cut)
}

fn end_where_solve_ends(device: &Device) -> Result<(), Failed> {
    let settings = SimSettings { velocity_iterations: 2, friction: 0.7, ..Default::default() };
    let mut seen = Vec::new();
    for (bodies, aloft, fixed) in [(20, 8, 0), (31, 8, 2), (32, 8, 2), (32, 26, 0)] {
        let world = heap(bodies, aloft, fixed);
        let sim = Sim { loops: device.gpu.loops(), ..Sim::new(&settings, world.capacities) };
        let states: Vec<State> = course(&world, &settings, 16)
            .into_iter()
            .step_by(5)
            .flat_map(|state| {
                let patches = [0, 1, 31, 32, 33, 63, 64, 65].map(|patches| cut(&state, patches, None));
                let points = [127, 128, 129].map(|points| cut(&state, 32, Some(points)));
                patches.into_iter().chain(points).flatten().chain([state]).collect::<Vec<_>>()
            })
            .filter(|state| state.contacts.len() <= sim.contacts as usize)
            .collect();
        seen.extend(states.iter().map(|state| (bodies, state.patches.len(), state.contacts.len())));
        let tables = Tables::new(&world, &states, states.len() as u32);
        let run = |way| solved(device, (&world, &sim, 0, way), &tables, None);
        let (one_by_one, waves) = (run(Way::Candidates)?, run(Way::Waves)?);
        let differs = |i: &usize| one_by_one.0[i * bodies..][..bodies] != waves.0[i * bodies..][..bodies];
        let exact = device.rounding(1.0) == 0.0;
        if let Some(i) = (0..states.len()).find(|i| one_by_one.1[*i] != waves.1[*i] || exact && differs(i)) {
            let [patches, points] = [states[i].patches.len(), states[i].contacts.len()];
            return Err(format!("{bodies} bodies, {patches} patches, {points} points end elsewhere").into());
        }
    }
    let has = |patches: usize| seen.iter().any(|it| it.1 == patches);
    let full = |points: usize| seen.iter().any(|it| it.1 == 32 && it.2 == points);
    let missing: Vec<usize> = [31, 32, 33, 63, 64, 65].into_iter().filter(|n| !has(*n)).collect();
    if missing.is_empty() && [127, 128, 129].into_iter().all(full) {
        return Ok(());
    }
    Err(format!("no states at some limits: {missing:?} patches; {seen:?}").into())
}
