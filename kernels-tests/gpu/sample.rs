//! Kernel `sample`.

use super::Test;
use super::fixture::{Device, SIZES, noise};
use libtest_mimic::Failed;
use rest3d_gpu::cpu::sample::sample_candidate;
use rest3d_gpu::gpu::kernels::SampleBuffers;
use rest3d_gpu::gpu::{Batch, Draw};
use rest3d_gpu::world::{CemSettings, Distribution, Stream};

pub const TESTS: &[Test] = &[
    ("sample::is_its_twin", is_its_twin),
    ("sample::fills_several_rows_of_workgroups", fills_several_rows_of_workgroups),
    ("sample::candidate_zero_may_be_the_mean", candidate_zero_may_be_the_mean),
    ("sample::a_candidate_does_not_depend_on_the_others", a_candidate_does_not_depend_on_the_others),
];

/// On cards, whose roots and quotients are off in the last bits. Normals reach 5.8.
const TOLERANCE: f32 = 4e-6;

const STREAM: Stream = Stream { seed: 0x0123_4567_89ab_cdef, stage: 5 };
const ITERATION: u32 = 11;

fn drawn(
    device: &Device,
    candidates: u32,
    units: u32,
    cem: &CemSettings,
    expected: &[f32],
) -> Result<Vec<f32>, Failed> {
    let dimensions = 6 * units;
    let batch = device.input(&[Batch { candidates, bodies: 0, pairs: 0, dimensions }])?;
    let draw = device.input(&[Draw::new(STREAM, ITERATION, cem)])?;
    let mean = device.input(&noise(1, dimensions as usize))?;
    let std = device.input(&deviations(dimensions as usize))?;
    let deltas = device.poisoned((candidates * dimensions) as usize)?;
    let buffers = SampleBuffers {
        batch: batch.uniform(),
        draw: draw.uniform(),
        mean: mean.read(),
        std: std.read(),
        deltas: deltas.write(),
    };
    device.run(&buffers.step(&device.gpu, device.kernels()?, candidates * dimensions.div_ceil(4)));
    if !expected.is_empty() {
        device.expect(&format!("{candidates} × {dimensions}"), &deltas, expected, device.rounding(TOLERANCE))?;
    }
    device.fetch(&deltas)
}

/// About [−1, 1].
fn deviations(dimensions: usize) -> Vec<f32> {
    noise(2, dimensions).iter().map(|x| 0.2 * x).collect()
}

fn twin(candidates: u32, units: u32, cem: &CemSettings) -> Vec<f32> {
    let dimensions = 6 * units as usize;
    let distribution = Distribution { mean: noise(1, dimensions), std: deviations(dimensions) };
    let mut rows = vec![0.0; candidates as usize * dimensions];
    for (candidate, row) in rows.chunks_exact_mut(dimensions).enumerate() {
        sample_candidate(cem, &distribution, (STREAM, ITERATION), candidate as u32, row);
    }
    rows
}

fn is_its_twin(device: &Device) -> Result<(), Failed> {
    for antithetic in [false, true] {
        let cem = CemSettings { antithetic, ..CemSettings::default() };
        for candidates in SIZES {
            for units in [1, 3] {
                drawn(device, candidates, units, &cem, &twin(candidates, units, &cem))?;
            }
        }
    }
    Ok(())
}

/// 65536 workgroups are one more than a row has on most adapters.
fn fills_several_rows_of_workgroups(device: &Device) -> Result<(), Failed> {
    let candidates = 65535 * 64 / 2 + 7;
    let cem = CemSettings::default();
    drawn(device, candidates, 1, &cem, &twin(candidates, 1, &cem)).map(drop)
}

fn candidate_zero_may_be_the_mean(device: &Device) -> Result<(), Failed> {
    for antithetic in [false, true] {
        let cem = CemSettings { sample_mean: true, antithetic, ..CemSettings::default() };
        let found = drawn(device, 7, 3, &cem, &twin(7, 3, &cem))?;
        if found[..18] != noise(1, 18) {
            return Err("not exactly the mean".into());
        }
    }
    Ok(())
}

fn a_candidate_does_not_depend_on_the_others(device: &Device) -> Result<(), Failed> {
    let cem = CemSettings::default();
    let [few, many] = [7, 65].map(|candidates| drawn(device, candidates, 3, &cem, &[]));
    if few? == many?[..7 * 18] { Ok(()) } else { Err("more candidates change the first ones".into()) }
}
