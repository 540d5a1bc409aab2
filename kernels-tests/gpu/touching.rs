//! A world of all kinds of hulls that rest on, touch and overlap each other, and what the CPU says of it.

use super::fixture::{Device, noise};
use crate::common::hulls::{cuboid, prism, shifted};
use glam::{Quat, Vec3};
use libtest_mimic::Failed;
use rest3d_gpu::cpu::narrow_phase::{self, Manifold, PairCache, Separator, manifold, passes, plane_hull};
use rest3d_gpu::gpu::{Batch, Bounds, Buffer, Contacts, HullPair, Inputs, Separation, Tables};
use rest3d_gpu::world::{BodyDef, NarrowPhase, Pose, STATIC, SimSettings, Velocity, World};

/// A plate whose top is chamfered by half a degree: five facets, one surface.
fn chamfered(half: Vec3) -> Vec<Vec3> {
    let mut points = cuboid(half);
    points.extend(cuboid(half * Vec3::new(0.7, 1.0, 0.7)).iter().map(|p| *p + Vec3::Y * p.y.signum() * 0.0015));
    points
}

fn pebble(seed: u32, count: usize, radius: f32) -> Vec<Vec3> {
    noise(seed, 3 * count).chunks_exact(3).map(|x| radius * Vec3::new(x[0], x[1], x[2]).normalize()).collect()
}

/// A fixed plate and seven bodies on it; all are about 0.1 m high.
pub fn world() -> World {
    plate_and(vec![
        vec![cuboid(Vec3::new(0.08, 0.05, 0.06))],
        vec![prism(0.07, 0.05, 8)],
        vec![pebble(61, 24, 0.06)],
        vec![
            cuboid(Vec3::new(0.1, 0.01, 0.1)),
            shifted(&cuboid(Vec3::new(0.01, 0.05, 0.1)), Vec3::X * 0.09),
            shifted(&cuboid(Vec3::new(0.01, 0.05, 0.1)), Vec3::X * -0.09),
        ],
        vec![prism(0.08, 0.05, 30)],
        vec![pebble(62, 60, 0.05)],
        vec![prism(0.04, 0.05, 6), shifted(&chamfered(Vec3::new(0.05, 0.02, 0.05)), Vec3::Z * 0.06)],
    ])
}

/// The plate and something on 24 feet of eight corners: more points than are gathered at once.
pub fn raft() -> World {
    let foot = |i: usize| shifted(&prism(0.015, 0.05, 8), Vec3::new(0.04 * (i % 6) as f32, 0.0, 0.04 * (i / 6) as f32));
    plate_and(vec![(0..24).map(foot).collect()])
}

/// The plate and eight larger ones that face it, each turned by ten degrees from the next: points that look about the way
/// of two patches.
pub fn fan() -> World {
    let slab = |i: usize| {
        let turn = Quat::from_rotation_z((10.0 * i as f32 - 35.0).to_radians());
        shifted(&cuboid(Vec3::new(0.8, 0.05, 0.6)), Vec3::NEG_Y * 0.1).iter().map(|p| turn * *p).collect()
    };
    plate_and(vec![(0..8).map(slab).collect()])
}

fn plate_and(others: Vec<Vec<Vec<Vec3>>>) -> World {
    let plate = vec![chamfered(Vec3::new(0.6, 0.02, 0.4))];
    let units: Vec<u32> = (1..=others.len() as u32).collect();
    let bodies = [plate].into_iter().chain(others);
    let defs: Vec<BodyDef> = (bodies.enumerate())
        .map(|(i, parts)| BodyDef {
            parts,
            mass: 1.0,
            inertia: Vec3::ONE,
            unit: if i == 0 { STATIC } else { i as u32 - 1 },
            start: Pose::IDENTITY,
            reference: Pose::IDENTITY,
        })
        .collect();
    World::new(&defs, &units)
}

/// Poses of one candidate: upright and all but touching the plate, the same a little tilted, in a heap, or scattered.
/// `age` moves everything by up to 2 mm.
pub fn poses(world: &World, candidate: u32, age: u32) -> Vec<Pose> {
    let random = noise(100 + candidate, 8 * world.bodies.len());
    let moved = noise(9 + age, 3 * world.bodies.len());
    let kind = candidate % 4;
    (random.chunks_exact(8).zip(moved.chunks_exact(3)).enumerate())
        .map(|(i, (x, y))| {
            let turn = Quat::from_scaled_axis(Vec3::new(x[0], x[1], x[2]));
            let around = Quat::from_rotation_y(x[3]);
            let (rotation, height) = match kind {
                0 => (around, 0.0915 + 0.001 * x[4]),
                1 => (Quat::from_scaled_axis(0.002 * Vec3::new(x[0], 0.0, x[1])) * around, 0.0915 + 0.001 * x[4]),
                _ => (turn, 0.05 + 0.03 * x[4]),
            };
            if i == 0 {
                return Pose::new(Quat::IDENTITY, Vec3::Y * 0.02);
            }
            // Beyond the plate's edge and above it by less than it falls in a substep: it will pass.
            if i == 1 && candidate % 8 == 3 {
                return Pose::new(Quat::IDENTITY, Vec3::new(0.6802, 0.0905, 0.0));
            }
            // Tilted beside a corner of the plate: only a plane through an edge has air before it.
            if i == 1 && candidate % 8 == 7 {
                let turn = Quat::from_rotation_y(std::f32::consts::FRAC_PI_4);
                let beside = Vec3::new(0.6, 0.0555, 0.4) + turn * (Vec3::Z * 0.0768);
                return Pose::new(turn * Quat::from_rotation_x(0.5), beside);
            }
            let spread = if kind == 2 { 0.05 } else { 0.15 };
            let aged = 0.0005 * age as f32 * Vec3::new(y[0], y[1], y[2]);
            Pose::new(rotation, Vec3::new(spread * x[5], height, spread * x[6]) + aged)
        })
        .collect()
}

