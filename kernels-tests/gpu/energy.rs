//! Kernel `energy`.

use super::Test;
use super::fixture::{Device, SIZES, noise, noisy_poses, world};
use glam::Vec3;
use libtest_mimic::Failed;
use rest3d_gpu::cpu::energy::{Trial, energy};
use rest3d_gpu::gpu::kernels::EnergyBuffers;
use rest3d_gpu::gpu::{Batch, Weights};
use rest3d_gpu::world::{EnergyWeights, PenetrationMode, Pose, Status, Velocity, constants::TOUCHING_DEPTH};

pub const TESTS: &[Test] = &[("energy::is_its_twin", is_its_twin)];

/// Relative, on cards.
const TOLERANCE: f32 = 4e-6;

fn is_its_twin(device: &Device) -> Result<(), Failed> {
    let world = world();
    let (bodies, pairs) = (world.bodies.len(), world.pairs.len());
    for candidates in SIZES {
        let n = candidates as usize;
        let placed = noisy_poses(6, n * bodies);
        let settled = noisy_poses(7, n * bodies);
        let speeds = noise(8, 3 * n * bodies);
        let snapshot: Vec<Velocity> =
            speeds.chunks_exact(3).map(|v| Velocity::new(Vec3::from_slice(v), Vec3::ONE)).collect();
        let depths = |seed| -> Vec<f32> { noise(seed, n * pairs).iter().map(|x| 2.0 * TOUCHING_DEPTH * x).collect() };
        let (depths_placed, depths_settled) = (depths(9), depths(10));
        let statuses: Vec<u32> = (0..candidates).map(|i| if i % 3 == 1 { i / 3 % 16 } else { 0 }).collect();
        for mode in [PenetrationMode::Count, PenetrationMode::Depth] {
            let weights = EnergyWeights { penetration_mode: mode, velocity: 0.75, layout: 0.25, ..Default::default() };
            let expected: Vec<_> = (0..n)
                .map(|i| {
                    let rows = i * bodies..(i + 1) * bodies;
                    let trial = Trial {
                        placed: &placed[rows.clone()],
                        settled: &settled[rows.clone()],
                        snapshot: &snapshot[rows],
                        depths_placed: &depths_placed[i * pairs..(i + 1) * pairs],
                        depths_settled: &depths_settled[i * pairs..(i + 1) * pairs],
                        status: Status(statuses[i]),
                    };
                    energy(&world, &weights, &trial)
                })
                .collect();
            let batch = device.input(&[Batch::new(&world, candidates)])?;
            let weights = device.input(&[Weights::from(&weights)])?;
            let bodies = device.input(&world.bodies)?;
            let [reference, placed, settled] =
                [&world.reference, &placed, &settled].map(|poses| device.input::<Pose>(poses));
            let (reference, placed, settled) = (reference?, placed?, settled?);
            let snapshot = device.input(&snapshot)?;
            let depths_placed = device.input(&depths_placed)?;
            let depths_settled = device.input(&depths_settled)?;
            let statuses = device.input(&statuses)?;
            let energies = device.poisoned(n)?;
            let buffers = EnergyBuffers {
                batch: batch.uniform(),
                weights: weights.uniform(),
                bodies: bodies.read(),
                reference: reference.read(),
                placed: placed.read(),
                settled: settled.read(),
                snapshot: snapshot.read(),
                depths_placed: depths_placed.read(),
                depths_settled: depths_settled.read(),
                statuses: statuses.read(),
                energies: energies.write(),
            };
            device.run(&buffers.step(&device.gpu, device.kernels()?, candidates));
            device.expect(&format!("{candidates} {mode:?}"), &energies, &expected, device.rounding(TOLERANCE))?;
        }
    }
    Ok(())
}
