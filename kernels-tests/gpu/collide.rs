//! Kernels `axis_remembered`, `axis_faces`, `axis_edges` and `depth`, with all others from poses to separations.

use super::Test;
use super::crowd::{crowd, scattered, speeds};
use super::fixture::{Device, SIZES, compare};
use glam::Vec3;
use libtest_mimic::Failed;
use rest3d_gpu::cpu::Workspace;
use rest3d_gpu::cpu::broad_phase::BroadPhase;
use rest3d_gpu::cpu::narrow_phase::{self, PairCache, Separator};
use rest3d_gpu::gpu::{Batch, Buffer, Collide, HullPair, Motion, Recorder, Separation, Tables};
use rest3d_gpu::world::constants::{AXIS_BIAS, AXIS_BIAS_RELATIVE, COHERENT_DEPTH, LINEAR_SLOP};
use rest3d_gpu::world::{Body, NarrowPhase, Pose, SimSettings, Status, Velocity, World};

pub const TESTS: &[Test] = &[
    ("collide::finds_the_axes_of_its_twin", finds_the_axes_of_its_twin),
    ("collide::measures_the_depths_of_its_twin", measures_the_depths_of_its_twin),
    ("collide::gives_the_same_bits_again_and_in_every_batch", gives_the_same_bits),
    ("collide::flags_what_does_not_fit", flags_what_does_not_fit),
];

/// m, for bodies of half a metre at about a metre from the origin.
const TOLERANCE: f32 = 2e-6;

/// Between unit normals: those of nearly parallel edges are uncertain.
const NORMAL_TOLERANCE: f32 = 2e-3;

/// Share of the hull pairs on which another axis may win, because it is as good up to rounding.
const TIES: f32 = 0.005;

/// A batch and its collision detection.
struct Rig {
    batch: Buffer<Batch>,
    bodies: Buffer<Body>,
    poses: Buffer<Pose>,
    velocities: Buffer<Velocity>,
    statuses: Buffer<u32>,
}

impl Rig {
    fn new(device: &Device, world: &World, candidates: u32) -> Result<Self, Failed> {
        Ok(Self {
            batch: device.input(&[Batch::new(world, candidates)])?,
            bodies: device.input(&world.bodies)?,
            poses: device.input(&scattered(world, candidates, 0))?,
            velocities: device.input(&speeds(world, candidates))?,
            statuses: device.input(&vec![0; candidates as usize])?,
        })
    }

    fn collide(&self, device: &Device, world: &World, tables: &Tables) -> Result<Collide, Failed> {
        let motion = Motion {
            batch: &self.batch,
            bodies: &self.bodies,
            poses: &self.poses,
            velocities: &self.velocities,
            statuses: &self.statuses,
        };
        let collide = Collide::new(&device.gpu, device.kernels()?, world, &SimSettings::default(), tables, motion)?;
        device.poison(&collide.separations);
        collide.hull_pairs.iter().for_each(|table| device.poison(table));
        Ok(collide)
    }
}

fn detect(device: &Device, collide: &Collide, parity: usize) {
    let mut recorder = Recorder::new(&device.gpu);
    if parity == 0 {
        collide.reset(&mut recorder);
    }
    collide.detect(&mut recorder, parity);
    recorder.submit();
}

/// What the device has found, and what the twin says of it.
struct Findings<'a> {
    world: &'a World,
    narrow: &'a Separator,
    poses: Vec<Pose>,
    velocities: Vec<Velocity>,
    /// Axes of the last substep, by candidate and hulls.
    old: Vec<HullPair>,
    old_starts: Vec<u32>,
    hull_pairs: Vec<HullPair>,
}

/// How often each kind of outcome occurred.
#[derive(Debug, Default)]
struct Tally {
    apart: u32,
    deep: u32,
    coherent: u32,
    ties: u32,
    all: u32,
    /// A slot whose distance was compared.
    compared: Option<usize>,
}

