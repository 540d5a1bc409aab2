//! Kernels `solve_bodies`, `solve_load`, `solve_waves`, `solve`, `integrate`: one substep from the CPU's contacts.

use super::Test;
use super::fixture::{Device, SIZES};
use super::states::{STATES, State, TOLERANCE, Tables, Uploaded, states, states_after};
use crate::common::hulls::truncated_cube;
use crate::common::scenario::Scenario;
use crate::physics::free_motion::hard_heap;
use glam::{Quat, Vec3};
use libtest_mimic::Failed;
use rest3d_gpu::gpu::{Recorder, Sim, Way, rounds};
use rest3d_gpu::world::{Pose, SimSettings, Status, World};

pub const TESTS: &[Test] = &[
    ("solver::is_its_twin", is_its_twin),
    ("solver::tries_again_as_its_twin", tries_again_as_its_twin),
    ("solver::every_kernel_does_its_share", every_kernel_does_its_share),
    ("solver::gives_the_same_bits_again", gives_the_same_bits_again),
    ("solver::goes_on_where_it_stopped", goes_on_where_it_stopped),
    ("solver::tells_what_is_not_done", tells_what_is_not_done),
    ("solver::tells_what_is_not_finite", tells_what_is_not_finite),
];

/// The kernels that solve small steps, each those candidates that the ones before it left.
const SMALL_STEPS: [&str; 2] = ["solve_waves", "solve"];

const WAYS: [Way; 2] = [Way::Candidates, Way::Waves];

/// A stack, a block on a slope, three bodies in mid-air that overlap or are about to, a table, and rods.
fn world() -> World {
    let mut scenario = Scenario::default();
    for level in 0..3 {
        let at = Vec3::Y * (0.1 + 0.2 * level as f32);
        scenario.cuboid(Vec3::splat(0.1), 1.0, at, Quat::from_rotation_y(0.3 * level as f32));
    }
    let tilt = Quat::from_rotation_z(0.4);
    let slope = Vec3::new(2.0, 0.5, 0.0);
    scenario.fixed(vec![truncated_cube(0.5)], slope, tilt);
    scenario.cuboid(Vec3::splat(0.1), 2.0, slope + tilt * (0.599 * Vec3::Y), tilt);
    for x in [0.0, 0.17, 0.36] {
        scenario.body(vec![truncated_cube(0.1)], 1.0, Vec3::splat(0.007), Pose::new(tilt, Vec3::new(x, 2.0, 3.0)));
    }
    scenario.table(8.0);
    // A slender rod on the ground, and one in mid-air.
    let rod = Vec3::new(0.01, 0.01, 0.3);
    scenario.cuboid(rod, 0.2, Vec3::new(0.0, 0.01, -3.0), Quat::from_rotation_y(0.2));
    scenario.cuboid(rod, 0.2, Vec3::new(1.0, 3.0, -3.0), Quat::from_rotation_x(0.2));
    scenario.world()
}

/// Runs a substep in tables of the given parity; compares with what is expected, if anything.
pub fn solved(
    device: &Device,
    how: (&World, &Sim, usize, Way),
    before: &Tables,
    after: Option<&Tables>,
) -> Result<(Vec<Pose>, Vec<u32>), Failed> {
    solved_by(device, how, before, after, |_| true)
}

/// The same, by those runs of the solver's kernels that `is_run` lets pass.
fn solved_by(
    device: &Device,
    how: (&World, &Sim, usize, Way),
    before: &Tables,
    after: Option<&Tables>,
    mut is_run: impl FnMut(&str) -> bool,
) -> Result<(Vec<Pose>, Vec<u32>), Failed> {
    let uploaded = Uploaded::new(device, how, before)?;
    let (_, _, parity, way) = how;
    let mut recorder = Recorder::new(&device.gpu);
    let steps = uploaded.solver.steps(parity).iter();
    recorder.run(steps.filter(|step| !SMALL_STEPS.contains(&step.name) || is_run(step.name)));
    recorder.submit();
    let Uploaded { poses, velocities, statuses, .. } = &uploaded;
    if let Some(after) = after {
        let what = format!("{way:?}, {}, parity {parity}", before.counts.len());
        device.expect(&format!("poses, {what}"), poses, &after.poses, TOLERANCE)?;
        device.expect(&format!("velocities, {what}"), velocities, &after.velocities, TOLERANCE)?;
        uploaded.expect_contacts(device, &what, after)?;
    }
    Ok((device.fetch(poses)?, device.fetch(statuses)?))
}

