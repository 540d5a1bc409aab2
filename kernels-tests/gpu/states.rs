//! Candidates on the CPU before a substep of the solver and after it, as the device's tables hold them.

use super::fixture::{Device, Value, compare, noise};
use bytemuck::Zeroable;
use glam::Vec3;
use libtest_mimic::Failed;
use rest3d_gpu::cpu::contacts::{Contact, Patch};
use rest3d_gpu::cpu::{Group, Workspace, narrow_phase::Separator};
use rest3d_gpu::gpu::{Batch, Buffer, Contact as GpuContact, Motion, Patch as GpuPatch, Sim, Solver, Touching, Way};
use rest3d_gpu::world::{Pose, SimSettings, Velocity, World};
use std::ops::Range;

/// Sums over hundreds of sweeps that are contracted differently: m/s and rad/s; kilogrammes make N s of them.
pub const TOLERANCE: f32 = 2e-5;

/// So many different states are repeated to fill a batch.
pub const STATES: usize = 24;

/// A candidate before a substep or after it.
#[derive(Clone)]
pub struct State {
    pub poses: Vec<Pose>,
    pub velocities: Vec<Velocity>,
    pub patches: Vec<GpuPatch>,
    pub contacts: Vec<GpuContact>,
}

impl State {
    fn of(workspace: &Workspace) -> Self {
        let set = workspace.contacts();
        Self {
            poses: workspace.poses.clone(),
            velocities: workspace.velocities.clone(),
            patches: set.patches.iter().map(patch).collect(),
            contacts: set.points.iter().map(contact).collect(),
        }
    }
}

pub fn patch(patch: &Patch) -> GpuPatch {
    let Patch { pair, a, b, first, count, normal, friction, twist } = *patch;
    GpuPatch { normal, pair, friction, twist, a, b, first, count }
}

pub fn contact(contact: &Contact) -> GpuContact {
    let mut out = GpuContact::zeroed();
    let Contact { normal, point, separation, found, anchors, impulse, load, rest } = *contact;
    (out.normal, out.point, out.separation, out.found) = (normal, point, separation, found);
    (out.impulse, out.load, out.rest) = (impulse, load, rest);
    [out.anchor_a, out.anchor_b] = anchors;
    out
}

impl Value for Velocity {
    fn distance(&self, other: &Self) -> f32 {
        let apart = |a: Vec3, b: Vec3| a.distance(b) / b.length().max(1.0);
        apart(self.linear, other.linear) + apart(self.angular, other.angular)
    }
    fn spoil(&mut self, by: f32) {
        self.angular.z.spoil(2.0 * by);
    }
}

impl Value for GpuPatch {
    fn distance(&self, other: &Self) -> f32 {
        let numbers = |patch: &Self| [patch.pair, patch.a, patch.b, patch.first, patch.count];
        let known = numbers(self) == numbers(other) && self.normal == other.normal;
        let kept = if known { 0.0 } else { f32::NAN };
        kept + self.friction.distance(other.friction) + (self.twist - other.twist).abs()
    }
    fn spoil(&mut self, by: f32) {
        self.twist.spoil(by);
    }
}

impl Value for GpuContact {
    fn distance(&self, other: &Self) -> f32 {
        let vectors = |contact: &Self| [contact.normal, contact.point, contact.anchor_a, contact.anchor_b];
        let known = vectors(self) == vectors(other) && [self.separation, self.rest] == [other.separation, other.rest];
        let kept = if known { 0.0 } else { f32::NAN };
        kept + self.impulse.distance(&other.impulse) + self.load.distance(&other.load)
    }
    fn spoil(&mut self, by: f32) {
        self.impulse.spoil(by);
    }
}

/// Candidates that have been simulated for ever longer, with the contacts of their next substep, and after it. Left out
/// is what a rounding error decides on the CPU, too: whether there is one more sweep, or new lever arms.
pub fn states(world: &World, settings: &SimSettings) -> Result<Vec<[State; 2]>, Failed> {
    states_after(world, settings, 0.003, 0..STATES)
}

/// The world's start, every body moved by up to `spread`, m.
fn shifted(world: &World, spread: f32, stream: u32) -> Vec<Pose> {
    let shifts = noise(30 + stream, 3 * world.start.len());
    let moved =
        |(pose, shift): (&Pose, &[f32])| Pose::new(pose.rotation, pose.translation + spread * Vec3::from_slice(shift));
    world.start.iter().zip(shifts.chunks_exact(3)).map(moved).collect()
}

/// The same after so many steps each, from where the bodies are within `spread` (m) of the world's start.
pub fn states_after(
    world: &World,
    settings: &SimSettings,
    spread: f32,
    steps: Range<usize>,
) -> Result<Vec<[State; 2]>, Failed> {
    let narrow = Separator::new(settings.narrow_phase, &world.hulls);
    let mut group = Group::new(world, 1);
    let mut substep = |i: usize, rounding: f32| {
        group.start(&shifted(world, spread, i as u32));
        for _ in 0..i {
            group.step(world, settings, &narrow);
        }
        group.collide(world, settings, &narrow);
        let [workspace] = group.candidates_mut() else { unreachable!("a group of one") };
        workspace.poses.iter_mut().for_each(|pose| pose.translation *= 1.0 + rounding);
        let before = State::of(workspace);
        group.solve(world, settings);
        [before, State::of(&group.candidates()[0])]
    };
    let count = steps.len();
    let roundings = [0.0, 1.0, -1.0, 4.0, -4.0].map(|ulps| ulps * f32::EPSILON);
    let all = steps.map(|i| roundings.map(|rounding| substep(i, rounding)));
    let same = |a: &State, b: &State| {
        compare(&a.velocities, &b.velocities, 0.5 * TOLERANCE).is_ok()
            && compare(&a.patches, &b.patches, 0.5 * TOLERANCE).is_ok()
    };
    let kept: Vec<_> = all
        .filter(|[exact, others @ ..]| others.iter().all(|other| same(&exact[1], &other[1])))
        .map(|[exact, ..]| exact)
        .collect();
    if kept.len() < count / 5 {
        return Err(format!("only {} states are well posed", kept.len()).into());
    }
    Ok(kept)
}