impl Findings<'_> {
    fn check(&self, separations: &[Separation]) -> Result<Tally, String> {
        let (world, settings) = (self.world, SimSettings::default());
        let slots = world.capacities.hull_pairs as usize;
        let n = world.bodies.len();
        let mut tally = Tally::default();
        let mut broad = BroadPhase::default();
        let mut list = Vec::new();
        let states = self.poses.chunks_exact(n).zip(self.velocities.chunks_exact(n));
        for (candidate, (poses, velocities)) in states.enumerate() {
            broad.forget();
            broad.update(world, poses, velocities, settings.contact_offset, settings.dt / settings.substeps as f32);
            broad.pairs(world, |pair| broad.margin(pair), slots as u32, &mut list);
            let known = self.old_starts[(candidate + 1) * (world.pairs.len() + 1) - 1] as usize;
            let old = &self.old[candidate * slots..][..known];
            for (i, pair) in list.iter().enumerate() {
                let at = candidate * slots + i;
                let (listed, found) = (self.hull_pairs[at], separations[at]);
                let place = format!("candidate {candidate}, {pair:?}: {listed:?}, {found:?}");
                if (listed.pair, listed.a, listed.b) != (pair.pair, pair.a, pair.b) {
                    return Err(place);
                }
                let before = old.iter().find(|o| (o.pair, o.a, o.b) == (pair.pair, pair.a, pair.b));
                let mut cache: PairCache = bytemuck::cast(before.map_or(0, |o| o.cache));
                let bodies = world.pairs[pair.pair as usize];
                let margin = broad.margin(bodies);
                let (poses, room) = (bodies.map(|body| &poses[body as usize]), broad.room(world, *pair));
                let hulls = narrow_phase::HullPair { tables: &world.hulls, hulls: [pair.a, pair.b], poses, room };
                let expected = self.narrow.separation(&hulls, margin, &mut cache);
                let cache: u32 = bytemuck::cast(cache);
                tally.all += 1;
                if listed.cache != cache {
                    tally.ties += 1;
                }
                let near = match (expected, found.feature) {
                    (None, 0) => {
                        tally.apart += 1;
                        continue;
                    }
                    // On the margin's edge, where the bias keeps an axis that parts a little less.
                    (None, _) => (found.distance - margin).abs() <= 2.0 * AXIS_BIAS + TOLERANCE,
                    (Some(s), 0) => (s.distance - margin).abs() <= 2.0 * AXIS_BIAS + TOLERANCE,
                    (Some(s), _) if listed.cache == cache => {
                        (found.distance - s.distance).abs() <= TOLERANCE
                            && found.normal.distance(s.normal) <= NORMAL_TOLERANCE
                    }
                    // Another axis, as good up to rounding once the preferences are counted.
                    (Some(s), _) => {
                        let preference = AXIS_BIAS + AXIS_BIAS_RELATIVE * (-s.distance).max(0.0);
                        let coherent = if before.is_some() { COHERENT_DEPTH + LINEAR_SLOP } else { 0.0 };
                        (found.distance - s.distance).abs() <= 2.0 * preference + coherent + TOLERANCE
                    }
                };
                if !near {
                    return Err(format!("{place} instead of {expected:?}, {cache:x}, margin {margin}"));
                }
                tally.compared = Some(at);
                tally.deep += u32::from(found.distance < -0.01);
                tally.coherent += u32::from(before.is_some() && found.distance.abs() < COHERENT_DEPTH);
            }
        }
        Ok(tally)
    }
}

fn finds_the_axes_of_its_twin(device: &Device) -> Result<(), Failed> {
    let world = crowd();
    let tables = Tables::new(&device.gpu, &world, &SimSettings::default())?;
    let narrow = Separator::new(NarrowPhase::Twin, &world.hulls);
    for candidates in SIZES {
        let rig = Rig::new(device, &world, candidates)?;
        let collide = rig.collide(device, &world, &tables)?;
        let slots = candidates as usize * world.capacities.hull_pairs as usize;
        let mut old = vec![HullPair::default(); slots];
        let mut old_starts = vec![0; candidates as usize * (world.pairs.len() + 1)];
        for step in 0..2 {
            let parity = step as usize;
            let poses = scattered(&world, candidates, step);
            rig.poses.upload(&device.gpu, &poses);
            detect(device, &collide, parity);
            let findings = Findings {
                world: &world,
                narrow: &narrow,
                poses,
                velocities: speeds(&world, candidates),
                old,
                old_starts,
                hull_pairs: device.fetch(&collide.hull_pairs[parity])?,
            };
            let separations = device.fetch(&collide.separations)?;
            let tally = findings.check(&separations).map_err(|error| format!("{candidates}, step {step}: {error}"))?;
            if tally.ties as f32 > TIES * tally.all as f32 + 1.0 {
                return Err(format!("{candidates}, step {step}: other axes: {tally:?}").into());
            }
            if candidates > 100 && (tally.deep < 1000 || tally.apart < 1000) {
                return Err(format!("{candidates}, step {step}: one-sided poses: {tally:?}").into());
            }
            // The canary: one separation is off by more than any tie explains.
            if let Some(at) = tally.compared {
                let mut spoiled = separations;
                spoiled[at].distance +=
                    4.0 * (AXIS_BIAS + AXIS_BIAS_RELATIVE * spoiled[at].distance.abs()) + LINEAR_SLOP;
                collide.separations.upload(&device.gpu, &spoiled);
                if findings.check(&device.fetch(&collide.separations)?).is_ok() {
                    return Err(format!("{candidates}: the comparison does not see an error").into());
                }
            }
            old = findings.hull_pairs;
            old_starts = device.fetch(&collide.pair_starts[parity])?;
        }
    }
    Ok(())
}

