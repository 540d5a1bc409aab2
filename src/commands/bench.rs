//! `bench`: how fast a scene is simulated, and how well.

use super::backend::BackendArgs;
use super::{Failure, output, print_result, progress, say, scenes, shapes};
use rest3d_gpu::bench::{Effort, Measurement, Point, Quantity, Subject, measure, plan};
use rest3d_gpu::files::write_whole;
use rest3d_gpu::report::{Chart, aligned, svg};
use rest3d_gpu::world::{Backend, BackendError, SimSettings};
use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::path::{Path, PathBuf};
use std::slice;

/// What is measured when nothing is named, from the project's folder.
const SHIPPED_SCENE: &str = "scenes/study";

/// Measure how fast a scene is simulated
///
/// Every movable object starts with noise of 5 cm (5 mm in height), a second is simulated in 60 steps of 2 substeps.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene.json, a folder that holds one, or a REST3D stage2 folder
    #[arg(default_value = SHIPPED_SCENE)]
    scene: PathBuf,
    /// Candidates simulated together; the most of a sweep [default: 512, in a sweep 16384]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..))]
    candidates: Option<u32>,
    /// Repeat every run until so many seconds are measured, at least once
    #[arg(long, value_name = "S", default_value_t = 2.0, value_parser = parse_seconds)]
    seconds: f64,
    /// Seed of the noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Vary the number of candidates, bodies and hulls, and draw the curves into FILE
    #[arg(long)]
    sweep: bool,
    /// With --sweep: file for the curves, an SVG [default: bench.svg]
    #[arg(short, long = "output", value_name = "FILE", requires = "sweep")]
    output: Option<PathBuf>,
    #[command(flatten)]
    backend: BackendArgs,
    /// Put the result on stdout as one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs it.
pub fn run(args: &Args) -> Result<(), Failure> {
    if args.scene == Path::new(SHIPPED_SCENE) && !args.scene.exists() {
        return Err(Failure::Input(format!(
            "{SHIPPED_SCENE}: not found; name a scene, or call from the project's folder, where the default scene is"
        )));
    }
    let candidates = args.candidates.unwrap_or(if args.sweep { 16384 } else { 512 });
    let backend = args.backend.open(candidates)?.backend;
    let scene = scenes::read(&args.scene)?;
    let file = args.output.clone().unwrap_or_else(|| "bench.svg".into());
    if args.sweep {
        output::check_places(slice::from_ref(&file), output::parent(&file))?;
        output::refuse_to_overwrite(&scene, slice::from_ref(&file))?;
        output::check_writable(output::parent(&file))?;
    }
    let subject = Subject::new(&scene, &shapes::make(&scene, false)?);
    let effort = Effort { candidates, seed: args.seed, seconds: args.seconds };
    if !args.sweep {
        let measured = measure(backend.as_ref(), &subject.world(), &SimSettings::default(), effort, &mut told)?;
        return print_result(args.json, &measured, &Single(&measured));
    }
    let sweep = sweep(backend.as_ref(), plan(&subject, effort))?;
    let heading = format!("{}: {}", scene.name, backend.describe());
    write_whole(&file, svg(&heading, &sweep.charts()).as_bytes()).map_err(|error| Failure::writing(&file, error))?;
    say(format_args!("curves: {}", file.display()));
    print_result(args.json, &sweep, &sweep)
}

/// From 0 up; an hour is enough.
fn parse_seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.0..=3600.0).contains(seconds));
    seconds.ok_or_else(|| "a number of seconds from 0 to 3600 is needed".into())
}

fn told(seconds: f64) {
    say(format_args!("run: {seconds:.2} s"));
}

