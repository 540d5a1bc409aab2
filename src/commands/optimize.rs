//! `optimize`: from a broken layout to one that stands.

use super::backend::{BackendArgs, Opened};
use super::progress::SearchProgress;
use super::{Failure, canonicalize, config, interrupt, output, pictures, print_result, say, scenes, shapes};
use rest3d_gpu::canonicalize::Canonicalization;
use rest3d_gpu::files::write_whole;
use rest3d_gpu::optimize::{self, Checkpoint, OptimizeError, Outcome};
use rest3d_gpu::report::{Report, Run, energy_csv, html, part_files};
use rest3d_gpu::scene::Scene;
use rest3d_gpu::shape::Shape;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What a run leaves beside the parts, as far as it could be made.
const FILES: [&str; 6] = ["scene.json", "report.json", "report.html", "before.png", "after.png", "energy.csv"];

/// Find a layout near the scene's in which everything stands
///
/// Leaves scene.json, parts/, report.json, report.html, before.png, after.png and energy.csv in DIR. Ctrl-C keeps the
/// best layout so far; --resume goes on.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene.json, a folder that holds one, or a REST3D stage2 folder
    scene: PathBuf,
    /// Folder for the result [default: out/<scene name>]
    #[arg(short, long = "output", value_name = "DIR")]
    output: Option<PathBuf>,
    /// Configuration: a TOML file, or one of default, quick, paper
    #[arg(long, value_name = "FILE", default_value = "default")]
    config: String,
    #[command(flatten)]
    backend: BackendArgs,
    /// Seed of all random numbers: same seed, same machine, same result
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Candidates simulated per iteration, in place of the configuration's; as many times more are drawn as its `draws`
    /// say
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..))]
    candidates: Option<u32>,
    /// Iterations per episode, in place of the configuration's
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u32).range(1..))]
    iterations: Option<u32>,
    /// Turn the scene upright and set its objects onto their supports first, as `canonicalize` does
    #[arg(long)]
    canonicalize: bool,
    /// Go on from the checkpoint that an interrupted run left in DIR
    #[arg(long)]
    resume: bool,
    /// Draw no before.png and after.png
    #[arg(long)]
    no_pictures: bool,
    /// Put the report on stdout as one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs it.
pub fn run(args: &Args) -> Result<(), Failure> {
    let config = config::load(&args.config, args.candidates, args.iterations)?;
    let Opened { backend, mut spares, adapter } = args.backend.open(config.candidates())?;
    let mut scene = scenes::read(&args.scene)?;
    let dir = args.output.clone().unwrap_or_else(|| Path::new("out").join(output::folder_name(&scene.name)));
    let checkpoint = dir.join("checkpoint.json");
    let mut places: Vec<PathBuf> = FILES.iter().map(|name| dir.join(name)).chain([checkpoint.clone()]).collect();
    output::check_places(&places, &dir.join("parts"))?;
    places.push(dir.join("parts"));
    output::refuse_to_overwrite(&scene, &places)?;
    output::check_writable(&dir)?;
    let resume = if args.resume { read_checkpoint(&checkpoint)? } else { None };
    if !args.resume && checkpoint.exists() {
        say(format_args!(
            "note: {}: a run that was stopped could go on with --resume; this one replaces it",
            checkpoint.display()
        ));
    }
    let canonicalization = canonical(&mut scene, args.canonicalize)?;
    let clock = Instant::now();
    let shapes = shapes::make(&scene, true)?;
    let shape_seconds = clock.elapsed().as_secs_f64();

    let stop = interrupt::watch()?;
    let mut progress = SearchProgress::new();
    let mut watch = interrupt::Watch::new(&stop, |event| {
        progress.show(event);
        if let Some(state) = event.checkpoint() {
            write_checkpoint(&checkpoint, state, &progress);
        }
    });
    let mut next = |failure: &_| spares.next(failure);
    let outcome = optimize::run_on(&scene, &shapes, backend, &mut next, &config, args.seed, resume, &mut watch);
    progress.finish();
    let (outcome, backend) = outcome.map_err(|error| match error {
        OptimizeError::Checkpoint(_) => Failure::Input(format!("{}: {error}", checkpoint.display())),
        error => error.into(),
    })?;
    if let Some(lost) = outcome.objects.iter().position(|object| !object.pose.is_finite()) {
        let name = &scene.objects[lost].name;
        return Err(Failure::Other(format!("object \"{name}\": it has no pose in the result; nothing was written")));
    }
    for note in &outcome.notes {
        say(format_args!("note: {note}"));
    }

    let (input, processor) = (args.scene.display().to_string(), backend.describe());
    let canonicalization = canonicalization.as_ref();
    let described = Run { input: &input, backend: &processor, seed: args.seed, shape_seconds, canonicalization };
    let report = Report::new(described, &scene, &shapes, &config, &outcome);
    say(format_args!("{}", report.summary().exact()));
    let after = scene.with_poses(outcome.objects.iter().map(|object| object.pose));
    let files = files(after.clone(), &shapes, &outcome, &report, &dir)?;
    let earlier = output::earlier_files(&dir);
    output::write_all(&dir, &files)?;
    output::remove_stale(&dir, &earlier, &files);
    if outcome.finished {
        remove_checkpoint(&checkpoint);
    }
    // The result is safe now, whatever becomes of its pictures.
    let pictures = if args.no_pictures { None } else { pictures::before_and_after(&scene, &after, adapter.as_ref()) };
    output::write_all(&dir, &to_look_at(&report, pictures))?;
    print_result(args.json, &report, report.summary())?;
    if !outcome.finished {
        return Err(Failure::Other(format!(
            "stopped before the end: {} holds the best layout so far; the same command with --resume goes on",
            dir.display()
        )));
    }
    say(format_args!("result: {}", dir.display()));
    Ok(())
}

