//! Kernel `best`.

use super::Test;
use super::elites::energies;
use super::fixture::{Device, SIZES, noise};
use libtest_mimic::Failed;
use rest3d_gpu::cpu::{best::best, elites::elites};
use rest3d_gpu::gpu::kernels::BestBuffers;
use rest3d_gpu::gpu::{Batch, Draw, Update};
use rest3d_gpu::world::{CemSettings, Energy, Stream, Winner};

pub const TESTS: &[Test] = &[("best::is_its_twin", is_its_twin)];

const DIMENSIONS: u32 = 78;
const ITERATION: u32 = 3;

fn updated(device: &Device, candidates: u32, fail: usize, wanted: u32, before: Winner) -> Result<(), Failed> {
    let energies = energies(candidates, fail);
    let rows = noise(13, ((candidates + 1) * DIMENSIONS) as usize);
    let mut order = vec![0; energies.len()];
    let usable = elites(&energies, wanted as usize, &mut order);
    let (mut moved, mut winner, mut expected) = (rows.clone(), before, Vec::new());
    best(&energies, (&order, usable), wanted as usize, ITERATION, &mut moved, &mut winner, &mut expected);
    let count = expected.len() as u32;

    let batch = device.input(&[Batch { candidates, bodies: 0, pairs: 0, dimensions: DIMENSIONS }])?;
    let update = device.input(&[Update { wanted, epsilon: 0.0 }])?;
    let draw = device.input(&[Draw::new(Stream { seed: 0, stage: 0 }, ITERATION, &CemSettings::default())])?;
    let energies = device.input(&energies)?;
    let order = device.input(&order)?;
    let usable = device.input(&[usable as u32])?;
    let deltas = device.input(&rows)?;
    let winners = device.input(&[before])?;
    // What lies behind the elites stays poisoned.
    let elites = device.poisoned::<u32>(wanted as usize)?;
    expected.extend_from_slice(&device.fetch(&elites)?[expected.len()..]);
    let counted = device.poisoned(1)?;
    let buffers = BestBuffers {
        batch: batch.uniform(),
        update: update.uniform(),
        draw: draw.uniform(),
        energies: energies.read(),
        order: order.read(),
        usable: usable.read(),
        deltas: deltas.write(),
        winner: winners.write(),
        elites: elites.write(),
        count: counted.write(),
    };
    device.run(&buffers.step(&device.gpu, device.kernels()?, 1));
    let what = format!("{wanted} of {candidates}, winner {}", before.energy.total);
    device.expect(&what, &winners, &[winner], 0.0)?;
    device.expect(&what, &counted, &[count], 0.0)?;
    device.expect(&what, &elites, &expected, 0.0)?;
    // The canary of the rows needs a step that f32 can make.
    device.expect(&what, &deltas, &moved, f32::EPSILON)
}

fn is_its_twin(device: &Device) -> Result<(), Failed> {
    let known = |total| Winner { energy: Energy { total, ..Winner::NONE.energy }, iteration: 1, candidate: 77 };
    for candidates in SIZES {
        for wanted in [1, candidates.div_ceil(2), candidates] {
            for fail in [usize::MAX, 5, 1] {
                for before in [Winner::NONE, known(-1e3), known(1e3)] {
                    updated(device, candidates, fail, wanted, before)?;
                }
            }
        }
    }
    Ok(())
}
