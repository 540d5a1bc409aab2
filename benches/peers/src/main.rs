//! The same candidates in Rapier and in our CPU backend: speed and drift side by side.
//!
//! Hulls, masses, inertias, start poses, time step and material are the same. Rapier runs with its own defaults for
//! solving (four iterations, contact clustering and recycling), which are its fastest; bodies do not fall asleep,
//! because ours do not, and continuous collision detection is off. Candidates run in parallel on all cores in both. A
//! thread keeps its pipeline and the shapes; bodies are copied from a template for each candidate.
#![allow(clippy::print_stdout)]

use rapier3d::prelude as rapier;
use rayon::prelude::*;
use rest3d_gpu::bench::{Subject, mean_drift, median, starts};
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::report::aligned;
use rest3d_gpu::shape::convex_hull;
use rest3d_gpu::world::{Backend, Pose, Rollouts, STATIC, SimSettings, Status, World};
use std::time::Instant;

#[path = "../../common/mod.rs"]
mod common;

/// Candidates of a run, and runs of each engine, in turn, so that other work on the machine meets all of them.
const CANDIDATES: u32 = 256;
const RUNS: usize = 5;

fn main() {
    
    let subject = common::subject(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let world = subject.world();
    let settings = SimSettings::default();
    let starts = starts(&world, CANDIDATES, 0);
    let [compound, separate] = [true, false].map(|compound| Template::new(&subject, &settings, compound));
    let engines: [(&str, &dyn Fn() -> Rollouts); 3] = [
        ("rest3d-gpu", &|| CpuBackend.rollouts(&world, &settings, &starts).expect("rollouts")),
        ("Rapier, a collider a body", &|| compound.rollouts(&world, &settings, &starts)),
        ("Rapier, a collider a hull", &|| separate.rollouts(&world, &settings, &starts)),
    ];
    let mut seconds = vec![Vec::new(); engines.len()];
    let mut drifts = vec![None; engines.len()];
    for run in 0..=RUNS {
        for (i, (_, engine)) in engines.iter().enumerate() {
            let clock = Instant::now();
            let rollouts = engine();
            // The first run warms up.
            if run > 0 {
                seconds[i].push(clock.elapsed().as_secs_f64());
            }
            drifts[i] = mean_drift(&world, &starts, &rollouts);
        }
    }
    let speeds: Vec<f64> = seconds.iter_mut().map(|seconds| f64::from(CANDIDATES) / median(seconds)).collect();
    let mut rows = vec![["", "candidates/s", "to ours", "mean drift, mm"].map(String::from).to_vec()];
    for (i, (name, _)) in engines.iter().enumerate() {
        let drift = drifts[i].map_or("-".into(), |drift| format!("{:.1}", 1e3 * drift));
        rows.push(vec![(*name).into(), format!("{:.1}", speeds[i]), format!("{:.2}", speeds[i] / speeds[0]), drift]);
    }
    let (steps, substeps) = (settings.steps, settings.substeps);
    println!("{CANDIDATES} candidates, {steps} steps of {substeps}, {} threads", rayon::current_num_threads());
    println!("{}", aligned(&rows));
}

/// Everything of Rapier that is the same for all candidates.
struct Template {
    parameters: rapier::IntegrationParameters,
    gravity: rapier::Vector,
    bodies: rapier::RigidBodySet,
    colliders: rapier::ColliderSet,
    /// In the order of the world's bodies.
    handles: Vec<rapier::RigidBodyHandle>,
}

impl Template {
    fn new(subject: &Subject, settings: &SimSettings, compound: bool) -> Self {
        let dt = settings.dt / settings.substeps as f32;
        let parameters = rapier::IntegrationParameters { dt, max_ccd_substeps: 0, ..Default::default() };
        let (mut bodies, mut colliders) = (rapier::RigidBodySet::new(), rapier::ColliderSet::new());
        let surface = |shape| rapier::ColliderBuilder::new(shape).density(0.0).friction(settings.friction);
        let ground = bodies.insert(rapier::RigidBodyBuilder::fixed());
        colliders.insert_with_parent(surface(rapier::SharedShape::halfspace(rapier::Vector::Y)), ground, &mut bodies);
        let mut handles = Vec::new();
        for def in &subject.bodies {
            let mass = rapier::MassProperties::new(rapier::Vector::ZERO, def.mass, def.inertia);
            let body = match def.unit {
                STATIC => rapier::RigidBodyBuilder::fixed(),
                _ => rapier::RigidBodyBuilder::dynamic().additional_mass_properties(mass),
            };
            let body = body
                .pose(pose_of(&def.start))
                .linear_damping(settings.linear_damping)
                .angular_damping(settings.angular_damping)
                .can_sleep(false);
            let handle = bodies.insert(body);
            let hulls = def.parts.iter().filter_map(|part| {
                let (vertices, triangles) = convex_hull(part)?;
                rapier::SharedShape::convex_mesh(vertices, &triangles)
            });
            let shapes = if compound {
                let placed = hulls.map(|hull| (rapier::Pose::IDENTITY, hull)).collect();
                vec![rapier::SharedShape::compound(placed)]
            } else {
                hulls.collect()
            };
            for shape in shapes {
                colliders.insert_with_parent(surface(shape), handle, &mut bodies);
            }
            handles.push(handle);
        }
        Self { parameters, gravity: rapier::Vector::Y * settings.gravity, bodies, colliders, handles }
    }

    fn rollouts(&self, world: &World, settings: &SimSettings, starts: &[Pose]) -> Rollouts {
        let mut settled = starts.to_vec();
        settled.par_chunks_exact_mut(world.bodies.len()).for_each_init(
            rapier::PhysicsPipeline::new,
            |pipeline, poses| {
                self.simulate(settings, pipeline, poses);
            },
        );
        let finite = |poses: &[Pose]| poses.iter().all(Pose::is_finite);
        let status = |poses| if finite(poses) { Status::default() } else { Status::NOT_FINITE };
        let statuses = settled.chunks_exact(world.bodies.len()).map(status).collect();
        Rollouts { settled, statuses, contacts_per_substep: None }
    }

    /// One candidate from `poses` to its end.
    fn simulate(&self, settings: &SimSettings, pipeline: &mut rapier::PhysicsPipeline, poses: &mut [Pose]) {
        let (mut bodies, mut colliders) = (self.bodies.clone(), self.colliders.clone());
        for (&handle, pose) in self.handles.iter().zip(poses.iter()) {
            bodies[handle].set_position(pose_of(pose), true);
        }
        let mut islands = rapier::IslandManager::new();
        let mut broad_phase = rapier::DefaultBroadPhase::default();
        let mut narrow_phase = rapier::NarrowPhase::new();
        let mut joints = (rapier::ImpulseJointSet::new(), rapier::MultibodyJointSet::new());
        let (mut soft_bodies, mut ccd) = (rapier::SoftBodySet::new(), rapier::CCDSolver::new());
        for _ in 0..settings.steps * settings.substeps {
            pipeline.step(
                self.gravity,
                &self.parameters,
                &mut islands,
                &mut broad_phase,
                &mut narrow_phase,
                &mut bodies,
                &mut colliders,
                &mut joints.0,
                &mut joints.1,
                &mut soft_bodies,
                &mut ccd,
                &(),
                &(),
            );
        }
        for (&handle, pose) in self.handles.iter().zip(poses) {
            let end = bodies[handle].position();
            *pose = Pose::new(end.rotation, end.translation);
        }
    }
}

fn pose_of(pose: &Pose) -> rapier::Pose {
    rapier::Pose::from_parts(pose.translation, pose.rotation)
}
