//! Kernels `pair_counts`, `pair_starts` and `hull_pairs`.

use super::Test;
use super::boxes::boxes;
use super::crowd::{crowd, scattered, speeds};
use super::fixture::{Device, SIZES, Value, compare, noise};
use libtest_mimic::Failed;
use rest3d_gpu::cpu::broad_phase::BroadPhase;
use rest3d_gpu::gpu::kernels::{HullPairsBuffers, PairCountsBuffers, PairStartsBuffers};
use rest3d_gpu::gpu::{Batch, HullPair, Sim};
use rest3d_gpu::world::{SimSettings, Status};

pub const TESTS: &[Test] = &[
    ("pair_counts::and_hull_pairs_are_their_twin", lists_hull_pairs),
    ("pair_starts::sums_and_flags", sums_and_flags),
];

impl Value for HullPair {
    fn distance(&self, other: &Self) -> f32 {
        if self == other { 0.0 } else { f32::NAN }
    }
    fn spoil(&mut self, _: f32) {
        self.cache ^= 1;
    }
}

/// Whether a body keeps its contacts with others that do, body after body and again from the first.
const STILL: [bool; 5] = [true, false, false, true, false];

/// Starts of each candidate's pairs and, last, its total.
fn summed(counts: &[u32], pairs: usize) -> Vec<u32> {
    let row = |row: &[u32]| -> Vec<u32> { (0..=pairs).map(|i| row[..i].iter().sum()).collect() };
    counts.chunks_exact(pairs).flat_map(row).collect()
}

fn lists_hull_pairs(device: &Device) -> Result<(), Failed> {
    let world = crowd();
    let (settings, pairs) = (SimSettings::default(), world.pairs.len());
    let sim = Sim::new(&settings, world.capacities);
    let slots = sim.hull_pairs as usize;
    for candidates in SIZES {
        let velocities = speeds(&world, candidates);
        // Two lists: the second is the last substep's, with a number for each axis.
        let lists = [0, 30].map(|step| {
            let poses = scattered(&world, candidates, step);
            let (mut counts, mut rows) = (Vec::new(), Vec::new());
            let mut broad = BroadPhase::default();
            let n = world.bodies.len();
            for (poses, velocities) in poses.chunks_exact(n).zip(velocities.chunks_exact(n)) {
                broad.forget();
                broad.update(&world, poses, velocities, sim.contact_offset, sim.substep);
                // Some keep the contacts between them.
                broad.still.iter_mut().zip(STILL.iter().cycle()).for_each(|(to, from)| *to = *from);
                let mut list = Vec::new();
                broad.pairs(&world, |pair| broad.margin(pair), sim.hull_pairs, &mut list);
                counts.extend((0..pairs as u32).map(|i| list.iter().filter(|p| p.pair == i).count() as u32));
                rows.push(list);
            }
            (poses, counts, rows)
        });
        let [(poses, counts, new), (_, old_counts, old)] = lists;
        let key = |candidate: usize, i: usize| (candidate * 1000 + i + 1) as u32;
        let mut old_pairs = vec![HullPair::default(); candidates as usize * slots];
        let mut expected = vec![HullPair { pair: 7, a: 7, b: 7, cache: 7 }; candidates as usize * slots];
        let mut known = 0;
        for (candidate, (new, old)) in new.iter().zip(&old).enumerate() {
            for (i, p) in old.iter().enumerate() {
                let cache = key(candidate, i);
                old_pairs[candidate * slots + i] = HullPair { pair: p.pair, a: p.a, b: p.b, cache };
            }
            for (i, p) in new.iter().enumerate() {
                let cache = old.iter().position(|o| o == p).map_or(0, |at| key(candidate, at));
                known += u32::from(cache > 0);
                expected[candidate * slots + i] = HullPair { pair: p.pair, a: p.a, b: p.b, cache };
            }
        }
        if candidates > 1 && known == 0 {
            return Err("no hull pair was known before".into());
        }

        let (hulls, mut bodies) = boxes(&world, &poses, &velocities, sim.contact_offset, sim.substep);
        for row in bodies.chunks_exact_mut(world.bodies.len()) {
            row.iter_mut().zip(STILL.iter().cycle()).for_each(|(to, from)| to.is_still = u32::from(*from));
        }
        let batch = device.input(&[Batch::new(&world, candidates)])?;
        let sim = device.input(&[sim])?;
        let table = device.input(&world.bodies)?;
        let pair_table = device.input(&world.pairs)?;
        let hull_boxes = device.input(&hulls)?;
        let body_boxes = device.input(&bodies)?;
        let pair_counts = device.poisoned(counts.len())?;
        let counting = PairCountsBuffers {
            batch: batch.uniform(),
            bodies: table.read(),
            pairs: pair_table.read(),
            hull_boxes: hull_boxes.read(),
            body_boxes: body_boxes.read(),
            pair_counts: pair_counts.write(),
        };
        device.run(&counting.step(&device.gpu, device.kernels()?, counts.len() as u32));
        device.expect(&format!("{candidates}, counts"), &pair_counts, &counts, 0.0)?;

        let pair_starts = device.input(&summed(&counts, pairs))?;
        let old_starts = device.input(&summed(&old_counts, pairs))?;
        let old_pairs = device.input(&old_pairs)?;
        // What is not written keeps its poison.
        let hull_pairs = device.input(&vec![HullPair { pair: 7, a: 7, b: 7, cache: 7 }; expected.len()])?;
        let listing = HullPairsBuffers {
            batch: batch.uniform(),
            sim: sim.uniform(),
            bodies: table.read(),
            pairs: pair_table.read(),
            hull_boxes: hull_boxes.read(),
            body_boxes: body_boxes.read(),
            pair_starts: pair_starts.read(),
            old_starts: old_starts.read(),
            old_pairs: old_pairs.read(),
            hull_pairs: hull_pairs.write(),
        };
        device.run(&listing.step(&device.gpu, device.kernels()?, counts.len() as u32));
        device.expect(&format!("{candidates}, list"), &hull_pairs, &expected, 0.0)?;
    }
    Ok(())
}

