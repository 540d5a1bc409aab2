//! Kernel `boxes`.

use super::Test;
use super::crowd::{crowd, scattered, speeds};
use super::fixture::{Device, SIZES, Value, compare, noise};
use glam::{Quat, Vec3};
use libtest_mimic::Failed;
use rest3d_gpu::cpu::broad_phase::{self, BroadPhase};
use rest3d_gpu::gpu::kernels::BoxesBuffers;
use rest3d_gpu::gpu::{Batch, Bounds, Buffer, Mark, Sim};
use rest3d_gpu::world::constants::RECYCLING_DISTANCE;
use rest3d_gpu::world::{Pose, SimSettings, Velocity, World};

pub const TESTS: &[Test] =
    &[("boxes::is_its_twin", is_its_twin), ("boxes::knows_what_hardly_moved", knows_what_hardly_moved)];

/// m: rotated points within a few metres of the origin.
const TOLERANCE: f32 = 2e-6;

impl Value for Bounds {
    fn distance(&self, other: &Self) -> f32 {
        let scale = other.half_extents.abs().max_element().max(1.0);
        self.center.distance(other.center)
            + self.margin.distance(&other.margin)
            + self.half_extents.distance(other.half_extents) / scale
            + if self.is_still == other.is_still { 0.0 } else { f32::NAN }
    }
    fn spoil(&mut self, by: f32) {
        self.half_extents.y += by * self.half_extents.y.abs().max(1.0);
    }
}

impl Value for Mark {
    fn distance(&self, other: &Self) -> f32 {
        (self.rotation - other.rotation).length()
            + self.translation.distance(other.translation)
            + self.margin.distance(&other.margin)
    }
    fn spoil(&mut self, by: f32) {
        self.margin += by;
    }
}

/// Boxes of hulls and of bodies of all candidates.
pub fn boxes(
    world: &World,
    poses: &[Pose],
    velocities: &[Velocity],
    offset: f32,
    dt: f32,
) -> (Vec<Bounds>, Vec<Bounds>) {
    let (mut hulls, mut bodies) = (Vec::new(), Vec::new());
    let mut broad = BroadPhase::default();
    let n = world.bodies.len();
    for (poses, velocities) in poses.chunks_exact(n).zip(velocities.chunks_exact(n)) {
        broad.forget();
        broad.update(world, poses, velocities, offset, dt);
        for (body, (bounds, &margin)) in broad.bodies.iter().zip(&broad.margins).enumerate() {
            bodies.push(Bounds::new(bounds.center, bounds.half, margin));
            hulls.extend(broad.hulls[world.hulls_of(body)].iter().map(|b| Bounds::new(b.center, b.half, margin)));
        }
    }
    (hulls, bodies)
}

/// What the device makes of a batch.
struct Found {
    hull_boxes: Buffer<Bounds>,
    body_boxes: Buffer<Bounds>,
    marks: Buffer<Mark>,
}

impl Found {
    fn new(
        device: &Device,
        world: &World,
        sim: &Sim,
        (poses, velocities): (&[Pose], &[Velocity]),
        marks: &[Mark],
    ) -> Result<Self, Failed> {
        let candidates = (poses.len() / world.bodies.len()) as u32;
        let batch = device.input(&[Batch::new(world, candidates)])?;
        let sim = device.input(&[*sim])?;
        let bodies = device.input(&world.bodies)?;
        let hulls = device.input(&world.hulls.hulls)?;
        let velocities = device.input(velocities)?;
        let hull_boxes = device.poisoned(candidates as usize * world.hulls.hulls.len())?;
        let body_boxes = device.poisoned(poses.len())?;
        let marks = device.input(marks)?;
        let rows = poses.len() as u32;
        let poses = device.input(poses)?;
        let buffers = BoxesBuffers {
            batch: batch.uniform(),
            sim: sim.uniform(),
            bodies: bodies.read(),
            hulls: hulls.read(),
            poses: poses.read(),
            velocities: velocities.read(),
            hull_boxes: hull_boxes.write(),
            body_boxes: body_boxes.write(),
            marks: marks.write(),
        };
        device.run(&buffers.step(&device.gpu, device.kernels()?, rows));
        Ok(Self { hull_boxes, body_boxes, marks })
    }
}

