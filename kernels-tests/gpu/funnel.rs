//! Kernels `gather`, `scatter` and `pass_over`.

use super::Test;
use super::fixture::{Device, noise, noisy_poses};
use bytemuck::Pod;
use libtest_mimic::Failed;
use rest3d_gpu::gpu::kernels::{GatherBuffers, PassOverBuffers, ScatterBuffers};
use rest3d_gpu::gpu::{Batch, Portion};
use rest3d_gpu::world::{Pose, Status, Velocity};

pub const TESTS: &[Test] = &[
    ("funnel::gathers_by_rank", gathers_by_rank),
    ("funnel::scatters_to_where_it_came_from", scatters_to_where_it_came_from),
    ("funnel::passes_all_over", passes_all_over),
];

const BODIES: usize = 5;
const PAIRS: usize = 3;

/// Candidates, slots of the simulation, and the ranks that it takes.
const CASES: [(u32, u32, Portion); 4] = [
    (1, 1, Portion { first: 0, count: 1 }),
    (7, 4, Portion { first: 3, count: 2 }),
    (65, 65, Portion { first: 0, count: 65 }),
    (1234, 100, Portion { first: 1200, count: 34 }),
];

fn batch(candidates: u32) -> Batch {
    Batch { candidates, bodies: BODIES as u32, pairs: PAIRS as u32, dimensions: 6 }
}

/// Candidates by rank: all of them, in no order.
fn order(candidates: u32) -> Vec<u32> {
    let keys = noise(9, candidates as usize);
    let mut order: Vec<u32> = (0..candidates).collect();
    order.sort_by(|&a, &b| keys[a as usize].total_cmp(&keys[b as usize]));
    order
}

/// `to` with rows of `from`: each pair names a row of `from` and one of `to`.
fn with_rows<T: Copy>(to: &[T], from: &[T], width: usize, rows: impl Iterator<Item = [usize; 2]>) -> Vec<T> {
    let mut expected = to.to_vec();
    for [source, target] in rows {
        expected[target * width..][..width].copy_from_slice(&from[source * width..][..width]);
    }
    expected
}

/// Each slot of a portion, and the candidate that it holds.
fn slots(order: &[u32], portion: Portion) -> impl Iterator<Item = [usize; 2]> + Clone {
    (0..portion.count as usize).map(move |slot| [slot, order[portion.first as usize + slot] as usize])
}

fn velocities(seed: u32, len: usize) -> Vec<Velocity> {
    noisy_poses(seed, len).iter().map(|pose| Velocity::new(pose.translation, 2.0 * pose.translation)).collect()
}

/// The words of a table, to compare bit by bit.
fn words<T: Pod>(table: &[T]) -> Vec<u32> {
    bytemuck::cast_slice(table).to_vec()
}

fn gathers_by_rank(device: &Device) -> Result<(), Failed> {
    for (candidates, slots_at_once, portion) in CASES {
        let (order, placed) = (order(candidates), noisy_poses(3, candidates as usize * BODIES));
        let before: Vec<Pose> = noisy_poses(4, slots_at_once as usize * BODIES);
        let rows = slots(&order, portion).map(|[slot, candidate]| [candidate, slot]);
        let expected = with_rows(&before, &placed, BODIES, rows);
        let (batch, portion) = (device.input(&[batch(candidates)])?, device.input(&[portion])?);
        let (order, placed, poses) = (device.input(&order)?, device.input(&placed)?, device.input(&before)?);
        let buffers = GatherBuffers {
            batch: batch.uniform(),
            portion: portion.uniform(),
            order: order.read(),
            placed: placed.read(),
            poses: poses.write(),
        };
        device.run(&buffers.step(&device.gpu, device.kernels()?, slots_at_once * BODIES as u32));
        device.expect(&candidates.to_string(), &poses, &expected, 0.0)?;
    }
    Ok(())
}

fn scatters_to_where_it_came_from(device: &Device) -> Result<(), Failed> {
    for (candidates, slots_at_once, portion) in CASES {
        let [all, some] = [candidates, slots_at_once].map(|n| n as usize);
        let order = order(candidates);
        let rows = slots(&order, portion);
        let poses = [noisy_poses(1, some * BODIES), noisy_poses(2, all * BODIES)];
        let snapshot = [velocities(3, some * BODIES), velocities(4, all * BODIES)];
        let placed = [noise(5, some * PAIRS), noise(6, all * PAIRS)];
        let settled = [noise(7, some * PAIRS), noise(8, all * PAIRS)];
        let statuses = [(0..some as u32).map(|slot| 100 + slot).collect(), vec![Status::PASSED_OVER.0; all]];

        let (batch, at) = (device.input(&[batch(candidates)])?, device.input(&[portion])?);
        let ranks = device.input(&order)?;
        let [from_poses, to_poses] = [device.input(&poses[0])?, device.input(&poses[1])?];
        let [from_snapshot, to_snapshot] = [device.input(&snapshot[0])?, device.input(&snapshot[1])?];
        let [from_placed, to_placed] = [device.input(&placed[0])?, device.input(&placed[1])?];
        let [from_settled, to_settled] = [device.input(&settled[0])?, device.input(&settled[1])?];
        let [from_statuses, to_statuses] = [device.input(&statuses[0])?, device.input(&statuses[1])?];
        let buffers = ScatterBuffers {
            batch: batch.uniform(),
            portion: at.uniform(),
            order: ranks.read(),
            poses: from_poses.read(),
            snapshot: from_snapshot.read(),
            depths_placed: from_placed.read(),
            depths_settled: from_settled.read(),
            statuses: from_statuses.read(),
            all_poses: to_poses.write(),
            all_snapshots: to_snapshot.write(),
            all_depths_placed: to_placed.write(),
            all_depths_settled: to_settled.write(),
            all_statuses: to_statuses.write(),
        };
        device.run(&buffers.step(&device.gpu, device.kernels()?, slots_at_once));
        device.expect("poses", &to_poses, &with_rows(&poses[1], &poses[0], BODIES, rows.clone()), 0.0)?;
        let expected = with_rows(&snapshot[1], &snapshot[0], BODIES, rows.clone());
        if words(&device.fetch(&to_snapshot)?) != words(&expected) || expected == snapshot[1] {
            return Err(format!("velocities of {candidates}").into());
        }
        device.expect("at placement", &to_placed, &with_rows(&placed[1], &placed[0], PAIRS, rows.clone()), 0.0)?;
        device.expect("at the end", &to_settled, &with_rows(&settled[1], &settled[0], PAIRS, rows.clone()), 0.0)?;
        device.expect("statuses", &to_statuses, &with_rows(&statuses[1], &statuses[0], 1, rows), 0.0)?;
    }
    Ok(())
}

fn passes_all_over(device: &Device) -> Result<(), Failed> {
    for (candidates, ..) in CASES {
        // What went wrong before stays known.
        let before: Vec<u32> = (0..candidates).map(|candidate| candidate % 16).collect();
        let expected: Vec<u32> = before.iter().map(|status| status | Status::PASSED_OVER.0).collect();
        let (batch, statuses) = (device.input(&[batch(candidates)])?, device.input(&before)?);
        let buffers = PassOverBuffers { batch: batch.uniform(), statuses: statuses.write() };
        device.run(&buffers.step(&device.gpu, device.kernels()?, candidates));
        device.expect(&candidates.to_string(), &statuses, &expected, 0.0)?;
    }
    Ok(())
}
