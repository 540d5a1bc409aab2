//! Rollouts of a population without a search around them: what `bench` measures.

use super::clock::{Clock, Laps};
use super::group::{Group, at_once};
use super::narrow_phase::Separator;
use crate::world::{KernelTime, Pose, Rollouts, SimSettings, Status, World};
use rayon::prelude::*;
use std::time::Instant;

/// Candidates whose kernels are timed; the others are taken to be alike.
const TIMED: usize = 128;

/// Simulates every candidate to its end, groups of them in parallel.
pub fn rollouts(world: &World, settings: &SimSettings, starts: &[Pose]) -> Rollouts {
    let narrow = Separator::new(settings.narrow_phase, &world.hulls);
    let bodies = world.bodies.len().max(1);
    let size = at_once(starts.len() / bodies, Group::lanes());
    let mut settled = starts.to_vec();
    let (statuses, contacts): (Vec<Vec<Status>>, Vec<u64>) = settled
        .par_chunks_mut(size * bodies)
        .map_init(
            || Group::new(world, size),
            |group, poses| {
                let contacts = rollout(group, world, settings, &narrow, poses, &mut ());
                for (candidate, poses) in group.candidates().iter().zip(poses.chunks_exact_mut(bodies)) {
                    poses.copy_from_slice(&candidate.poses);
                }
                (group.candidates().iter().map(|candidate| candidate.status).collect(), contacts)
            },
        )
        .unzip();
    let statuses = statuses.concat();
    let counted = statuses.len() as f64 * f64::from(settings.steps);
    let contacts_per_substep = Some(contacts.iter().sum::<u64>() as f64 / counted.max(1.0));
    Rollouts { settled, statuses, contacts_per_substep }
}

/// Times the kernels over evenly picked candidates. Reading the clock slows them down, so the times are scaled to the
/// wall time that the same candidates take without it.
pub fn kernel_times(world: &World, settings: &SimSettings, starts: &[Pose]) -> Vec<KernelTime> {
    let bodies = world.bodies.len().max(1);
    let candidates = starts.len() / bodies;
    let every = candidates.div_ceil(TIMED).max(1);
    let picked: Vec<Pose> = starts.chunks_exact(bodies).step_by(every).flatten().copied().collect();
    let clock = Instant::now();
    rollouts(world, settings, &picked);
    let untimed = clock.elapsed().as_secs_f64();
    let narrow = Separator::new(settings.narrow_phase, &world.hulls);
    let size = at_once(picked.len() / bodies, Group::lanes());
    let laps = picked
        .par_chunks(size * bodies)
        .map_init(
            || Group::new(world, size),
            |group, placed| {
                let mut laps = Laps::start();
                rollout(group, world, settings, &narrow, placed, &mut laps);
                laps
            },
        )
        .reduce(Laps::start, Laps::plus);
    let share = candidates as f64 / (picked.len() / bodies).max(1) as f64;
    laps.times(1e3 * untimed * share / laps.milliseconds())
}

/// Simulates a group of candidates; the sum over the steps of the contacts at their end.
fn rollout(
    group: &mut Group,
    world: &World,
    settings: &SimSettings,
    narrow: &Separator,
    placed: &[Pose],
    clock: &mut impl Clock,
) -> u64 {
    group.start(placed);
    let mut contacts = 0;
    for _ in 0..settings.steps {
        group.step_timed(world, settings, narrow, clock);
        contacts += group.candidates().iter().map(|candidate| candidate.contacts().points.len() as u64).sum::<u64>();
    }
    contacts
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::cpu::CpuBackend;
    use crate::shape::box_corners;
    use crate::world::{Backend, BodyDef, Flow};
    use glam::{Quat, Vec3};

    /// Two bricks, the upper one in the air, from 50 heights.
    #[test]
    fn rollouts_end_where_simulations_end_and_count_contacts() {
        let bodies = [0.1, 0.32].map(|y| {
            let start = Pose::new(Quat::IDENTITY, Vec3::Y * y);
            let parts = vec![box_corners(Vec3::splat(0.1))];
            let unit = u32::from(y > 0.2);
            BodyDef { parts, mass: 1.0, inertia: Vec3::splat(0.0067), unit, start, reference: start }
        });
        let world = World::new(&bodies, &[0, 1]);
        let mut starts = world.start.repeat(50);
        (starts.iter_mut().zip(0u8..)).for_each(|(pose, i)| *pose = pose.raised(0.0001 * f32::from(i)));
        let settings = SimSettings { steps: 30, ..Default::default() };
        let mut settled = Vec::new();
        let statuses = CpuBackend
            .simulate(&world, &settings, &starts, &mut |_, poses, _| {
                settled = poses.to_vec();
                Flow::Continue
            })
            .unwrap();
        let rollouts = rollouts(&world, &settings, &starts);
        assert_eq!((&rollouts.settled, &rollouts.statuses), (&settled, &statuses));
        let contacts = rollouts.contacts_per_substep.unwrap();
        assert!((4.0..=8.0).contains(&contacts), "four points below each brick: {contacts}");
    }
}