/// Measures all points. Where more candidates do not fit, the curve ends.
fn sweep(backend: &dyn Backend, points: Vec<Point>) -> Result<Sweep, Failure> {
    let mut sweep = Sweep::default();
    let bar = progress::bar(points.len() as u64, progress::SHORT);
    for Point { quantity, world, effort } in points {
        let curve = match quantity {
            Quantity::Candidates => &mut sweep.candidates,
            Quantity::Bodies => &mut sweep.bodies,
            Quantity::Hulls => &mut sweep.hulls,
        };
        let hulls = world.hulls.hulls.len();
        let what = format!("{} candidates, {} bodies, {hulls} hulls", effort.candidates, world.units.len());
        bar.set_message(what.clone());
        match measure(backend, &world, &SimSettings::default(), effort, &mut |_| ()) {
            Ok(measured) => {
                bar.suspend(|| say(format_args!("{what}: {} candidates/s", number(measured.candidates_per_s))));
                curve.push(measured);
            }
            Err(BackendError::Capacity(message)) if !curve.is_empty() => {
                bar.suspend(|| say(format_args!("{what}: left out: {message}")));
            }
            Err(error) => return Err(error.into()),
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(sweep)
}

/// The measurements, by what varies.
#[derive(Debug, Default, Serialize)]
struct Sweep {
    candidates: Vec<Measurement>,
    bodies: Vec<Measurement>,
    hulls: Vec<Measurement>,
}

impl Sweep {
    fn charts(&self) -> [Chart; 3] {
        let chart = |curve: &[Measurement], x: &str, size: fn(&Measurement) -> f64| Chart {
            title: format!("speed over {x}"),
            x: x.into(),
            y: "candidates/s".into(),
            points: curve.iter().map(|m| (size(m), m.candidates_per_s)).collect(),
        };
        [
            chart(&self.candidates, "candidates", |m| m.candidates.into()),
            chart(&self.bodies, "bodies", |m| m.bodies as f64),
            chart(&self.hulls, "hulls", |m| m.hulls as f64),
        ]
    }
}

impl Display for Sweep {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let header = |varied: &str| -> Vec<String> {
            let labels = FIELDS.iter().skip(2).map(|(label, _)| (*label).to_owned());
            [format!("varied: {varied}")].into_iter().chain(labels).collect()
        };
        let mut rows = Vec::new();
        for (varied, curve) in [("candidates", &self.candidates), ("bodies", &self.bodies), ("hulls", &self.hulls)] {
            rows.push(header(varied));
            for measured in curve {
                let cells = FIELDS.iter().skip(2).map(|(_, value)| value(measured));
                rows.push([String::new()].into_iter().chain(cells).collect());
            }
        }
        write!(f, "{}", aligned(&rows))
    }
}

/// One measurement, a line a number.
struct Single<'a>(&'a Measurement);

impl Display for Single<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let line = |label: &str, value: String| vec![label.to_owned(), value];
        let mut rows: Vec<Vec<String>> = FIELDS.iter().map(|(label, value)| line(label, value(self.0))).collect();
        for kernel in &self.0.kernels_ms {
            rows.push(line(&format!("ms in {}", kernel.name), number(kernel.milliseconds)));
        }
        write!(f, "{}", aligned(&rows))
    }
}

/// A column of the table: what stands above it, and a cell.
type Field = (&'static str, fn(&Measurement) -> String);

/// All but the kernels, of which every backend has its own.
const FIELDS: [Field; 12] = [
    ("backend", |m| m.backend.clone()),
    ("adapter", |m| m.adapter.clone()),
    ("candidates", |m| m.candidates.to_string()),
    ("bodies", |m| m.bodies.to_string()),
    ("hulls", |m| m.hulls.to_string()),
    ("contacts/substep", |m| m.contacts_per_substep.map_or("-".into(), number)),
    ("candidates/s", |m| number(m.candidates_per_s)),
    ("env-substeps/s", |m| number(m.env_substeps_per_s)),
    ("body-substeps/s", |m| number(m.body_substeps_per_s)),
    ("bytes resident", |m| m.bytes_resident.to_string()),
    ("mean drift, mm", |m| m.mean_drift_m.map_or("-".into(), |drift| number(1e3 * drift))),
    ("flagged", |m| m.flagged_candidates.to_string()),
];

/// Three digits are more than a measurement of time has.
fn number(value: f64) -> String {
    let decimals = if value < 1.0 { 3 } else { usize::from(value < 1000.0) };
    format!("{value:.decimals$}")
}