/// So many candidates within `spread` (m) of the world's start, with the contacts of their first substep, and when these
/// have their loads.
pub fn beginnings(world: &World, settings: &SimSettings, spread: f32, count: u32) -> Vec<[State; 2]> {
    let narrow = Separator::new(settings.narrow_phase, &world.hulls);
    let mut group = Group::new(world, 1);
    let begun = |i: u32| {
        group.start(&shifted(world, spread, i));
        group.collide(world, settings, &narrow);
        let loaded = State::of(&group.candidates()[0]);
        let mut bare = loaded.clone();
        bare.patches.iter_mut().for_each(|patch| (patch.friction, patch.twist) = (Vec3::ZERO, 0.0));
        bare.contacts.iter_mut().for_each(|contact| (contact.impulse, contact.load) = (0.0, 0.0));
        [bare, loaded]
    };
    (0..count).map(begun).collect()
}

/// A candidate before each of its first substeps.
pub fn course(world: &World, settings: &SimSettings, substeps: usize) -> Vec<State> {
    let narrow = Separator::new(settings.narrow_phase, &world.hulls);
    let mut group = Group::new(world, 1);
    group.start(&world.start);
    let mut next = || {
        group.collide(world, settings, &narrow);
        let state = State::of(&group.candidates()[0]);
        group.solve(world, settings);
        state
    };
    (0..substeps).map(|_| next()).collect()
}

/// Tables of a batch in which state follows state, and again from the first.
pub struct Tables {
    pub poses: Vec<Pose>,
    pub velocities: Vec<Velocity>,
    pub counts: Vec<u32>,
    pub patches: Vec<GpuPatch>,
    pub contacts: Vec<GpuContact>,
}

impl Tables {
    pub fn new(world: &World, states: &[State], candidates: u32) -> Self {
        let slots = world.capacities.contacts as usize;
        let mut tables = Self {
            poses: Vec::new(),
            velocities: Vec::new(),
            counts: Vec::new(),
            patches: Vec::new(),
            contacts: Vec::new(),
        };
        for (i, state) in states.iter().cycle().take(candidates as usize).enumerate() {
            tables.poses.extend(&state.poses);
            tables.velocities.extend(&state.velocities);
            tables.counts.push(state.patches.len() as u32);
            tables.patches.extend(&state.patches);
            tables.patches.resize((i + 1) * slots, GpuPatch::zeroed());
            tables.contacts.extend(&state.contacts);
            tables.contacts.resize((i + 1) * slots, GpuContact::zeroed());
        }
        tables
    }
}

/// The same on the device, with a solver of theirs, all of whose tables are poisoned.
pub struct Uploaded {
    pub solver: Solver,
    pub poses: Buffer<Pose>,
    pub velocities: Buffer<Velocity>,
    pub statuses: Buffer<u32>,
    pub patches: Buffer<GpuPatch>,
    pub contacts: Buffer<GpuContact>,
}

impl Uploaded {
    /// The contacts are those of substeps of the given parity.
    pub fn new(
        device: &Device,
        (world, parameters, parity, way): (&World, &Sim, usize, Way),
        tables: &Tables,
    ) -> Result<Self, Failed> {
        let candidates = tables.counts.len() as u32;
        let (batch, sim) = (device.input(&[Batch::new(world, candidates)])?, device.input(&[*parameters])?);
        let bodies = device.input(&world.bodies)?;
        let poses = device.input(&tables.poses)?;
        let velocities = device.input(&tables.velocities)?;
        let statuses = device.input(&vec![0u32; tables.counts.len()])?;
        let counts = device.input(&tables.counts)?;
        let patches = device.input(&tables.patches)?;
        let contacts = device.input(&tables.contacts)?;
        let unused = (device.poisoned(1)?, device.poisoned(1)?, device.poisoned(1)?);
        let motion =
            Motion { batch: &batch, bodies: &bodies, poses: &poses, velocities: &velocities, statuses: &statuses };
        let used = Touching { counts: &counts, patches: &patches, contacts: &contacts };
        let idle = Touching { counts: &unused.0, patches: &unused.1, contacts: &unused.2 };
        let roles = if parity == 0 { [used, idle] } else { [idle, used] };
        let sizes = [candidates, world.bodies.len() as u32];
        let solver = Solver::new(&device.gpu, device.kernels()?, sizes, (parameters, &sim), way, motion, roles)?;
        device.poison(&solver.moving);
        device.poison(&solver.frictions);
        device.poison(&solver.normals);
        Ok(Self { solver, poses, velocities, statuses, patches, contacts })
    }

    /// Compares the contacts with what they are to be.
    pub fn expect_contacts(&self, device: &Device, what: &str, after: &Tables) -> Result<(), Failed> {
        device.expect(&format!("patches, {what}"), &self.patches, &after.patches, TOLERANCE)?;
        device.expect(&format!("contacts, {what}"), &self.contacts, &after.contacts, TOLERANCE)
    }
}