/// A third of the candidates is at rest; in another bodies move on by some centimetres a substep, some of them only
/// down; in the last by so little that gravity counts.
fn velocities(world: &World, candidate: u32) -> Vec<Velocity> {
    let random = noise(500 + candidate, 6 * world.bodies.len());
    (random.chunks_exact(6).zip(&world.bodies).enumerate())
        .map(|(i, (x, body))| match (candidate % 3, i % 2) {
            _ if body.is_static() => Velocity::default(),
            (0, _) => Velocity::default(),
            (2, _) => Velocity::new(0.1 * Vec3::new(x[0], x[1], x[2]), 0.1 * Vec3::new(x[3], x[4], x[5])),
            (_, 0) => Velocity::new(4.0 * Vec3::NEG_Y, Vec3::ZERO),
            _ => Velocity::new(4.0 * Vec3::new(x[0], x[1], x[2]), Vec3::new(x[3], x[4], x[5])),
        })
        .collect()
}

/// Both halves' margins lie in [0.01, 0.03] m.
fn margins(world: &World, candidate: u32) -> Vec<f32> {
    noise(7000 + candidate, world.bodies.len()).iter().map(|x| 0.01 + 0.02 * x.abs().min(1.0)).collect()
}

/// What the CPU finds for one candidate.
pub struct Expected {
    pub poses: Vec<Pose>,
    pub velocities: Vec<Velocity>,
    pub margins: Vec<f32>,
    pub hull_pairs: Vec<HullPair>,
    /// First hull pair of each body pair, and how many there are.
    pub starts: Vec<u32>,
    pub separations: Vec<Separation>,
    pub manifolds: Vec<Manifold>,
    /// How many contacts were dropped because the hulls only pass each other.
    pub passing: usize,
    /// One for each hull.
    pub ground: Vec<Manifold>,
}

impl Expected {
    pub fn new(world: &World, settings: &SimSettings, narrow: &Separator, candidate: u32, age: u32) -> Self {
        let poses = poses(world, candidate, age);
        let velocities = velocities(world, candidate);
        let margins = margins(world, candidate);
        let mut found = Self {
            poses,
            velocities,
            margins,
            hull_pairs: Vec::new(),
            starts: vec![0],
            separations: Vec::new(),
            manifolds: Vec::new(),
            passing: 0,
            ground: Vec::new(),
        };
        for (pair, bodies) in world.pairs.iter().enumerate() {
            let [first, second] = bodies.map(|body| body as usize);
            for a in world.hulls_of(first) {
                for b in world.hulls_of(second) {
                    found.collide(
                        world,
                        settings,
                        narrow,
                        HullPair { pair: pair as u32, a: a as u32, b: b as u32, cache: 0 },
                    );
                }
            }
            found.starts.push(found.hull_pairs.len() as u32);
        }
        for (index, body) in world.bodies.iter().enumerate() {
            let margin = found.margins[index] + 0.5 * settings.contact_offset;
            for hull in world.hulls_of(index) {
                let mut out = Manifold::default();
                if !body.is_static() {
                    plane_hull(&world.hulls, hull as u32, &found.poses[index], (Vec3::Y, 0.0), margin, &mut out);
                }
                found.ground.push(out);
            }
        }
        found
    }

    /// Distance within which the bodies of a pair touch, m.
    pub fn margin(&self, world: &World, pair: u32) -> f32 {
        world.pairs[pair as usize].iter().map(|&body| self.margins[body as usize]).sum()
    }

