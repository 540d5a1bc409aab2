//! Both backends side by side: a substep on the device, stage by stage, and what the twin has made in each.

use super::fixture::Device;
use bytemuck::Pod;
use glam::Vec3;
use libtest_mimic::Failed;
use rayon::prelude::*;
use rest3d_gpu::cpu::clock::{Clock, Kernel};
use rest3d_gpu::cpu::contacts::{Contact, Patch};
use rest3d_gpu::cpu::narrow_phase::{Manifold, PairCache, Separation, Separator};
use rest3d_gpu::cpu::{Group, Workspace};
use rest3d_gpu::gpu::{Buffer, Recorder, Simulation, Step};
use rest3d_gpu::world::constants::MAX_MANIFOLD_POINTS;
use rest3d_gpu::world::{Pose, SimSettings, World};
use std::ops::Range;

/// Stages: kernels whose tables the processor has, too.
pub const STAGES: [(&str, Range<usize>); 8] = [
    ("boxes", 0..1),
    ("pair_counts pair_starts hull_pairs", 1..4),
    ("axis_remembered axis_faces axis_edges", 4..7),
    ("aligned_faces clip_faces single_points passing", 7..11),
    ("ground", 11..12),
    ("merge contact_starts emit", 12..15),
    // In the first substep, with kernels of its own.
    ("solve_bodies solve_load first_loads", 15..15),
    ("solve_bodies solve_load solve integrate", 15..usize::MAX),
];
pub const BOXES: usize = 0;
pub const LISTS: usize = 1;
pub const AXES: usize = 2;
pub const MANIFOLDS: usize = 3;
pub const GROUND: usize = 4;
pub const CONTACTS: usize = 5;
pub const LOADS: usize = 6;
pub const SOLVER: usize = 7;

#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Way {
    Lockstep,
    Free,
}

/// What the processor found for a hull pair: its remembered axis before and after, its axis, and its contacts.
type Found = (PairCache, Option<Separation>, PairCache, Manifold);

/// Everything that one candidate's twin has made in a substep.
#[derive(Default)]
struct Seen {
    pairs: Vec<Found>,
    ground: Vec<(usize, Manifold)>,
    patches: Vec<Patch>,
    points: Vec<Contact>,
}

impl Clock for Seen {
    fn lap(&mut self, _: Kernel) {}

    fn pair(&mut self, before: PairCache, found: Option<&Separation>, after: PairCache, manifold: &Manifold) {
        let manifold = if found.is_some() { *manifold } else { Manifold::default() };
        self.pairs.push((before, found.copied(), after, manifold));
    }

    fn ground(&mut self, hull: usize, manifold: &Manifold) {
        self.ground.push((hull, *manifold));
    }
}

/// One candidate on the processor.
struct Twin {
    group: Group,
    seen: Seen,
}

impl Twin {
    fn workspace(&self) -> &Workspace {
        &self.group.candidates()[0]
    }

    fn contacts(&self) -> (&Vec<Patch>, &Vec<Contact>) {
        let contacts = self.workspace().contacts();
        (&contacts.patches, &contacts.points)
    }
}

/// Where bits differed.
#[derive(Clone, Copy, Default, PartialEq)]
pub struct Tally {
    /// Candidates and substeps in which the stage's tables differed, of so many.
    pub parted: usize,
    pub compared: usize,
    /// Largest difference of two numbers.
    pub worst: f32,
}

/// A run of both.
pub struct Both<'a> {
    device: &'a Device,
    world: &'a World,
    simulation: Simulation,
    twins: Vec<Twin>,
    way: Way,
    pub tallies: [Tally; STAGES.len()],
    /// Candidates that have parted in this stage, and those that parted before.
    parted: Vec<bool>,
    gone: Vec<bool>,
}

impl<'a> Both<'a> {
    /// Ready for the first substep.
    pub fn new(
        device: &'a Device,
        world: &'a World,
        settings: &SimSettings,
        starts: &[Pose],
        way: Way,
    ) -> Result<Self, Failed> {
        let candidates = starts.len() / world.bodies.len();
        let simulation =
            Simulation::fitting(&device.gpu, device.kernels()?, world, settings, candidates as u32, device.gpu.room())?;
        if (simulation.candidates as usize) < candidates {
            return Err("the candidates do not fit at once".into());
        }
        simulation.state.poses.upload(&device.gpu, starts);
        let mut recorder = Recorder::new(&device.gpu);
        simulation.rest(&mut recorder);
        recorder.submit();
        let twin = |placed: &[Pose]| {
            let mut group = Group::new(world, 1);
            group.start(placed);
            Twin { group, seen: Seen::default() }
        };
        Ok(Self {
            device,
            world,
            simulation,
            twins: starts.chunks_exact(world.bodies.len()).map(twin).collect(),
            way,
            tallies: Default::default(),
            parted: vec![false; candidates],
            gone: vec![false; candidates],
        })
    }

