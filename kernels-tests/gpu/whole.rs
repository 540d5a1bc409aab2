//! Whole populations of a real scene on the device, beside the CPU backend with the same kernels and with parry's
//! geometry.
//!
//! Candidates are drawn on the device from the same random numbers, so they differ from the CPU's by rounding; where a
//! body tumbles, contacts make that large. What must agree is what the search goes by.

use super::Test;
use super::fixture::Device;
use crate::common::scenes::as_it_stands;
use libtest_mimic::Failed;
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::world::{
    Backend, CemSettings, Energy, Flow, NarrowPhase, Pose, SearchSettings, SimSettings, Stream, World, angle_between,
};

pub const TESTS: &[Test] = &[("whole::a_broken_room_as_on_the_cpu", a_broken_room)];

/// Those that need the shared scenes beside the project.
pub const SHARED_TESTS: &[Test] = &[("whole::a_standing_room_as_the_reference", a_standing_room)];

/// Unstable beyond this, m and rad: the paper's metric.
const STABLE: f32 = 0.1;

/// A body that overlaps another by more than this at its start is not counted, m.
const TOUCHING: f32 = 1e-3;

const CANDIDATES: u32 = 100;

/// So many of them are simulated once more to see where their bodies end.
const WATCHED: u32 = 40;

/// Smallest shares that must agree: verdicts of what starts free; elites (a tenth of the candidates); and rank
/// correlation.
const VERDICTS: f64 = 0.99;
const ELITES: f64 = 0.9;
const RANKS: f64 = 0.98;

/// Smallest share of energies within 1 % of those of the same kernels on the CPU, on a software adapter: those there
/// have their bits, but for the candidate in many that parts.
const ENERGIES: f64 = 0.98;

fn settings(narrow_phase: NarrowPhase) -> SearchSettings {
    let simulation = SimSettings { narrow_phase, ..Default::default() };
    let cem = CemSettings { candidates: CANDIDATES, ..Default::default() };
    SearchSettings { simulation, cem, ..Default::default() }
}

/// The first population: energies, and where every body of the first candidates was and came to lie.
struct Population {
    energies: Vec<Energy>,
    starts: Vec<Pose>,
    ends: Vec<Pose>,
}

impl Population {
    fn new(backend: &dyn Backend, world: &World, narrow_phase: NarrowPhase) -> Result<Self, Failed> {
        let settings = settings(narrow_phase);
        let mut search = backend.search(world, &settings, Stream { seed: 0, stage: 0 })?;
        search.iterate()?;
        let placed: Result<Vec<_>, _> = (0..WATCHED).map(|candidate| search.placed(candidate)).collect();
        let starts = placed?.concat();
        let mut ends = Vec::new();
        backend.simulate(world, &settings.simulation, &starts, &mut |_, poses, _| {
            ends.clear();
            ends.extend_from_slice(poses);
            Flow::Continue
        })?;
        Ok(Self { energies: search.energies()?, starts, ends })
    }

    /// Rank of every candidate by its energy.
    fn ranks(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.energies.len()).collect();
        order.sort_by(|&a, &b| self.energies[a].total.total_cmp(&self.energies[b].total));
        let mut ranks = vec![0; order.len()];
        order.iter().enumerate().for_each(|(rank, &candidate)| ranks[candidate] = rank);
        ranks
    }

    fn is_stable(&self, row: usize) -> bool {
        let (start, end) = (&self.starts[row], &self.ends[row]);
        start.translation.distance(end.translation) <= STABLE && angle_between(start.rotation, end.rotation) <= STABLE
    }
}

/// Share of verdicts on bodies that start free on which two backends agree, and how many there are.
fn verdicts(world: &World, a: &Population, b: &Population) -> Result<(f64, usize), Failed> {
    let bodies = world.bodies.len();
    let (mut same, mut all) = (0, 0);
    for (candidate, start) in a.starts.chunks_exact(bodies).enumerate() {
        let overlaps = CpuBackend.overlaps(world, &SimSettings::default(), start)?;
        for body in (0..bodies).filter(|&body| !world.bodies[body].is_static()) {
            let touches = |pair: &[u32; 2]| pair.contains(&(body as u32));
            if world.pairs.iter().zip(&overlaps).any(|(pair, &depth)| touches(pair) && depth > TOUCHING) {
                continue;
            }
            let row = candidate * bodies + body;
            all += 1;
            same += usize::from(a.is_stable(row) == b.is_stable(row));
        }
    }
    Ok((same as f64 / all as f64, all))
}

/// Spearman's rank correlation of the energies, and the share of elites that two backends have in common.
fn ranking(a: &Population, b: &Population) -> (f64, f64) {
    let (first, second) = (a.ranks(), b.ranks());
    let n = first.len() as f64;
    let squares: f64 = first.iter().zip(&second).map(|(&x, &y)| (x as f64 - y as f64).powi(2)).sum();
    let elites = first.len() / 10;
    let shared = first.iter().zip(&second).filter(|&(&x, &y)| x < elites && y < elites).count();
    (1.0 - 6.0 * squares / (n * (n * n - 1.0)), shared as f64 / elites as f64)
}

/// The first populations of a scene on the device and on the CPU agree on what the search goes by.
fn agree(device: &Device, scene: &str, narrow_phase: NarrowPhase) -> Result<(), Failed> {
    let (_, world) = as_it_stands(scene);
    let found = Population::new(device.backend()?, &world, NarrowPhase::Twin)?;
    let expected = Population::new(&CpuBackend, &world, narrow_phase)?;
    let (verdicts, counted) = verdicts(&world, &found, &expected)?;
    let (ranks, elites) = ranking(&found, &expected);
    let pairs = found.energies.iter().zip(&expected.energies);
    let near = pairs.filter(|(a, b)| (a.total - b.total).abs() <= 0.01 * b.total).count();
    let said = format!(
        "{scene}, {narrow_phase:?}: {verdicts:.4} of {counted} verdicts, rank correlation {ranks:.4}, {elites:.2} of the \
         elites, {near} of {CANDIDATES} energies within 1 %"
    );
    eprintln!("{said}");
    let exact = narrow_phase == NarrowPhase::Twin && device.rounding(1.0) == 0.0;
    let alike = !exact || near as f64 >= ENERGIES * f64::from(CANDIDATES);
    if !alike || verdicts < VERDICTS || ranks < RANKS || elites < ELITES || counted < 100 {
        return Err(said.into());
    }
    Ok(())
}

fn a_broken_room(device: &Device) -> Result<(), Failed> {
    agree(device, "scenes/study/scene.json", NarrowPhase::Twin)
}

/// Begun inside one another, things come apart as the geometry's algorithm says, and each says something else; so the
/// reference is asked about a layout that is known to stand.
fn a_standing_room(device: &Device) -> Result<(), Failed> {
    agree(device, "../shared/scenes/study/truth.json", NarrowPhase::Reference)
}
