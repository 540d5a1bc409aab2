//! Kernel `place`.

use super::Test;
use super::fixture::{Device, SIZES, noise, world};
use libtest_mimic::Failed;
use rest3d_gpu::cpu::place::place;
use rest3d_gpu::gpu::Batch;
use rest3d_gpu::gpu::kernels::PlaceBuffers;

pub const TESTS: &[Test] = &[("place::is_its_twin", is_its_twin)];

/// m and rad, on cards: turns of up to π through arcs of metres.
const TOLERANCE: f32 = 2e-6;

fn is_its_twin(device: &Device) -> Result<(), Failed> {
    let world = world();
    let width = world.dimensions();
    let bodies = device.input(&world.bodies)?;
    let units = device.input(&world.units)?;
    let start = device.input(&world.start)?;
    for candidates in SIZES {
        let mut rows: Vec<f32> = noise(5, candidates as usize * width).iter().map(|x| 0.4 * x).collect();
        // No turn at all has no axis.
        rows[3..6].fill(0.0);
        let mut expected = world.start.repeat(candidates as usize);
        for (row, poses) in rows.chunks_exact(width).zip(expected.chunks_exact_mut(world.bodies.len())) {
            place(&world, row, poses);
        }
        let batch = device.input(&[Batch::new(&world, candidates)])?;
        let deltas = device.input(&rows)?;
        let placed = device.poisoned(expected.len())?;
        let buffers = PlaceBuffers {
            batch: batch.uniform(),
            bodies: bodies.read(),
            units: units.read(),
            start: start.read(),
            deltas: deltas.read(),
            placed: placed.write(),
        };
        device.run(&buffers.step(&device.gpu, device.kernels()?, expected.len() as u32));
        device.expect(&candidates.to_string(), &placed, &expected, device.rounding(TOLERANCE))?;
    }
    Ok(())
}