    fn run(&self, steps: &[&Step]) {
        let mut recorder = Recorder::new(&self.device.gpu);
        recorder.run(steps.iter().copied());
        recorder.submit();
    }

    /// Compares a table of `STAGES[stage]`. `write` puts what the twin has into a candidate's row of it.
    fn table<T: Pod + Send + Sync>(
        &mut self,
        stage: usize,
        table: impl Fn(&Simulation) -> &Buffer<T>,
        write: impl Fn(&Twin, &mut [T]) + Sync,
    ) -> Result<(), Failed> {
        let found = self.device.fetch(table(&self.simulation))?;
        let mut expected = found.clone();
        let width = found.len() / self.twins.len();
        let rows = expected.par_chunks_exact_mut(width).zip(&self.twins);
        rows.for_each(|(row, twin)| write(twin, row));
        for (candidate, parted) in self.parted.iter_mut().enumerate() {
            let words = |all: &[T]| -> Vec<u32> {
                bytemuck::pod_collect_to_vec(&all[candidate * width..(candidate + 1) * width])
            };
            for (a, b) in words(&found).into_iter().zip(words(&expected)) {
                let [x, y] = [a, b].map(f32::from_bits);
                if a != b && x != y && !self.gone[candidate] {
                    *parted = true;
                    let off = (x - y).abs();
                    let worst = &mut self.tallies[stage].worst;
                    *worst = worst.max(if off.is_finite() { off } else { 0.0 });
                }
            }
        }
        if self.way == Way::Lockstep {
            table(&self.simulation).upload(&self.device.gpu, &expected);
        }
        Ok(())
    }

    fn stage_is_over(&mut self, stage: usize) {
        for (parted, gone) in self.parted.iter_mut().zip(&mut self.gone) {
            if !*gone {
                self.tallies[stage].compared += 1;
                self.tallies[stage].parted += usize::from(*parted);
                *gone = self.way == Way::Free && *parted;
            }
            *parted = false;
        }
    }

