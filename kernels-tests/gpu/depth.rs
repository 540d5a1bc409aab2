//! Kernel `depth`.

use super::Test;
use super::crowd::crowd;
use super::fixture::{Device, SIZES, noise};
use glam::Vec3;
use libtest_mimic::Failed;
use rest3d_gpu::gpu::kernels::DepthBuffers;
use rest3d_gpu::gpu::{Batch, Separation, Sim};
use rest3d_gpu::world::SimSettings;

pub const TESTS: &[Test] = &[("depth::is_the_deepest_of_a_pair", is_the_deepest_of_a_pair)];

fn is_the_deepest_of_a_pair(device: &Device) -> Result<(), Failed> {
    const SLOTS: usize = 50;
    let world = crowd();
    let pairs = world.pairs.len();
    for candidates in SIZES {
        let n = candidates as usize;
        let sim = Sim { hull_pairs: SLOTS as u32, ..Sim::new(&SimSettings::default(), world.capacities) };
        let separations: Vec<Separation> = (noise(47, n * SLOTS).iter().enumerate())
            .map(|(i, &x)| Separation::new(Vec3::Y, x, i as u32 % 4))
            .collect();
        let counts = noise(48, n * pairs);
        let (mut starts, mut expected) = (Vec::new(), Vec::new());
        for (counts, found) in counts.chunks_exact(pairs).zip(separations.chunks_exact(SLOTS)) {
            let mut start = 0;
            for count in counts.iter().map(|x| (3.0 * x.abs()) as usize) {
                // Some candidates have more hull pairs than slots.
                let range = start.min(SLOTS)..(start + count).min(SLOTS);
                let near = found[range].iter().filter(|s| s.feature != 0);
                expected.push(near.map(|s| -s.distance).fold(0.0, f32::max));
                starts.push(start as u32);
                start += count;
            }
            starts.push(start as u32);
        }
        let batch = device.input(&[Batch::new(&world, candidates)])?;
        let sim = device.input(&[sim])?;
        let pair_starts = device.input(&starts)?;
        let separations = device.input(&separations)?;
        let depths = device.poisoned(expected.len())?;
        let buffers = DepthBuffers {
            batch: batch.uniform(),
            sim: sim.uniform(),
            pair_starts: pair_starts.read(),
            separations: separations.read(),
            depths: depths.write(),
        };
        device.run(&buffers.step(&device.gpu, device.kernels()?, expected.len() as u32));
        device.expect(&candidates.to_string(), &depths, &expected, 1e-7)?;
    }
    Ok(())
}
