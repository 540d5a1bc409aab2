//! `simulate`: one forward simulation of a scene as it stands.

use super::backend::BackendArgs;
use super::{Failure, canonicalize, output, print_result, progress, replay, say, scenes, shapes};
use rest3d_gpu::files::write_whole_with;
use rest3d_gpu::optimize::{Candidate, Rig, standing};
use rest3d_gpu::report::Trajectory;
use rest3d_gpu::scene::Scene;
use rest3d_gpu::world::{Flow, Pose, SimSettings, Status, Velocity, World};
use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;
use std::slice;
use std::time::Instant;

/// Simulate a scene as it stands and write all poses and velocities as JSON
///
/// Poses are those of the objects, in the frame and unit of SCENE; velocities are those of their centres of mass.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene.json, a folder that holds one, or a REST3D stage2 folder
    scene: PathBuf,
    /// Steps of 1/60 s [default: 60, or as the replayed run]
    #[arg(long, value_name = "L", value_parser = clap::value_parser!(u32).range(1..))]
    steps: Option<u32>,
    /// Collision detections per step [default: 2, or as the replayed run]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    substeps: Option<u32>,
    /// Simulate a candidate of a finished run instead: its stage, iteration and index, counted from 0
    #[arg(long, value_name = "STAGE,ITERATION,INDEX", requires = "run", value_parser = parse_candidate, allow_hyphen_values = true)]
    replay: Option<Candidate>,
    /// The folder that `optimize SCENE` left: its report tells seed and configuration
    #[arg(long, value_name = "DIR", requires = "replay")]
    run: Option<PathBuf>,
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
    let backend = args.backend.open(1)?.backend;
    let mut scene = scenes::read(&args.scene)?;
    if let Some(file) = &args.output {
        output::check_places(slice::from_ref(file), output::parent(file))?;
        output::refuse_to_overwrite(&scene, slice::from_ref(file))?;
        output::check_writable(output::parent(file))?;
    }
    let finished = args.run.as_deref().map(replay::Finished::read).transpose()?;
    if let Some(finished) = &finished {
        finished.check(&scene)?;
        if finished.was_canonicalized() {
            canonicalize::apply(&mut scene)?;
        }
    }
    let shapes = shapes::make(&scene, args.replay.is_some())?;
    let rigs: Vec<Rig> = shapes.iter().map(Rig::new).collect();
    let motion = match (&args.replay, &finished) {
        (Some(candidate), Some(run)) => replay::motion(&mut scene, &shapes, &rigs, backend.as_ref(), *candidate, run)?,
        _ => Motion::of_scene(&scene, &rigs),
    };
    let steps = args.steps.unwrap_or(motion.settings.steps);
    let substeps = args.substeps.unwrap_or(motion.settings.substeps);
    let settings = SimSettings { steps, substeps, ..motion.settings };
    let too_long = || Failure::Input(format!("--steps {steps}: the states do not fit into memory; take fewer"));
    let mut trajectory = Trajectory::new(&scene, &rigs, settings.dt.into(), steps).ok_or_else(too_long)?;
    let (mut poses, mut velocities) = (trajectory.start(), vec![Velocity::default(); rigs.len()]);
    let (bar, clock) = (progress::bar(steps.into(), progress::SHORT), Instant::now());
    let status = backend.simulate(&motion.world, &settings, &motion.placed, &mut |step, now, speeds| {
        let done = u64::from(step) + 1;
        bar.set_position(done);
        let left = progress::time_left(clock.elapsed(), done, u64::from(steps).saturating_sub(done));
        bar.set_message(format!("step {done} of {steps}, {left} left"));
        for ((&object, pose), speed) in motion.objects.iter().zip(now).zip(speeds) {
            poses[object] = pose.raised(-motion.lift);
            velocities[object] = *speed;
        }
        trajectory.push(&poses, &velocities);
        Flow::Continue
    })?;
    bar.finish_and_clear();
    report_status(&status)?;

    let Some(file) = &args.output else {
        let mut out = BufWriter::new(io::stdout().lock());
        let written = serde_json::to_writer(&mut out, &trajectory).map_err(io::Error::from);
        return written
            .and_then(|()| writeln!(out))
            .and_then(|()| out.flush())
            .map_err(|error| Failure::Other(format!("stdout: cannot be written: {error}")));
    };
    write_whole_with(file, |out| {
        serde_json::to_writer(&mut *out, &trajectory)?;
        writeln!(out)
    })
    .map_err(|error| Failure::writing(file, error))?;
    let summary = Summary {
        objects: scene.objects.len(),
        simulated: motion.world.bodies.iter().filter(|body| !body.is_static()).count(),
        steps,
        dt: settings.dt.into(),
        max_moved: trajectory.distances().into_iter().fold(0.0, f64::max),
    };
    print_result(args.json, &summary, &summary)
}

/// What is simulated: some of the scene's objects, from where.
pub struct Motion {
    pub world: World,
    /// Object of each body; the bodies after them are walls.
    pub objects: Vec<usize>,
    /// Pose of every body at the start.
    pub placed: Vec<Pose>,
    /// How far the bodies are above the objects that they stand for, m.
    pub lift: f32,
    pub settings: SimSettings,
}

impl Motion {
    /// The scene as it stands.
    fn of_scene(scene: &Scene, rigs: &[Rig]) -> Self {
        let world = standing(scene, rigs);
        let placed = world.start.clone();
        if !scene.room.walls.is_empty() {
            say(format_args!("note: walls are not simulated; an object that is not movable can stand for one"));
        }
        Self { world, objects: (0..rigs.len()).collect(), placed, lift: 0.0, settings: SimSettings::default() }
    }
}

/// `2,14,93`.
fn parse_candidate(text: &str) -> Result<Candidate, String> {
    let numbers: Vec<u32> = text.split(',').map_while(|number| number.trim().parse().ok()).collect();
    match numbers[..] {
        [stage, iteration, index] if text.split(',').count() == 3 => {
            Ok(Candidate { stage: stage as usize, iteration, index })
        }
        _ => Err("three numbers are needed, such as 2,14,93; `groups` in report.json names each stage's winner".into()),
    }
}

/// A result with holes is none.
fn report_status(status: &[Status]) -> Result<(), Failure> {
    let Some(status) = status.iter().find(|status| !status.is_usable()) else { return Ok(()) };
    let faults = Status::FAULTS.iter().filter(|fault| status.intersects(fault.bit));
    let what: Vec<String> = faults.map(|fault| format!("{}; {}", fault.name, fault.remedy)).collect();
    Err(Failure::Other(format!("the simulation failed: {}", what.join("; "))))
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
