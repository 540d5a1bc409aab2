//! Kernel `moments`.

use super::Test;
use super::fixture::{Device, SIZES, noise};
use libtest_mimic::Failed;
use rest3d_gpu::cpu::moments::moments;
use rest3d_gpu::gpu::kernels::MomentsBuffers;
use rest3d_gpu::gpu::{Batch, Update};

pub const TESTS: &[Test] =
    &[("moments::is_its_twin", is_its_twin), ("moments::no_elites_change_nothing", no_elites_change_nothing)];

/// Sums of up to 1234 numbers in the same order.
const TOLERANCE: f32 = 1e-6;

fn updated(device: &Device, candidates: u32, count: u32, dimensions: u32) -> Result<(), Failed> {
    const EPSILON: f32 = 1e-3;
    let width = dimensions as usize;
    let rows = noise(14, (candidates + 1) as usize * width);
    // The winner's row first, then every other one.
    let elites: Vec<u32> = (0..count).map(|i| if i == 0 { candidates } else { (2 * i) % candidates }).collect();
    let floors: Vec<f32> = (0..dimensions).map(|d| (d % 3) as f32).collect();
    let (mut mean, mut std) = (noise(15, width), noise(16, width));
    let (means, stds) = match count {
        0 => (device.input(&mean)?, device.input(&std)?),
        _ => (device.poisoned(width)?, device.poisoned(width)?),
    };
    moments(&rows, &elites, EPSILON, &floors, &mut mean, &mut std);

    let batch = device.input(&[Batch { candidates, bodies: 0, pairs: 0, dimensions }])?;
    let update = device.input(&[Update { wanted: count.max(1), epsilon: EPSILON }])?;
    let deltas = device.input(&rows)?;
    let elites = device.input(&elites)?;
    let counts = device.input(&[count])?;
    let floors = device.input(&floors)?;
    let buffers = MomentsBuffers {
        batch: batch.uniform(),
        update: update.uniform(),
        deltas: deltas.read(),
        elites: elites.read(),
        count: counts.read(),
        floors: floors.read(),
        mean: means.write(),
        std: stds.write(),
    };
    device.run(&buffers.step(&device.gpu, device.kernels()?, dimensions));
    let what = format!("{count} of {candidates} × {dimensions}");
    device.expect(&format!("mean of {what}"), &means, &mean, TOLERANCE)?;
    device.expect(&format!("deviation of {what}"), &stds, &std, TOLERANCE)
}

fn is_its_twin(device: &Device) -> Result<(), Failed> {
    for candidates in SIZES {
        for dimensions in [6, 78] {
            updated(device, candidates, candidates.div_ceil(2), dimensions)?;
        }
    }
    Ok(())
}

fn no_elites_change_nothing(device: &Device) -> Result<(), Failed> {
    updated(device, 7, 0, 18)
}
