//! Rollouts of a population and the times of its kernels: what `bench` and `report.json` tell.

use super::Test;
use super::fixture::{Device, boxes_world};
use libtest_mimic::Failed;
use rest3d_gpu::bench::starts;
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::gpu::Way;
use rest3d_gpu::world::{Backend, CemSettings, Flow, SearchSettings, SimSettings, Status, Stream};
use std::time::Instant;

pub const TESTS: &[Test] = &[
    ("times::rollouts_end_where_simulations_end_and_count_contacts", rollouts),
    ("times::kernels_fill_the_run", kernels_fill_the_run),
    ("times::a_search_tells_what_each_kernel_took", a_search),
];

/// Kernels of a first substep on this adapter, in order.
fn substep(device: &Device) -> Vec<&'static str> {
    let waves = Way::best(&device.gpu) == Way::Waves;
    SUBSTEP.into_iter().filter(|name| waves || *name != "solve_waves").collect()
}

const SUBSTEP: [&str; 21] = [
    "boxes",
    "pair_counts",
    "pair_starts",
    "hull_pairs",
    "axis_remembered",
    "axis_faces",
    "axis_edges",
    "aligned_faces",
    "clip_faces",
    "single_points",
    "passing",
    "ground",
    "merge",
    "contact_starts",
    "emit",
    "solve_bodies",
    "solve_load",
    "first_loads",
    "solve_waves",
    "solve",
    "integrate",
];

fn rollouts(device: &Device) -> Result<(), Failed> {
    let world = boxes_world();
    let backend = device.backend()?;
    let settings = SimSettings { steps: 30, ..Default::default() };
    let starts = starts(&world, 67, 3);
    let mut settled = Vec::new();
    let statuses = backend.simulate(&world, &settings, &starts, &mut |_, poses, _| {
        settled = poses.to_vec();
        Flow::Continue
    })?;
    let found = backend.rollouts(&world, &settings, &starts)?;
    if found.settled != settled || found.statuses != statuses {
        return Err("rollouts end elsewhere".into());
    }
    let expected = CpuBackend.rollouts(&world, &settings, &starts)?;
    let contacts = [&found, &expected].map(|rollouts| rollouts.contacts_per_substep.unwrap_or(0.0));
    if (contacts[0] / contacts[1] - 1.0).abs() > 0.02 || contacts[1] < 4.0 {
        return Err(format!("contacts: {contacts:?}").into());
    }
    // Too little room changes nothing but the time.
    let mut cramped = world.clone();
    (cramped.capacities.hull_pairs, cramped.capacities.contacts) = (2, 8);
    if backend.rollouts(&cramped, &settings, &starts)? == found { Ok(()) } else { Err("room changes results".into()) }
}

/// Other work may disturb a measurement, not three in a row.
fn kernels_fill_the_run(device: &Device) -> Result<(), Failed> {
    fill_the_run(device).or_else(|_| fill_the_run(device)).or_else(|_| fill_the_run(device))
}

fn fill_the_run(device: &Device) -> Result<(), Failed> {
    let world = boxes_world();
    let backend = device.backend()?;
    let settings = SimSettings::default();
    let starts = starts(&world, 512, 3);
    backend.rollouts(&world, &settings, &starts)?;
    let clock = Instant::now();
    backend.rollouts(&world, &settings, &starts)?;
    let wall = 1e3 * clock.elapsed().as_secs_f64();
    let times = backend.kernel_times(&world, &settings, &starts)?;
    if !device.gpu.has_times() {
        return if times.is_empty() { Ok(()) } else { Err("times without timestamps".into()) };
    }
    let names: Vec<&str> = times.iter().map(|time| time.name.as_str()).collect();
    let sum: f64 = times.iter().map(|time| time.milliseconds).sum();
    eprintln!("kernels: {sum:.0} of {wall:.0} ms");
    // The clock is read while other work may run beside it: between half and twice the wall time.
    if names != substep(device)
        || times.iter().any(|time| time.milliseconds <= 0.0)
        || !(0.5..2.0).contains(&(sum / wall))
    {
        return Err(format!("{sum} of {wall} ms, {times:?}").into());
    }
    Ok(())
}

fn a_search(device: &Device) -> Result<(), Failed> {
    let world = boxes_world();
    // So many substeps that not all can be timed.
    let simulation = SimSettings { steps: 130, ..Default::default() };
    let cem = CemSettings { candidates: 9, ..Default::default() };
    let settings = SearchSettings { simulation, cem, ..Default::default() };
    let mut search = device.backend()?.search(&world, &settings, Stream { seed: 1, stage: 0 })?;
    if !device.gpu.has_times() {
        search.iterate()?;
        return if search.kernel_times().is_empty() { Ok(()) } else { Err("times without timestamps".into()) };
    }
    let mut last = 0.0;
    for iteration in 0..2 {
        let clock = Instant::now();
        let stats = search.iterate()?;
        let wall = 1e3 * clock.elapsed().as_secs_f64();
        let times = search.kernel_times();
        let sum: f64 = times.iter().map(|time| time.milliseconds).sum();
        let mut known = substep(device)
            .into_iter()
            .chain(["sample", "place", "depth", "flags", "energy", "elites", "best", "stats"]);
        let named = known.all(|name| times.iter().any(|time| time.name == name && time.milliseconds > 0.0));
        // So few candidates keep the device waiting, and the first iteration compiles the kernels.
        let share = (sum - last) / wall;
        if !named || !(0.05..2.0).contains(&share) || stats.flagged != [0; Status::FAULTS.len()] {
            return Err(format!("iteration {iteration}: {share} of {wall} ms, {times:?}").into());
        }
        last = sum;
    }
    Ok(())
}
