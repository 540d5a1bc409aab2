//! The same bits for a candidate in every run, whatever is simulated beside it.

use super::{free_motion::hard_heap, settings};
use crate::common::hulls::prism;
use crate::common::scenario::{Scenario, box_inertia};
use glam::{Quat, Vec3};
use rest3d_gpu::world::{Backend, Flow, Pose, Velocity, World};

const CANDIDATES: usize = 12;
const STEPS: u32 = 90;
/// The candidate that has no numbers to begin with, where one is wanted.
const LOST: usize = 3;

/// A table, and a heap that falls onto it and off it.
fn heap() -> World {
    let mut s = Scenario::default();
    s.table(5.0);
    for i in 0..5 {
        let n = i as f32;
        let at = Pose::new(Quat::from_rotation_x(0.6 * n), Vec3::new(0.02 * n, 0.85 + 0.15 * n, 0.03 * n));
        let shape = if i % 2 == 0 { prism(0.06, 0.05, 8) } else { prism(0.08, 0.04, 4) };
        s.body(vec![shape], 1.0, box_inertia(1.0, Vec3::splat(0.06)), at);
    }
    s.world()
}

/// Where a candidate starts: everything but the table is shifted and turned.
fn start(world: &World, candidate: usize) -> Vec<Pose> {
    let n = candidate as f32;
    let turn = Pose::new(Quat::from_rotation_y(0.1 * n), Vec3::new(0.01 * n, 0.005 * n, -0.008 * n));
    world.start.iter().enumerate().map(|(i, pose)| if i == 0 { *pose } else { turn.then(pose) }).collect()
}

/// All states of each of the candidates, as bits.
fn simulate(backend: &dyn Backend, world: &World, candidates: &[usize]) -> Vec<Vec<u8>> {
    let bodies = world.bodies.len();
    let starts: Vec<Pose> = candidates.iter().flat_map(|&candidate| start(world, candidate)).collect();
    let mut bits = vec![Vec::new(); candidates.len()];
    let mut keep = |_: u32, poses: &[Pose], velocities: &[Velocity]| {
        let each = poses.chunks_exact(bodies).zip(velocities.chunks_exact(bodies));
        for (bits, (poses, velocities)) in bits.iter_mut().zip(each) {
            bits.extend_from_slice(bytemuck::cast_slice(poses));
            bits.extend_from_slice(bytemuck::cast_slice(velocities));
        }
        Flow::Continue
    };
    let status = backend.simulate(world, &settings(STEPS), &starts, &mut keep).unwrap();
    assert!(status.iter().all(|s| s.is_usable()), "status {status:?}");
    bits
}

/// Hash of every state of a batch.
pub fn batch_hash(backend: &dyn Backend) -> String {
    let all: Vec<usize> = (0..CANDIDATES).collect();
    let mut hash = blake3::Hasher::new();
    for bits in simulate(backend, &heap(), &all) {
        hash.update(&bits);
    }
    hash.finalize().to_hex()[..32].to_owned()
}

pub fn a_second_run_gives_the_same_bits(backend: &dyn Backend) {
    assert_eq!(batch_hash(backend), batch_hash(backend));
}

pub fn a_candidate_does_not_depend_on_the_others(backend: &dyn Backend) {
    // In the second, some candidates solve some small steps again.
    for world in [heap(), hard_heap(23).world()] {
        let all: Vec<usize> = (0..CANDIDATES).collect();
        let whole = simulate(backend, &world, &all);
        assert!((1..CANDIDATES).all(|i| whole[i] != whole[0]), "the candidates must differ");
        let backwards: Vec<usize> = all.iter().rev().copied().collect();
        for some in [backwards, vec![7, 2, 9, 4], vec![5], vec![3; 4]] {
            for (candidate, bits) in some.iter().zip(simulate(backend, &world, &some)) {
                assert!(bits == whole[*candidate], "candidate {candidate} differs among {some:?}");
            }
        }
    }
}

/// Candidates that end one after the other, from all over the population, leave those that go on alone; each is told
/// its own steps, and no more of them once it has ended.
pub fn a_candidate_does_not_depend_on_what_has_ended(backend: &dyn Backend) {
    let world = hard_heap(23).world();
    let all: Vec<usize> = (0..CANDIDATES).collect();
    let whole = simulate(backend, &world, &all);
    let mut starts: Vec<Pose> = all.iter().flat_map(|&candidate| start(&world, candidate)).collect();
    starts[LOST * world.bodies.len() + 1].translation.x = f32::NAN;
    let steps_of = |candidate: usize| 5 * (7 * candidate % CANDIDATES + 1);
    let mut bits = vec![Vec::new(); CANDIDATES];
    let mut taken = [0; CANDIDATES];
    let mut keep = |candidate: usize, poses: &[Pose], velocities: &[Velocity]| {
        bits[candidate].extend_from_slice(bytemuck::cast_slice::<_, u8>(poses));
        bits[candidate].extend_from_slice(bytemuck::cast_slice(velocities));
        taken[candidate] += 1;
        if taken[candidate] == steps_of(candidate) { Flow::Stop } else { Flow::Continue }
    };
    let status = backend.simulate_each(&world, &settings(STEPS), &starts, &mut keep).unwrap();
    for (candidate, (bits, whole)) in bits.iter().zip(&whole).enumerate() {
        assert_eq!(taken[candidate], steps_of(candidate), "steps of candidate {candidate}");
        assert_eq!(status[candidate].is_usable(), candidate != LOST, "status of candidate {candidate}");
        assert!(candidate == LOST || bits[..] == whole[..bits.len()], "candidate {candidate} differs");
    }
}