    fn collide(&mut self, world: &World, settings: &SimSettings, narrow: &Separator, pair: HullPair) {
        let margin = self.margin(world, pair.pair);
        let bodies = world.pairs[pair.pair as usize].map(|body| self.poses[body as usize]);
        let hulls = [pair.a, pair.b].map(|h| &world.hulls.hulls[h as usize]);
        let centers = [0, 1].map(|side: usize| bodies[side].point(hulls[side].center));
        if centers[0].distance(centers[1]) > hulls[0].radius + hulls[1].radius + margin {
            return;
        }
        let (poses, room) = ([&bodies[0], &bodies[1]], narrow_phase::HullPair::ANY_ROOM);
        let query = narrow_phase::HullPair { tables: &world.hulls, hulls: [pair.a, pair.b], poses, room };
        let mut cache = PairCache::default();
        let mut out = Manifold::default();
        let mut coded = Separation::default();
        if let Some(separation) = narrow.separation(&query, margin, &mut cache) {
            manifold(&query, &separation, margin, &mut out);
            let horizon = settings.substep() + settings.small_step();
            let bodies = world.pairs[pair.pair as usize];
            let velocities = bodies.map(|body| self.velocities[body as usize]);
            let is_static = |body: u32| world.bodies[body as usize].is_static();
            let falls = bodies.map(|body| if is_static(body) { 0.0 } else { horizon * settings.gravity });
            if passes(&query, &velocities, falls, horizon, &out) {
                self.passing += 1;
                out.count = 0;
            }
            coded.normal = separation.normal;
            coded.distance = separation.distance;
            coded.feature = bytemuck::cast(cache);
        }
        self.hull_pairs.push(pair);
        self.separations.push(coded);
        self.manifolds.push(out);
    }
}

/// So many candidates on the device, at two ages, and what the CPU says of them.
pub struct Touching {
    pub expected: [Vec<Expected>; 2],
    pub poses: Buffer<Pose>,
    pub separations: Buffer<Separation>,
    pub statuses: Buffer<u32>,
    pub body_boxes: Buffer<Bounds>,
    pub contacts: Contacts,
}

impl Touching {
    pub fn new(device: &Device, world: &World, candidates: u32) -> Result<Self, Failed> {
        let settings = SimSettings::default();
        let narrow = Separator::new(NarrowPhase::Twin, &world.hulls);
        let expected = [0, 1]
            .map(|age| (0..candidates).map(|c| Expected::new(world, &settings, &narrow, c, age)).collect::<Vec<_>>());
        let capacity = world.capacities.hull_pairs as usize;
        let rows = |age: usize| {
            let padded = expected[age].iter().flat_map(|e| {
                e.hull_pairs.iter().copied().chain(std::iter::repeat(HullPair::default())).take(capacity)
            });
            padded.collect::<Vec<_>>()
        };
        let starts = |age: usize| expected[age].iter().flat_map(|e| e.starts.iter().copied()).collect::<Vec<_>>();
        let batch = device.input(&[Batch::new(world, candidates)])?;
        let bodies = device.input(&world.bodies)?;
        let poses = device.poisoned(candidates as usize * world.bodies.len())?;
        let velocities: Vec<_> = expected[0].iter().flat_map(|e| e.velocities.iter().copied()).collect();
        let velocities = device.input(&velocities)?;
        let margins = expected[0].iter().flat_map(|e| &e.margins);
        let boxes: Vec<_> = margins.map(|margin| Bounds::new(Vec3::ZERO, Vec3::ZERO, *margin)).collect();
        let body_boxes = device.input(&boxes)?;
        let hull_pairs = [device.input(&rows(0))?, device.input(&rows(1))?];
        let pair_starts = [device.input(&starts(0))?, device.input(&starts(1))?];
        let separations = device.poisoned(candidates as usize * capacity)?;
        let statuses = device.input(&vec![0; candidates as usize])?;
        let tables = Tables::new(&device.gpu, world, &settings)?;
        let inputs = Inputs {
            batch: &batch,
            bodies: &bodies,
            poses: &poses,
            velocities: &velocities,
            body_boxes: &body_boxes,
            hull_pairs: hull_pairs.each_ref(),
            pair_starts: pair_starts.each_ref(),
            separations: &separations,
            statuses: &statuses,
        };
        let contacts = Contacts::new(&device.gpu, device.kernels()?, world, candidates, &tables, &inputs)?;
        device.poison(&contacts.facings);
        device.poison(&contacts.manifolds);
        device.poison(&contacts.manifold_points);
        device.poison(&contacts.merged);
        device.poison(&contacts.merged_points);
        for parity in 0..2 {
            device.poison(&contacts.patches[parity]);
            device.poison(&contacts.points[parity]);
            device.poison(&contacts.starts[parity]);
        }
        Ok(Self { expected, poses, separations, statuses, body_boxes, contacts })
    }

    /// Uploads which bodies keep the contacts between them, `[candidates][bodies]`.
    pub fn set_still(&self, device: &Device, still: &[bool]) -> Result<(), Failed> {
        let mut boxes = device.fetch(&self.body_boxes)?;
        boxes.iter_mut().zip(still).for_each(|(bounds, still)| bounds.is_still = u32::from(*still));
        self.body_boxes.upload(&device.gpu, &boxes);
        Ok(())
    }

    /// Uploads what a substep of this age reads.
    pub fn set_age(&self, device: &Device, world: &World, age: usize) {
        let capacity = world.capacities.hull_pairs as usize;
        let poses: Vec<Pose> = self.expected[age].iter().flat_map(|e| e.poses.iter().copied()).collect();
        self.poses.upload(&device.gpu, &poses);
        let padded = self.expected[age]
            .iter()
            .flat_map(|e| e.separations.iter().copied().chain(std::iter::repeat(Separation::default())).take(capacity));
        self.separations.upload(&device.gpu, &padded.collect::<Vec<_>>());
    }
}