fn sums_and_flags(device: &Device) -> Result<(), Failed> {
    let world = crowd();
    for candidates in SIZES {
        // Fewer pairs than a workgroup has lanes, as many, and more.
        for pairs in [1_usize, 64, 435] {
            let n = candidates as usize;
            let counts: Vec<u32> = noise(46, n * pairs).iter().map(|x| (2.0 * x.abs()) as u32).collect();
            let starts = summed(&counts, pairs);
            let totals: Vec<u32> = starts.chunks_exact(pairs + 1).map(|row| row[pairs]).collect();
            let limit = totals[0];
            let sim = Sim { hull_pairs: limit, ..Sim::new(&SimSettings::default(), world.capacities) };
            let before: Vec<u32> = (0..candidates).map(|i| (i % 2) * Status::NOT_FINITE.0).collect();
            let flag = |&total: &u32| if total > limit { Status::HULL_PAIRS.0 } else { 0 };
            let expected: Vec<u32> = before.iter().zip(totals.iter().map(flag)).map(|(a, b)| a | b).collect();
            let batch = device.input(&[Batch { pairs: pairs as u32, ..Batch::new(&world, candidates) }])?;
            let sim = device.input(&[sim])?;
            let pair_counts = device.input(&counts)?;
            let pair_starts = device.poisoned(starts.len())?;
            let statuses = device.input(&before)?;
            let most_hull_pairs = device.input(&vec![limit; n])?;
            let buffers = PairStartsBuffers {
                batch: batch.uniform(),
                sim: sim.uniform(),
                pair_counts: pair_counts.read(),
                pair_starts: pair_starts.write(),
                most_hull_pairs: most_hull_pairs.write(),
                statuses: statuses.write(),
            };
            device.run(&buffers.step(&device.gpu, device.kernels()?, 64 * candidates));
            device.expect(&format!("{candidates} × {pairs}, starts"), &pair_starts, &starts, 0.0)?;
            let most: Vec<u32> = totals.iter().map(|&total| total.max(limit)).collect();
            compare(&device.fetch(&most_hull_pairs)?, &most, 0.0)?;
            device.expect(&format!("{candidates} × {pairs}, statuses"), &statuses, &expected, 0.0)?;
        }
    }
    Ok(())
}