fn is_its_twin(device: &Device) -> Result<(), Failed> {
    let world = world();
    for (velocity_iterations, rest_offset) in [(1, 0.0), (3, 0.0), (1, 0.001)] {
        let settings = SimSettings { velocity_iterations, rest_offset, ..Default::default() };
        let sim = Sim::new(&settings, world.capacities);
        let (before, after): (Vec<_>, Vec<_>) = states(&world, &settings)?.into_iter().map(|[b, a]| (b, a)).unzip();
        for (parity, candidates) in SIZES.into_iter().enumerate() {
            let tables = [&before, &after].map(|states| Tables::new(&world, states, candidates));
            for way in WAYS {
                solved(device, (&world, &sim, parity % 2, way), &tables[0], Some(&tables[1]))?;
            }
        }
    }
    Ok(())
}

/// Small steps that gain energy, of which a heap that hits the ground has some.
fn tries_again_as_its_twin(device: &Device) -> Result<(), Failed> {
    let settings = SimSettings { velocity_iterations: 2, ..Default::default() };
    for number in [14, 23, 27] {
        let world = hard_heap(number).world();
        let (before, after): (Vec<_>, Vec<_>) =
            states_after(&world, &settings, 0.0, 20..60)?.into_iter().map(|[b, a]| (b, a)).unzip();
        let tables = [&before, &after].map(|states| Tables::new(&world, states, states.len() as u32));
        for way in WAYS {
            solved(device, (&world, &Sim::new(&settings, world.capacities), 0, way), &tables[0], Some(&tables[1]))?;
        }
    }
    Ok(())
}

/// Blocks of so many boxes side by side and on one another, which touch on all sides.
fn block(x: usize, y: usize, z: usize) -> World {
    let mut scenario = Scenario::default();
    for i in 0..x * y * z {
        let at = Vec3::new((i % x) as f32, 0.5 + (i / x % y) as f32, (i / x / y) as f32);
        scenario.cuboid(Vec3::splat(0.1), 1.0, 0.2 * at, Quat::IDENTITY);
    }
    scenario.world()
}

/// A pile that is small enough for a workgroup, and one with too many bodies and patches. Both ways end at the same
/// bits where nothing is fused.
fn every_kernel_does_its_share(device: &Device) -> Result<(), Failed> {
    let settings = SimSettings::default();
    for (world, kernel) in [(block(2, 3, 2), 0), (block(4, 3, 3), 1)] {
        let (before, after): (Vec<_>, Vec<_>) =
            states_after(&world, &settings, 0.0, 0..3)?.into_iter().map(|[b, a]| (b, a)).unzip();
        let tables = [&before, &after].map(|states| Tables::new(&world, states, 7));
        let sim = Sim { loops: device.gpu.loops(), ..Sim::new(&settings, world.capacities) };
        let how = |way| (&world, &sim, 0, way);
        solved(device, how(Way::Waves), &tables[0], Some(&tables[1]))?;
        for (last, name) in SMALL_STEPS.into_iter().enumerate() {
            let up_to = |step: &str| SMALL_STEPS[..=last].contains(&step);
            let (_, statuses) = solved_by(device, how(Way::Waves), &tables[0], None, up_to)?;
            if statuses.iter().any(|status| (*status == 0) != (last >= kernel)) {
                let counts = &tables[0].counts;
                return Err(format!("{name} is not for {}: {counts:?} patches", SMALL_STEPS[kernel]).into());
            }
        }
        let [candidates, waves] = WAYS.map(|way| solved(device, how(way), &tables[0], None));
        if device.rounding(1.0) == 0.0 && candidates?.0 != waves?.0 {
            return Err(format!("{} ends elsewhere than `solve`", SMALL_STEPS[kernel]).into());
        }
    }
    Ok(())
}