/// Makes the scene canonical if that is wanted, and otherwise tells what it would be good for.
fn canonical(scene: &mut Scene, wanted: bool) -> Result<Option<Canonicalization>, Failure> {
    if wanted {
        let report = canonicalize::apply(scene)?;
        say(format_args!("canonicalization:\n{report}"));
        return Ok(Some(report));
    }
    if let Some(warning) = canonicalize::apply(&mut scene.clone())?.warning() {
        say(format_args!("warning: {warning}; --canonicalize turns it upright onto the ground first"));
    }
    Ok(None)
}

/// The files of the result that are for programs, as paths inside `dir`; `scene.json` refers to the others and so comes
/// last.
fn files(
    mut scene: Scene,
    shapes: &[Shape],
    outcome: &Outcome,
    report: &Report<'_>,
    dir: &Path,
) -> Result<Vec<(PathBuf, Vec<u8>)>, Failure> {
    let mut report = serde_json::to_vec_pretty(report)
        .map_err(|error| Failure::Other(format!("report.json: cannot be written as JSON: {error}")))?;
    report.push(b'\n');
    let parts = part_files(&scene, &outcome.parts);
    for ((object, parts), shape) in scene.objects.iter_mut().zip(&parts).zip(shapes) {
        object.convex_parts = parts.iter().map(|(name, _)| dir.join(name)).collect();
        object.mass.get_or_insert(shape.mass.mass.into());
    }
    let mut files: Vec<(PathBuf, Vec<u8>)> = parts.into_iter().flatten().collect();
    files.push(("energy.csv".into(), energy_csv(outcome).into_bytes()));
    files.push(("report.json".into(), report));
    files.push(("scene.json".into(), scene.to_json(dir).into_bytes()));
    Ok(files)
}

/// The files of the result that are for people.
fn to_look_at(report: &Report<'_>, pictures: Option<[Vec<u8>; 2]>) -> Vec<(PathBuf, Vec<u8>)> {
    let page = html(report, pictures.as_ref().map(|pictures| pictures.each_ref().map(Vec::as_slice)));
    let pictures = pictures.into_iter().flat_map(|pictures| ["before.png", "after.png"].into_iter().zip(pictures));
    let mut files: Vec<(PathBuf, Vec<u8>)> = pictures.map(|(name, bytes)| (name.into(), bytes)).collect();
    files.push(("report.html".into(), page.into_bytes()));
    files
}

fn read_checkpoint(path: &Path) -> Result<Option<Checkpoint>, Failure> {
    match fs::read_to_string(path) {
        Ok(text) => Checkpoint::from_json(&text)
            .map(Some)
            .map_err(|error| Failure::Input(format!("{}: {error}", path.display()))),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            say(format_args!("{}: no checkpoint: starting from the beginning", path.display()));
            Ok(None)
        }
        Err(error) => Err(Failure::Input(format!("{}: cannot be read: {error}", path.display()))),
    }
}

/// A checkpoint that cannot be written costs the run nothing.
fn write_checkpoint(path: &Path, checkpoint: &Checkpoint, progress: &SearchProgress) {
    if let Err(error) = write_whole(path, checkpoint.to_json().as_bytes()) {
        progress.line(&format!("warning: {}: cannot be written: {error}; --resume will not find it", path.display()));
    }
}

/// A checkpoint that stays does no harm: another run refuses it.
fn remove_checkpoint(path: &Path) {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => {
            say(format_args!("warning: {}: cannot be removed: {error}", path.display()));
        }
        _ => {}
    }
}
