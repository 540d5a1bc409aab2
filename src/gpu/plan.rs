//! How much memory a search takes and how many candidates it simulates at a time, known before anything is made.
//!
//! The lists below name every buffer that grows with the candidates; a test compares their sum with what is made.

use super::kernels::SHADERS;
use super::layout::{
    Axes, Ball, Bounds, Contact, Cursor, Facing, Flags, Free, Friction, Gap, HullPair, Levers, Manifold, ManifoldPoint,
    Mark, Merged, Moving, Normal, Outline, Patch, Portion, Preference, Separation, Sim, Stats, Update, Weights,
};
use super::layout::{Batch, Body, Draw, Edge, Energy, Face, Hull, Pose, Unit, Velocity, Winner};
use super::solver::patch_rows;
use crate::world::constants::MAX_MANIFOLD_POINTS;
use crate::world::{CemSettings, MemoryPlan, SearchSettings, World};
use glam::Vec4;

/// Bytes that a search may take together, where one candidate at a time does not take more: desktops share their
/// memory.
const BUDGET: u64 = 2 << 30;

/// What a population's memory is divided by.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// Bytes that one buffer may have.
    pub binding: u64,
    /// So many times as few candidates at a time as would fit; 1 for as many as fit.
    pub split: u32,
}

/// One buffer: its name, and its bytes for each candidate.
type Row = (&'static str, u64);

fn bytes<T>(count: usize) -> u64 {
    (count * size_of::<T>()) as u64
}

/// Buffers of `Simulation`, by candidate simulated at a time.
fn simulation(world: &World) -> [Row; 39] {
    let [bodies, pairs, hulls] = [world.bodies.len(), world.pairs.len(), world.hulls.hulls.len()];
    let [hull_pairs, contacts] = [world.capacities.hull_pairs, world.capacities.contacts].map(|n| n as usize);
    let (slots, entries) = (hull_pairs + hulls, pairs + bodies);
    [
        ("poses", bytes::<Pose>(bodies)),
        ("velocities", bytes::<Velocity>(bodies)),
        ("snapshot", bytes::<Velocity>(bodies)),
        ("depths_placed", bytes::<f32>(pairs)),
        ("depths_settled", bytes::<f32>(pairs)),
        ("statuses", bytes::<u32>(1)),
        ("hull_boxes", bytes::<Bounds>(hulls)),
        ("body_boxes", bytes::<Bounds>(bodies)),
        ("marks", bytes::<Mark>(bodies)),
        ("pair_counts", bytes::<u32>(pairs)),
        ("pair_starts", bytes::<u32>(pairs + 1)),
        ("pair_starts", bytes::<u32>(pairs + 1)),
        ("most_hull_pairs", bytes::<u32>(1)),
        ("hull_pairs", bytes::<HullPair>(hull_pairs)),
        ("hull_pairs", bytes::<HullPair>(hull_pairs)),
        ("separations", bytes::<Separation>(hull_pairs)),
        ("depths", bytes::<f32>(pairs)),
        ("patches", bytes::<Patch>(contacts)),
        ("patches", bytes::<Patch>(contacts)),
        ("contacts", bytes::<Contact>(contacts)),
        ("contacts", bytes::<Contact>(contacts)),
        ("patch_counts", bytes::<u32>(1)),
        ("patch_counts", bytes::<u32>(1)),
        ("point_counts", bytes::<u32>(1)),
        ("facings", bytes::<Facing>(hull_pairs)),
        ("manifolds", bytes::<Manifold>(slots)),
        ("manifold_points", bytes::<ManifoldPoint>(slots * MAX_MANIFOLD_POINTS)),
        ("merged", bytes::<Merged>(entries)),
        ("merged_points", bytes::<u32>(slots * MAX_MANIFOLD_POINTS)),
        ("starts", bytes::<[u32; 2]>(entries)),
        ("starts", bytes::<[u32; 2]>(entries)),
        ("moving", bytes::<Moving>(bodies + 1)),
        ("axes", bytes::<Axes>(bodies + 1)),
        ("free", bytes::<Free>(bodies + 1)),
        ("normals", bytes::<Normal>(contacts)),
        ("frictions", bytes::<Friction>(patch_rows(contacts as u32) as usize)),
        ("levers", bytes::<Levers>(patch_rows(contacts as u32) as usize)),
        ("gaps", bytes::<Gap>(contacts)),
        ("cursors", bytes::<Cursor>(1)),
    ]
}

/// Buffers of `Population`, all candidates together.
fn population(world: &World, cem: &CemSettings) -> u64 {
    let [bodies, pairs, units] = [world.bodies.len(), world.pairs.len(), world.units.len()];
    let (candidates, width) = (cem.drawn() as usize, world.dimensions());
    let poses = 2 * bytes::<Pose>(bodies) + bytes::<Velocity>(bodies) + 2 * bytes::<f32>(pairs);
    let ranks = bytes::<u32>(2) + bytes::<Energy>(1);
    let shared = bytes::<Body>(bodies) + bytes::<Unit>(units) + 2 * bytes::<Pose>(bodies) + bytes::<f32>(3 * width);
    let once = size_of::<(Batch, Weights, Update, Draw, Winner, Flags, Stats)>() as u64 + bytes::<u32>(2);
    candidates as u64 * (poses + ranks)
        + bytes::<f32>((candidates + 1) * width)
        + bytes::<[u32; 2]>(candidates.next_power_of_two())
        + bytes::<u32>(cem.elite_count() as usize)
        + shared
        + once
}

/// What `Simulation` makes once, however many candidates there are.
fn tables(world: &World) -> u64 {
    let hulls = &world.hulls;
    bytes::<Hull>(hulls.hulls.len())
        + bytes::<Vec4>(hulls.vertices.len())
        + bytes::<Face>(hulls.faces.len())
        + bytes::<u32>(hulls.face_vertices.len())
        + bytes::<Edge>(hulls.edges.len())
        + bytes::<[u32; 2]>(world.pairs.len())
        + bytes::<Ball>(hulls.hulls.len())
        + bytes::<u32>(hulls.hulls.len())
        + bytes::<Outline>(hulls.outlines.len())
        + bytes::<Vec4>(hulls.lines.len())
        + bytes::<Body>(world.bodies.len())
        + 2 * bytes::<Sim>(1)
        + 2 * bytes::<Preference>(1)
        + bytes::<Batch>(1)
}

/// How many of `candidates` are simulated at a time beside `held` bytes: as many as buffers and budget allow, at least
/// one, in portions of about the same size.
pub(super) fn fitting(world: &World, candidates: u32, held: u64, room: Room) -> u32 {
    let largest = simulation(world).iter().map(|(_, bytes)| *bytes).max().unwrap_or(0).max(1);
    let fit = (room.binding / largest).min(BUDGET.saturating_sub(held) / each(world).max(1));
    let fit = u32::try_from(fit).unwrap_or(u32::MAX).clamp(1, candidates.max(1));
    let fit = (fit / room.split.max(1)).max(1);
    candidates.div_ceil(candidates.div_ceil(fit).max(1)).max(1)
}

/// Bytes of a candidate that is simulated.
fn each(world: &World) -> u64 {
    simulation(world).iter().map(|(_, bytes)| bytes).sum()
}

/// How many candidates of a search are simulated at a time, and in the last round, if that is smaller.
pub(super) fn at_once(world: &World, settings: &SearchSettings, room: Room) -> (u32, Option<u32>) {
    let cem = &settings.cem;
    let last = settings.rounds().last().map_or(0, |round| round.candidates);
    let fewer = if last < cem.candidates { simulator(world, last) } else { 0 };
    let at_once = fitting(world, cem.candidates, population(world, cem) + tables(world) + fewer, room);
    (at_once, (last < at_once).then_some(last))
}

/// What simulates so many candidates at a time.
fn simulator(world: &World, candidates: u32) -> u64 {
    tables(world) + u64::from(candidates) * each(world)
}

/// Rounds of all loops of an invocation together in what ranks the candidates: the sorting network of `elites`, a
/// workgroup's share of it, and the two passes of `moments` over the elites.
pub(super) fn ranking_loops(cem: &CemSettings) -> u64 {
    let sorting = SHADERS.iter().find(|shader| shader.name == "elites").map_or(1, |shader| shader.workgroup[0].into());
    let keys = u64::from(cem.drawn().max(2)).next_power_of_two();
    let stages = u64::from(keys.ilog2() * (keys.ilog2() + 1) / 2);
    let sort = stages * (keys / 2).div_ceil(sorting) + 2 * keys.div_ceil(sorting) + stages;
    sort.max(2 * u64::from(cem.elite_count()))
}

/// The memory of a search, without making any of it.
pub fn plan(world: &World, settings: &SearchSettings, room: Room) -> MemoryPlan {
    let (at_once, last) = at_once(world, settings, room);
    let simulators = simulator(world, at_once) + last.map_or(0, |last| simulator(world, last));
    let rounds = settings.rounds();
    let handovers = rounds.iter().enumerate().skip(1).map(|(number, round)| {
        let is_last = number + 1 == rounds.len();
        round.candidates.div_ceil(last.filter(|_| is_last).unwrap_or(at_once)) as usize
    });
    MemoryPlan { bytes: population(world, &settings.cem) + simulators + bytes::<Portion>(handovers.sum()), at_once }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{BodyDef, Capacities};
    use glam::{Quat, Vec3};

    const GIB: u64 = 1 << 30;

    /// Bodies of so many boxes each, in a row.
    fn world(bodies: usize, hulls: usize) -> World {
        let corner = |i: usize| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
        let part = |at: usize| (0..8).map(|i| corner(i) + Vec3::Y * at as f32).collect::<Vec<_>>();
        let defs: Vec<BodyDef> = (0..bodies)
            .map(|unit| {
                let start = Pose::new(Quat::IDENTITY, Vec3::X * 2.0 * unit as f32);
                let parts = (0..hulls).map(part).collect();
                BodyDef { parts, mass: 1.0, inertia: Vec3::ONE, unit: unit as u32, start, reference: start }
            })
            .collect();
        World::new(&defs, &(0..bodies as u32).collect::<Vec<_>>())
    }

    fn cem(candidates: u32) -> CemSettings {
        CemSettings { candidates, ..Default::default() }
    }

    fn search(candidates: u32) -> SearchSettings {
        SearchSettings { cem: cem(candidates), ..Default::default() }
    }

    #[test]
    fn a_large_population_takes_two_gigabytes_at_most() {
        let world = world(30, 16);
        for binding in [128 << 20, 2 * GIB, 4 * GIB] {
            let MemoryPlan { bytes, at_once } = plan(&world, &search(2048), Room { binding, split: 1 });
            assert!(bytes <= 2 * GIB, "{bytes} bytes, {at_once} at a time, buffers of {binding}");
            assert!(at_once >= 64, "{at_once} at a time");
            let largest = simulation(&world).iter().map(|(_, bytes)| *bytes).max().unwrap_or(0);
            assert!(u64::from(at_once) * largest <= binding);
        }
    }

    #[test]
    fn populations_are_split_evenly_where_a_buffer_or_the_budget_ends() {
        let world = world(4, 1);
        let largest = simulation(&world).iter().map(|(_, bytes)| *bytes).max().unwrap_or(0);
        let split = |fit: u64, split| plan(&world, &search(1000), Room { binding: fit * largest, split }).at_once;
        assert_eq!([split(1000, 1), split(999, 1), split(400, 1), split(1, 1)], [1000, 500, 334, 1]);
        assert_eq!([split(1000, 4), split(2, 4)], [250, 1]);
    }

    #[test]
    fn the_rounds_of_ranking_are_known() {
        // 36 stages of a round each and the loop around them, two rounds of all keys; half of many are elites.
        let many = CemSettings { elite_fraction: 0.5, ..cem(1 << 20) };
        assert_eq!([ranking_loops(&cem(200)), ranking_loops(&many)], [36 + 36 + 2, 1 << 20]);
    }

    #[test]
    fn what_fits_in_no_way_is_left_to_one_candidate() {
        let mut world = world(4, 1);
        world.capacities = Capacities { hull_pairs: 1 << 24, contacts: 128 };
        assert_eq!(plan(&world, &search(8), Room { binding: 8 * GIB, split: 1 }).at_once, 1);
        assert_eq!(plan(&world, &search(0), Room { binding: 1, split: 0 }).at_once, 1);
    }
}
