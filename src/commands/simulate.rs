//! `simulate`: one forward simulation of a scene as it stands.

use super::backend::BackendArgs;
use super::{Failure, output, print_result, say, shapes};
use rest3d_gpu::files::write_whole_with;
use rest3d_gpu::optimize::Rig;
use rest3d_gpu::report::Trajectory;
use rest3d_gpu::scene::Scene;
use rest3d_gpu::world::{Flow, Pose, STATIC, SimSettings, Status, World};
use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;
use std::slice;

/// Simulate a scene as it stands and write all poses and velocities as JSON
///
/// Poses are those of the objects, in the frame and unit of SCENE; velocities are those of their centres of mass.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene.json, a folder that holds one, or a REST3D stage2 folder
    scene: PathBuf,
    /// Steps of 1/60 s
    #[arg(long, value_name = "L", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
    /// Collision detections per step
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=256))]
    substeps: u32,
    /// File for the result [default: stdout]
    #[arg(short, long = "output", value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    backend: BackendArgs,
    /// With -o: put a summary on stdout as one JSON object. Without -o, stdout is JSON anyway
    #[arg(long)]
    json: bool,
}

/// Runs it.
pub fn run(args: &Args) -> Result<(), Failure> {
    let backend = args.backend.open()?;
    let scene = Scene::read(&args.scene)?;
    for warning in &scene.warnings {
        say(format_args!("warning: {warning}"));
    }
    if let Some(file) = &args.output {
        output::check_places(slice::from_ref(file), output::parent(file))?;
        output::refuse_to_overwrite(&scene, slice::from_ref(file))?;
        output::check_writable(output::parent(file))?;
    }
    let shapes = shapes::make(&scene)?;
    let rigs: Vec<Rig> = shapes.iter().map(Rig::new).collect();
    let settings = SimSettings { steps: args.steps, substeps: args.substeps, ..SimSettings::default() };
    let too_long = || Failure::Input(format!("--steps {}: the states do not fit into memory; take fewer", args.steps));
    let mut trajectory = Trajectory::new(&scene, &rigs, settings.dt.into(), args.steps).ok_or_else(too_long)?;

    let start = trajectory.start();
    let world = world(&scene, &rigs, &start);
    let status = backend.simulate(&world, &settings, &start, &mut |_, poses, velocities| {
        trajectory.push(poses, velocities);
        Flow::Continue
    })?;
    report_status(&status)?;

    let Some(file) = &args.output else {
        let mut out = BufWriter::new(io::stdout().lock());
        let written = serde_json::to_writer(&mut out, &trajectory).map_err(io::Error::from);
        return written
            .and_then(|()| writeln!(out))
            .and_then(|()| out.flush())
            .map_err(|error| Failure::Other(format!("stdout: cannot be written: {error}")));
    };
    write_whole_with(file, |out| serde_json::to_writer(out, &trajectory).map_err(Into::into))
        .map_err(|error| Failure::writing(file, error))?;
    let summary = Summary {
        objects: scene.objects.len(),
        simulated: world.units.len(),
        steps: args.steps,
        dt: settings.dt.into(),
        max_moved: trajectory.distances().into_iter().fold(0.0, f64::max),
    };
    print_result(args.json, &summary, &summary)
}

/// Every movable object is a unit of its own.
fn world(scene: &Scene, rigs: &[Rig], start: &[Pose]) -> World {
    let mut roots = Vec::new();
    let mut defs = Vec::with_capacity(rigs.len());
    for (i, (rig, &pose)) in rigs.iter().zip(start).enumerate() {
        let unit = if scene.is_static(i) {
            STATIC
        } else {
            roots.push(i as u32);
            roots.len() as u32 - 1
        };
        defs.push(rig.def(unit, pose, pose));
    }
    World::new(&defs, &roots)
}

/// A result with holes is none; a narrow phase that gave up somewhere is worth a line.
fn report_status(status: &[Status]) -> Result<(), Failure> {
    let named = |status: &Status| -> Vec<&str> {
        Status::NAMES.iter().filter(|(bit, _)| status.intersects(*bit)).map(|(_, name)| *name).collect()
    };
    for status in status.iter().filter(|status| **status != Status::default()) {
        let what = named(status).join(", ");
        if !status.is_usable() {
            return Err(Failure::Other(format!("the simulation failed: {what}")));
        }
        say(format_args!("warning: {what}"));
    }
    Ok(())
}

/// What is said when the trajectory itself goes to a file.
#[derive(Debug, Serialize)]
struct Summary {
    objects: usize,
    simulated: usize,
    steps: u32,
    dt: f64,
    /// Largest distance of a centre of mass from its start, m.
    max_moved: f64,
}

impl Display for Summary {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "objects simulated  {} of {}", self.simulated, self.objects)?;
        writeln!(f, "time               {} steps, {:.2} s", self.steps, f64::from(self.steps) * self.dt)?;
        write!(f, "moved              {:.1} mm at most", 1e3 * self.max_moved)
    }
}
