//! Whole simulations and searches on the device against the CPU's.

use super::Test;
use super::fixture::{Device, boxes_world, compare};
use libtest_mimic::Failed;
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::gpu::{AdapterChoice, GpuBackend};
use rest3d_gpu::world::{Backend, CemSettings, Flow, Pose, SearchSettings, SimSettings, Status, Stream, World};

pub const TESTS: &[Test] = &[
    ("simulation::follows_the_cpu", follows_the_cpu),
    ("simulation::grows_when_there_is_too_little_room", grows_when_there_is_too_little_room),
    ("simulation::searches_as_the_cpu_does", searches_as_the_cpu_does),
    ("simulation::narrows_down_as_the_cpu_does", narrows_down_as_the_cpu_does),
];

/// m: sixty steps of a stack at rest.
const TOLERANCE: f32 = 1e-4;

fn open(device: &Device) -> Result<GpuBackend, Failed> {
    Ok(GpuBackend::open(&AdapterChoice::Index(device.gpu.report().index))?)
}

fn poses(backend: &dyn Backend, world: &World, starts: &[Pose]) -> Result<(Vec<Vec<Pose>>, Vec<Status>), Failed> {
    let mut steps = Vec::new();
    let statuses = backend.simulate(world, &SimSettings::default(), starts, &mut |_, poses, _| {
        steps.push(poses.to_vec());
        Flow::Continue
    })?;
    Ok((steps, statuses))
}

fn follows_the_cpu(device: &Device) -> Result<(), Failed> {
    let world = boxes_world();
    let starts = world.start.repeat(9);
    let (found, statuses) = poses(&open(device)?, &world, &starts)?;
    let (expected, _) = poses(&CpuBackend, &world, &starts)?;
    for (step, (found, expected)) in found.iter().zip(&expected).enumerate() {
        compare(found, expected, TOLERANCE).map_err(|error| format!("step {step}: {error}"))?;
    }
    if found.len() != expected.len() || statuses.iter().any(|status| *status != Status::default()) {
        return Err(format!("{} steps, {statuses:?}", found.len()).into());
    }
    Ok(())
}

fn grows_when_there_is_too_little_room(device: &Device) -> Result<(), Failed> {
    let mut world = boxes_world();
    let roomy = poses(&open(device)?, &world, &world.start)?;
    (world.capacities.hull_pairs, world.capacities.contacts) = (1, 2);
    let cramped = poses(&open(device)?, &world, &world.start)?;
    if roomy == cramped { Ok(()) } else { Err(format!("{:?}", cramped.1).into()) }
}

fn searches_as_the_cpu_does(device: &Device) -> Result<(), Failed> {
    let world = boxes_world();
    let cem = CemSettings { candidates: 65, translation_std: [0.01; 3], rotation_std: [0.02; 3], ..Default::default() };
    let settings = SearchSettings { cem, ..Default::default() };
    let stream = Stream { seed: 5, stage: 0 };
    let (gpu, cpu) = (open(device)?, CpuBackend);
    let mut search = gpu.search(&world, &settings, stream)?;
    let mut twin = cpu.search(&world, &settings, stream)?;
    let (found, expected) = (search.iterate()?, twin.iterate()?);
    compare(&search.placed(64)?, &twin.placed(64)?, 1e-5)?;
    // Who wins is a matter of rounding where contacts decide; what winning costs is not.
    if found.flagged != expected.flagged || (found.best.total / expected.best.total - 1.0).abs() > 0.05 {
        return Err(format!("{found:?} instead of {expected:?}").into());
    }
    let best = search.best()?.ok_or("no winner")?;
    if best.energy != found.best {
        return Err(format!("{best:?}").into());
    }
    compare(&search.placed(best.candidate)?, &best.placed, 0.0)?;
    Ok(())
}

fn narrows_down_as_the_cpu_does(device: &Device) -> Result<(), Failed> {
    let world = boxes_world();
    let cem = CemSettings {
        candidates: 17,
        draws: 5,
        short_steps: 16,
        finalists: 0.3,
        elite_fraction: 0.2,
        translation_std: [0.01; 3],
        rotation_std: [0.02; 3],
        ..Default::default()
    };
    let settings = SearchSettings { cem, ..Default::default() };
    let (gpu, stream) = (open(device)?, Stream { seed: 5, stage: 0 });
    let (mut search, mut twin) =
        (gpu.search(&world, &settings, stream)?, CpuBackend.search(&world, &settings, stream)?);
    for iteration in 0..2 {
        twin.set_distribution(&search.distribution());
        let (stats, expected) = (search.iterate()?, twin.iterate()?);
        let (found, expected_energies) = (search.energies()?, twin.energies()?);
        let finalists = found.iter().filter(|energy| energy.total.is_finite()).count();
        if found.len() != 85 || finalists != 6 || stats.flagged != expected.flagged {
            return Err(format!("{iteration}: {} candidates, {finalists} of them to the end", found.len()).into());
        }
        // Where rounding is the same, so are all energies, and of those that were passed over what was known of them.
        if device.rounding(1.0) == 0.0 {
            compare(&found, &expected_energies, 0.0).map_err(|error| format!("{iteration}: {error}"))?;
        }
        let best = search.best()?.ok_or("no winner")?;
        if best.iteration == iteration {
            compare(&[found[best.candidate as usize]], &[best.energy], 0.0)?;
            compare(&search.placed(best.candidate)?, &best.placed, 0.0)?;
        }
    }
    Ok(())
}
