//! Kernels `flags` and `stats`.

use super::Test;
use super::elites::energies;
use super::fixture::{Device, SIZES, Value};
use libtest_mimic::Failed;
use rest3d_gpu::cpu::elites::elites as ranked;
use rest3d_gpu::cpu::stats::{elite_mean, flags};
use rest3d_gpu::gpu::kernels::{FlagsBuffers, StatsBuffers};
use rest3d_gpu::gpu::{Batch, Flags, Stats};
use rest3d_gpu::world::{Energy, Status, Winner};

pub const TESTS: &[Test] = &[("stats::flags_is_its_twin", flags_is_its_twin), ("stats::is_its_twin", is_its_twin)];

/// Sums of up to 1234 numbers in the same order.
const TOLERANCE: f32 = 1e-6;

impl Value for Flags {
    fn distance(&self, other: &Self) -> f32 {
        if self == other { 0.0 } else { f32::NAN }
    }
    fn spoil(&mut self, _: f32) {
        self.counts[2] ^= 1;
    }
}

impl Value for Stats {
    fn distance(&self, other: &Self) -> f32 {
        self.best.distance(&other.best)
            + self.iteration_best.distance(&other.iteration_best)
            + self.elite_mean.distance(&other.elite_mean)
    }
    fn spoil(&mut self, by: f32) {
        self.elite_mean.spoil(by);
    }
}

fn batch(candidates: u32) -> Batch {
    Batch { candidates, bodies: 0, pairs: 0, dimensions: 0 }
}

fn flags_is_its_twin(device: &Device) -> Result<(), Failed> {
    for candidates in SIZES {
        let statuses: Vec<Status> = (0..candidates).map(|i| Status(i.wrapping_mul(0x9e37_79b9) >> 28)).collect();
        let sizes = device.input(&[batch(candidates)])?;
        let input = device.input(&statuses.iter().map(|status| status.0).collect::<Vec<_>>())?;
        let output = device.poisoned(1)?;
        let buffers = FlagsBuffers { batch: sizes.uniform(), statuses: input.read(), flags: output.write() };
        device.run(&buffers.step(&device.gpu, device.kernels()?, 1));
        device.expect(&candidates.to_string(), &output, &[Flags { counts: flags(&statuses) }], 0.0)?;
    }
    Ok(())
}

fn is_its_twin(device: &Device) -> Result<(), Failed> {
    let known = Winner { energy: Energy { total: -7.0, ..Winner::NONE.energy }, iteration: 1, candidate: 77 };
    for candidates in SIZES {
        for fail in [usize::MAX, 5, 1] {
            let energies = energies(candidates, fail);
            let mut order = vec![0; energies.len()];
            let usable = ranked(&energies, candidates.div_ceil(2) as usize, &mut order);
            // Of candidates alone, with the winner, none.
            let mut rows = order[..usable].to_vec();
            for (rows, winner) in [
                (rows.clone(), known),
                (
                    {
                        rows.push(candidates);
                        rows
                    },
                    known,
                ),
                (vec![], Winner::NONE),
            ] {
                let expected = Stats {
                    best: winner.energy,
                    iteration_best: energies[order[0] as usize].total,
                    elite_mean: elite_mean(&energies, &rows, &winner),
                };
                let sizes = device.input(&[batch(candidates)])?;
                let (energies, order) = (device.input(&energies)?, device.input(&order)?);
                let (elites, count) = (device.input(&rows)?, device.input(&[rows.len() as u32])?);
                let winner = device.input(&[winner])?;
                let output = device.poisoned(1)?;
                let buffers = StatsBuffers {
                    batch: sizes.uniform(),
                    energies: energies.read(),
                    order: order.read(),
                    elites: elites.read(),
                    count: count.read(),
                    winner: winner.read(),
                    stats: output.write(),
                };
                device.run(&buffers.step(&device.gpu, device.kernels()?, 1));
                device.expect(&format!("{candidates}, {} elites", rows.len()), &output, &[expected], TOLERANCE)?;
            }
        }
    }
    Ok(())
}
