//! Kernel `elites`.

use super::Test;
use super::fixture::{Device, SIZES, noise};
use libtest_mimic::Failed;
use rest3d_gpu::cpu::elites::elites;
use rest3d_gpu::gpu::kernels::ElitesBuffers;
use rest3d_gpu::gpu::{Batch, Update};
use rest3d_gpu::world::{Energy, Winner};

pub const TESTS: &[Test] =
    &[("elites::is_its_twin", is_its_twin), ("elites::ranks_the_largest_population", ranks_the_largest_population)];

/// Energies of all signs with ties, and one of `fail` that failed.
pub fn energies(candidates: u32, fail: usize) -> Vec<Energy> {
    let total = |(i, x): (usize, f32)| if i % fail == fail - 1 { f32::INFINITY } else { (4.0 * x).round() / 4.0 };
    let totals = noise(12, candidates as usize).into_iter().enumerate().map(total);
    totals.map(|total| Energy { total, ..Winner::NONE.energy }).collect()
}

fn ranked(device: &Device, candidates: u32, fail: usize) -> Result<(), Failed> {
    let energies = energies(candidates, fail);
    let wanted = candidates.div_ceil(3);
    let mut expected = vec![0; energies.len()];
    let expected_usable = elites(&energies, wanted as usize, &mut expected) as u32;

    let batch = device.input(&[Batch { candidates, bodies: 0, pairs: 0, dimensions: 0 }])?;
    let update = device.input(&[Update { wanted, epsilon: 0.0 }])?;
    let energies = device.input(&energies)?;
    let keys = device.poisoned((candidates as usize).next_power_of_two())?;
    let order = device.poisoned(candidates as usize)?;
    let usable = device.poisoned(1)?;
    let buffers = ElitesBuffers {
        batch: batch.uniform(),
        update: update.uniform(),
        energies: energies.read(),
        keys: keys.write(),
        order: order.write(),
        usable: usable.write(),
    };
    device.run(&buffers.step(&device.gpu, device.kernels()?, 1));
    device.expect(&format!("order of {candidates}"), &order, &expected, 0.0)?;
    device.expect(&format!("usable of {candidates}"), &usable, &[expected_usable], 0.0)
}

fn is_its_twin(device: &Device) -> Result<(), Failed> {
    for candidates in SIZES {
        // None failed, some, and all.
        for fail in [usize::MAX, 5, 1] {
            ranked(device, candidates, fail)?;
        }
    }
    Ok(())
}

fn ranks_the_largest_population(device: &Device) -> Result<(), Failed> {
    ranked(device, 16384, 9)
}