fn measures_the_depths_of_its_twin(device: &Device) -> Result<(), Failed> {
    let world = crowd();
    let tables = Tables::new(&device.gpu, &world, &SimSettings::default())?;
    let narrow = Separator::new(NarrowPhase::Twin, &world.hulls);
    for candidates in SIZES {
        let rig = Rig::new(device, &world, candidates)?;
        let collide = rig.collide(device, &world, &tables)?;
        let mut workspace = Workspace::new(&world);
        let mut expected = vec![0.0; candidates as usize * world.pairs.len()];
        let rows = expected.chunks_exact_mut(world.pairs.len());
        for (depths, poses) in rows.zip(scattered(&world, candidates, 0).chunks_exact(world.bodies.len())) {
            workspace.start(poses);
            workspace.measure_depths(&world, &narrow, depths);
        }
        let depths = device.poisoned(expected.len())?;
        let mut recorder = Recorder::new(&device.gpu);
        collide.reset(&mut recorder);
        // Neither an earlier list nor speed matters.
        collide.detect(&mut recorder, 0);
        collide.measure(&mut recorder, &depths);
        recorder.submit();
        device.expect(&candidates.to_string(), &depths, &expected, TOLERANCE)?;
        compare(&device.fetch(&collide.pair_starts[0])?, &vec![0; collide.pair_starts[0].len()], 0.0)?;
    }
    Ok(())
}

/// Tables after two substeps and a measurement, as words.
fn outcome(device: &Device, world: &World, candidates: u32) -> Result<[Vec<u32>; 4], Failed> {
    let tables = Tables::new(&device.gpu, world, &SimSettings::default())?;
    let rig = Rig::new(device, world, candidates)?;
    let collide = rig.collide(device, world, &tables)?;
    detect(device, &collide, 0);
    rig.poses.upload(&device.gpu, &scattered(world, candidates, 1));
    detect(device, &collide, 1);
    let listed = device.fetch(&collide.hull_pairs[1])?;
    let found = device.fetch(&collide.separations)?;
    let starts = device.fetch(&collide.pair_starts[1])?;
    let depths = device.poisoned(candidates as usize * world.pairs.len())?;
    let mut recorder = Recorder::new(&device.gpu);
    collide.measure(&mut recorder, &depths);
    recorder.submit();
    let depths: Vec<f32> = device.fetch(&depths)?;
    Ok([
        bytemuck::cast_slice(&listed).to_vec(),
        bytemuck::cast_slice(&found).to_vec(),
        starts,
        bytemuck::cast_slice(&depths).to_vec(),
    ])
}

fn gives_the_same_bits(device: &Device) -> Result<(), Failed> {
    let world = crowd();
    let full = outcome(device, &world, 65)?;
    if outcome(device, &world, 65)? != full {
        return Err("two runs differ".into());
    }
    let few = outcome(device, &world, 7)?;
    if few.iter().zip(&full).any(|(few, full)| full[..few.len()] != few[..]) {
        return Err("a candidate depends on its batch".into());
    }
    Ok(())
}

fn flags_what_does_not_fit(device: &Device) -> Result<(), Failed> {
    const LIMIT: u32 = 5;
    const CANDIDATES: u32 = 65;
    let world = crowd();
    let mut small = world.clone();
    small.capacities.hull_pairs = LIMIT;
    let [all, few] = [&world, &small].map(|world| Tables::new(&device.gpu, world, &SimSettings::default()));
    let rig = Rig::new(device, &world, CANDIDATES)?;
    let whole = rig.collide(device, &world, &all?)?;
    detect(device, &whole, 0);
    let totals = device.fetch(&whole.most_hull_pairs)?;
    let listed = device.fetch(&whole.hull_pairs[0])?;
    compare(&device.fetch(&rig.statuses)?, &vec![0; CANDIDATES as usize], 0.0)?;

    // Rows of five slots in buffers that are longer: what lies past the last row must stay as it is.
    let cut = rig.collide(device, &world, &few?)?;
    let untouched = device.fetch(&cut.hull_pairs[0])?;
    detect(device, &cut, 0);
    compare(&device.fetch(&cut.most_hull_pairs)?, &totals, 0.0)?;
    let flags: Vec<u32> = totals.iter().map(|&n| if n > LIMIT { Status::HULL_PAIRS.0 } else { 0 }).collect();
    if flags.iter().all(|&flag| flag == flags[0]) {
        return Err("all or none overflow".into());
    }
    compare(&device.fetch(&rig.statuses)?, &flags, 0.0)?;
    let written = device.fetch(&cut.hull_pairs[0])?;
    let (slots, row) = (world.capacities.hull_pairs as usize, LIMIT as usize);
    for (i, pair) in written.iter().enumerate() {
        let (candidate, slot) = (i / row, i % row);
        let in_use = totals.get(candidate).is_some_and(|&total| slot < total as usize);
        let expected = if in_use { listed[candidate * slots + slot] } else { untouched[i] };
        if *pair != expected {
            return Err(format!("slot {i} holds {pair:?} instead of {expected:?}").into());
        }
    }
    let separations = device.fetch(&cut.separations)?;
    let beyond = &separations[CANDIDATES as usize * row..];
    if beyond.iter().any(|s| s.feature != 0x7fc0_dead || s.normal.cmpeq(Vec3::ZERO).any()) {
        return Err("separations past the last row were written".into());
    }
    Ok(())
}