fn is_its_twin(device: &Device) -> Result<(), Failed> {
    let world = crowd();
    let settings = SimSettings::default();
    let moving = Sim::new(&settings, world.capacities);
    let still = Sim { contact_offset: 0.0, substep: 0.0, ..moving };
    for candidates in SIZES {
        let poses = scattered(&world, candidates, 0);
        let velocities = speeds(&world, candidates);
        for sim in [moving, still] {
            let expected = boxes(&world, &poses, &velocities, sim.contact_offset, sim.substep);
            let bodies = expected.1.len();
            let found = Found::new(device, &world, &sim, (&poses, &velocities), &vec![Mark::default(); bodies])?;
            device.expect(&format!("{candidates}, hulls"), &found.hull_boxes, &expected.0, TOLERANCE)?;
            device.expect(&format!("{candidates}, bodies"), &found.body_boxes, &expected.1, TOLERANCE)?;
        }
    }
    Ok(())
}

/// Bodies that moved by up to twice the distance that counts, turned by as much, or look farther than before.
fn knows_what_hardly_moved(device: &Device) -> Result<(), Failed> {
    let world = crowd();
    let sim = Sim::new(&SimSettings::default(), world.capacities);
    let n = world.bodies.len();
    for candidates in SIZES {
        let before = scattered(&world, candidates, 0);
        let noise = noise(77, 8 * before.len());
        let bodies = world.bodies.iter().cycle();
        let moved = before.iter().zip(bodies).zip(noise.chunks_exact(8)).enumerate().map(|(i, ((pose, body), x))| {
            let far = 2.0 * RECYCLING_DISTANCE;
            let (shift, turn) = match i % 3 {
                0 => (far * Vec3::new(x[0], x[1], x[2]), Vec3::ZERO),
                1 => (Vec3::ZERO, far / body.radius.max(0.01) * Vec3::new(x[0], x[1], x[2])),
                _ => (Vec3::ZERO, Vec3::ZERO),
            };
            let pose = Pose::new(Quat::from_scaled_axis(turn) * pose.rotation, pose.translation + shift);
            let speed = if i % 3 == 2 { far / sim.substep } else { 0.0 };
            (pose, Velocity::new(speed * Vec3::new(x[3], x[4], x[5]), Vec3::ZERO))
        });
        let (poses, velocities): (Vec<_>, Vec<_>) = moved.unzip();
        let at_rest = vec![Velocity::default(); before.len()];
        let coded = |mark: &broad_phase::Mark| Mark {
            rotation: mark.pose.rotation,
            translation: mark.pose.translation,
            margin: mark.margin,
        };
        let (mut marks, mut expected, mut still) = (Vec::new(), Vec::new(), Vec::new());
        for candidate in 0..candidates as usize {
            let row = candidate * n..(candidate + 1) * n;
            let mut broad = BroadPhase::default();
            broad.update(&world, &before[row.clone()], &at_rest[row.clone()], sim.contact_offset, sim.substep);
            marks.extend(broad.marks.iter().map(coded));
            broad.update(&world, &poses[row.clone()], &velocities[row], sim.contact_offset, sim.substep);
            expected.extend(broad.marks.iter().map(coded));
            still.extend(broad.still.iter().map(|&still| u32::from(still)));
        }
        if candidates > 1 && (!still.contains(&0) || !still.contains(&1)) {
            return Err("all or none moved".into());
        }
        let found = Found::new(device, &world, &sim, (&poses, &velocities), &marks)?;
        let flags: Vec<u32> = device.fetch(&found.body_boxes)?.iter().map(|bounds| bounds.is_still).collect();
        compare(&flags, &still, 0.0)?;
        device.expect(&format!("{candidates}, marks"), &found.marks, &expected, TOLERANCE)?;
    }
    Ok(())
}