    pub fn substep(&mut self, settings: &SimSettings, narrow: &Separator, number: u32) -> Result<(), Failed> {
        let (world, parity) = (self.world, number as usize % 2);
        self.twins.par_iter_mut().for_each(|Twin { group, seen }| {
            *seen = Seen::default();
            group.collide_timed(world, settings, narrow, seen);
            let contacts = group.candidates()[0].contacts();
            (seen.patches, seen.points) = (contacts.patches.clone(), contacts.points.clone());
            if number == 0 {
                seen.patches.iter_mut().for_each(|patch| (patch.friction, patch.twist) = (Vec3::ZERO, 0.0));
                seen.points.iter_mut().for_each(|point| (point.impulse, point.load) = (0.0, 0.0));
            }
        });
        let slots = world.capacities.hull_pairs as usize;
        for (stage, (_, kernels)) in STAGES.into_iter().enumerate() {
            let steps: Vec<&Step> = self.simulation.kernels(parity).skip(kernels.start).take(kernels.len()).collect();
            self.run(&steps);
            match stage {
                BOXES => {
                    self.table(
                        stage,
                        |s| &s.collide.body_boxes,
                        |twin, row| {
                            let broad = twin.workspace().broad_phase();
                            for (body, (to, from)) in row.iter_mut().zip(&broad.bodies).enumerate() {
                                (to.center, to.half_extents) = (from.center, from.half);
                                (to.margin, to.is_still) = (broad.margins[body], u32::from(broad.still[body]));
                            }
                        },
                    )?;
                    self.table(
                        stage,
                        |s| &s.collide.hull_boxes,
                        |twin, row| {
                            for (to, from) in row.iter_mut().zip(&twin.workspace().broad_phase().hulls) {
                                (to.center, to.half_extents) = (from.center, from.half);
                            }
                        },
                    )?;
                    self.table(
                        stage,
                        |s| &s.collide.marks,
                        |twin, row| {
                            for (to, from) in row.iter_mut().zip(&twin.workspace().broad_phase().marks) {
                                (to.rotation, to.translation) = (from.pose.rotation, from.pose.translation);
                                to.margin = from.margin;
                            }
                        },
                    )?;
                }
                LISTS => {
                    self.table(
                        stage,
                        |s| &s.collide.pair_starts[parity],
                        |twin, row| {
                            let pairs = twin.workspace().pairs();
                            for (index, start) in row.iter_mut().enumerate() {
                                *start = pairs.partition_point(|pair| (pair.pair as usize) < index) as u32;
                            }
                        },
                    )?;
                    self.table(
                        stage,
                        |s| &s.collide.hull_pairs[parity],
                        |twin, row| {
                            for ((to, from), seen) in row.iter_mut().zip(twin.workspace().pairs()).zip(&twin.seen.pairs)
                            {
                                (to.pair, to.a, to.b, to.cache) = (from.pair, from.a, from.b, bytemuck::cast(seen.0));
                            }
                        },
                    )?;
                }
                AXES => {
                    self.table(
                        stage,
                        |s| &s.collide.separations,
                        |twin, row| {
                            for (to, (_, found, after, _)) in row.iter_mut().zip(&twin.seen.pairs) {
                                *to = Default::default();
                                if let Some(found) = found {
                                    (to.normal, to.distance) = (found.normal, found.distance);
                                    to.feature = bytemuck::cast(*after);
                                }
                            }
                        },
                    )?;
                    self.table(
                        stage,
                        |s| &s.collide.hull_pairs[parity],
                        |twin, row| {
                            for (to, (.., after, _)) in row.iter_mut().zip(&twin.seen.pairs) {
                                to.cache = bytemuck::cast(*after);
                            }
                        },
                    )?;
                }
                MANIFOLDS | GROUND => {
                    let of = |twin: &Twin| -> Vec<(usize, Manifold)> {
                        if stage == GROUND {
                            let still = &twin.workspace().broad_phase().still;
                            let fresh = (0..still.len()).filter(|body| !still[*body]);
                            let hulls = fresh.flat_map(|body| world.hulls_of(body));
                            let known = |hull| twin.seen.ground.iter().find(|(number, _)| *number == hull);
                            hulls.map(|h| (slots + h, known(h).map_or(Manifold::default(), |(_, m)| *m))).collect()
                        } else {
                            twin.seen.pairs.iter().map(|(.., manifold)| *manifold).enumerate().collect()
                        }
                    };
                    self.table(
                        stage,
                        |s| &s.contacts.manifolds,
                        |twin, row| {
                            for (slot, manifold) in of(twin) {
                                row[slot].count = manifold.count;
                                if manifold.count > 0 {
                                    row[slot].normal = manifold.normal;
                                }
                            }
                        },
                    )?;
                    self.table(
                        stage,
                        |s| &s.contacts.manifold_points,
                        |twin, row| {
                            for (slot, manifold) in of(twin) {
                                for (to, from) in row[slot * MAX_MANIFOLD_POINTS..].iter_mut().zip(manifold.points()) {
                                    (to.on_a, to.on_b, to.separation) = (from.on_a, from.on_b, from.separation);
                                }
                            }
                        },
                    )?;
                }
                CONTACTS => {
                    self.contacts(stage, parity, |twin| (&twin.seen.patches, &twin.seen.points))?;
                    self.table(
                        stage,
                        |s| &s.contacts.starts[parity],
                        |twin, row| {
                            for (entry, start) in row.iter_mut().enumerate() {
                                let patches = &twin.seen.patches;
                                let first = patches.partition_point(|patch| (patch.pair as usize) < entry);
                                let point =
                                    patches.get(first).map_or(twin.seen.points.len() as u32, |patch| patch.first);
                                *start = [first as u32, point];
                            }
                        },
                    )?;
                    self.table(
                        stage,
                        |s| &s.contacts.patch_counts[parity],
                        |twin, row| {
                            row[0] = twin.seen.patches.len() as u32;
                        },
                    )?;
                }
                LOADS if number > 0 => continue,
                LOADS => {
                    self.run(&self.simulation.load_kernels().iter().collect::<Vec<_>>());
                    self.contacts(stage, parity, Twin::contacts)?;
                }
                _ => {
                    self.twins.par_iter_mut().for_each(|twin| twin.group.solve(world, settings));
                    self.contacts(stage, parity, Twin::contacts)?;
                    self.table(stage, |s| &s.state.poses, |twin, row| row.copy_from_slice(&twin.workspace().poses))?;
                    self.table(
                        stage,
                        |s| &s.state.velocities,
                        |twin, row| {
                            row.copy_from_slice(&twin.workspace().velocities);
                        },
                    )?;
                }
            }
            self.stage_is_over(stage);
        }
        Ok(())
    }

    fn contacts(
        &mut self,
        stage: usize,
        parity: usize,
        of: impl Fn(&Twin) -> (&Vec<Patch>, &Vec<Contact>) + Sync,
    ) -> Result<(), Failed> {
        self.table(
            stage,
            |s| &s.contacts.patches[parity],
            |twin, row| {
                for (to, from) in row.iter_mut().zip(of(twin).0) {
                    (to.pair, to.a, to.b, to.first, to.count) = (from.pair, from.a, from.b, from.first, from.count);
                    (to.normal, to.friction, to.twist) = (from.normal, from.friction, from.twist);
                }
            },
        )?;
        self.table(
            stage,
            |s| &s.contacts.points[parity],
            |twin, row| {
                for (to, from) in row.iter_mut().zip(of(twin).1) {
                    (to.normal, to.point, to.separation) = (from.normal, from.point, from.separation);
                    ([to.anchor_a, to.anchor_b], to.found) = (from.anchors, from.found);
                    (to.impulse, to.load) = (from.impulse, from.load);
                }
            },
        )
    }
}
