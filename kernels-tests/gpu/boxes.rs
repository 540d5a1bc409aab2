//! Kernel `boxes`.

use super::Test;
use super::crowd::{crowd, scattered, speeds};
use super::fixture::{Device, SIZES, Value};
use libtest_mimic::Failed;
use rest3d_gpu::cpu::broad_phase::BroadPhase;
use rest3d_gpu::gpu::kernels::BoxesBuffers;
use rest3d_gpu::gpu::{Batch, Bounds, Sim};
use rest3d_gpu::world::{Pose, SimSettings, Velocity, World};

pub const TESTS: &[Test] = &[("boxes::is_its_twin", is_its_twin)];

/// m: rotated points within a few metres of the origin.
const TOLERANCE: f32 = 2e-6;

impl Value for Bounds {
    fn distance(&self, other: &Self) -> f32 {
        let scale = other.half_extents.abs().max_element().max(1.0);
        self.center.distance(other.center)
            + self.margin.distance(&other.margin)
            + self.half_extents.distance(other.half_extents) / scale
    }
    fn spoil(&mut self, by: f32) {
        self.half_extents.y += by * self.half_extents.y.abs().max(1.0);
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
        broad.update(world, poses, velocities, offset, dt);
        for (body, (bounds, &margin)) in broad.bodies.iter().zip(&broad.margins).enumerate() {
            bodies.push(Bounds::new(bounds.center, bounds.half, margin));
            hulls.extend(broad.hulls[world.hulls_of(body)].iter().map(|b| Bounds::new(b.center, b.half, margin)));
        }
    }
    (hulls, bodies)
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
            let batch = device.input(&[Batch::new(&world, candidates)])?;
            let sim = device.input(&[sim])?;
            let bodies = device.input(&world.bodies)?;
            let hulls = device.input(&world.hulls.hulls)?;
            let poses = device.input(&poses)?;
            let velocities = device.input(&velocities)?;
            let hull_boxes = device.poisoned(expected.0.len())?;
            let body_boxes = device.poisoned(expected.1.len())?;
            let buffers = BoxesBuffers {
                batch: batch.uniform(),
                sim: sim.uniform(),
                bodies: bodies.read(),
                hulls: hulls.read(),
                poses: poses.read(),
                velocities: velocities.read(),
                hull_boxes: hull_boxes.write(),
                body_boxes: body_boxes.write(),
            };
            device.run(&buffers.step(&device.gpu, device.kernels()?, expected.1.len() as u32));
            device.expect(&format!("{candidates}, hulls"), &hull_boxes, &expected.0, TOLERANCE)?;
            device.expect(&format!("{candidates}, bodies"), &body_boxes, &expected.1, TOLERANCE)?;
        }
    }
    Ok(())
}