fn gives_the_same_bits_again(device: &Device) -> Result<(), Failed> {
    let (world, settings) = (world(), SimSettings::default());
    let before: Vec<State> = states(&world, &settings)?.into_iter().map(|[before, _]| before).collect();
    let run = |candidates, way| {
        let tables = Tables::new(&world, &before, candidates);
        solved(device, (&world, &Sim::new(&settings, world.capacities), 0, way), &tables, None).map(|(poses, _)| poses)
    };
    for way in WAYS {
        let (first, again, fewer) = (run(65, way)?, run(65, way)?, run(7, way)?);
        if first != again || !first.starts_with(&fewer) {
            return Err(format!("two runs differ: {way:?}").into());
        }
    }
    Ok(())
}

/// However few rounds its loops may take at a time, down to a single sweep.
fn goes_on_where_it_stopped(device: &Device) -> Result<(), Failed> {
    let settings = SimSettings { velocity_iterations: 3, ..Default::default() };
    for (world, steps) in [(world(), 0..STATES), (hard_heap(23).world(), 20..60)] {
        let before: Vec<State> =
            states_after(&world, &settings, 0.003, steps)?.into_iter().map(|[before, _]| before).collect();
        let tables = Tables::new(&world, &before, 65);
        let sim = Sim::new(&settings, world.capacities);
        for way in WAYS {
            let (whole, _) = solved(device, (&world, &sim, 0, way), &tables, None)?;
            for loops in [0, 3000, 20_000, 200_000] {
                let sim = Sim { loops, ..sim };
                let (poses, statuses) = solved(device, (&world, &sim, 0, way), &tables, None)?;
                let rounds = rounds(&sim, world.bodies.len() as u32);
                if rounds < 2 || poses != whole || statuses.iter().any(|status| *status != 0) {
                    return Err(format!("{way:?} with {loops} rounds of its loops").into());
                }
            }
        }
    }
    Ok(())
}

/// Run once too few, as with more patches than slots speak for.
fn tells_what_is_not_done(device: &Device) -> Result<(), Failed> {
    let (world, settings) = (world(), SimSettings::default());
    let before: Vec<State> = states(&world, &settings)?.into_iter().map(|[before, _]| before).collect();
    let tables = Tables::new(&world, &before, 7);
    let sim = Sim { loops: 0, ..Sim::new(&settings, world.capacities) };
    for way in WAYS {
        let all = |mut runs: usize| {
            let is_left = |_: &str| {
                let is_left = runs > 0;
                runs = runs.saturating_sub(1);
                is_left
            };
            solved_by(device, (&world, &sim, 0, way), &tables, None, is_left).map(|(_, statuses)| statuses)
        };
        let (done, once) = (all(usize::MAX)?, all(1)?);
        if done.iter().any(|status| *status != 0) || once.iter().any(|status| *status != Status::CONTACTS.0) {
            return Err(format!("{way:?}: a substep is done or not, and the status says otherwise").into());
        }
    }
    Ok(())
}

fn tells_what_is_not_finite(device: &Device) -> Result<(), Failed> {
    let (world, settings) = (world(), SimSettings::default());
    let before: Vec<State> = states(&world, &settings)?.into_iter().map(|[before, _]| before).collect();
    let mut tables = Tables::new(&world, &before, 7);
    // One that touches others, and what is alone in mid-air: where it is, how it moves, how it turns.
    let free = |candidate: usize| (candidate + 1) * world.bodies.len() - 1;
    tables.velocities[3 * world.bodies.len()].linear.x = f32::INFINITY;
    tables.poses[free(1)].translation.y = f32::INFINITY;
    tables.velocities[free(4)].linear.z = f32::INFINITY;
    tables.velocities[free(5)].angular.x = f32::INFINITY;
    let expected = [false, true, false, true, true, true, false].map(|bad| if bad { Status::NOT_FINITE.0 } else { 0 });
    for way in WAYS {
        let (_, statuses) = solved(device, (&world, &Sim::new(&settings, world.capacities), 0, way), &tables, None)?;
        if statuses != expected {
            return Err(format!("{way:?}: {statuses:?}").into());
        }
    }
    Ok(())
}
