//! `ablate`: the paper's ablation tables over a list of scenes.

use super::backend::BackendArgs;
use super::{Failure, config, interrupt, output, print_result, progress, say, scenes, shapes};
use clap::ValueEnum;
use indicatif::ProgressBar;
use rest3d_gpu::ablate::{self, Ended, Row, Run, Stage, Store, Subject, Table};
use rest3d_gpu::canonicalize::canonicalize;
use rest3d_gpu::optimize::Config;
use rest3d_gpu::report::{Ablation, AblationRow, AblationTable};
use rest3d_gpu::scene::Scene;
use rest3d_gpu::world::Backend;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Rerun the paper's ablation tables
///
/// Every scene is canonicalized and goes through every variant of the method. Leaves ablation.json and ablation.md, and
/// every finished run in DIR/runs: the same command goes on where it was ended.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Reconstructions, each a scene.json, a folder that holds one, or a REST3D stage2 folder
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Folder for the tables and the finished runs
    #[arg(short, long = "output", value_name = "DIR")]
    output: PathBuf,
    /// True layout to measure the distance from. One for all scenes, or one for each in their order
    #[arg(long, value_name = "SCENE")]
    reference: Vec<PathBuf>,
    /// Which tables
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [TableName::Structure, TableName::Energy, TableName::Elites])]
    tables: Vec<TableName>,
    /// Configuration that the variants change: a TOML file, or one of default, quick, paper
    #[arg(long, value_name = "FILE", default_value = "default")]
    config: String,
    /// Candidates per iteration, in place of the configuration's
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..))]
    candidates: Option<u32>,
    /// Iterations per episode, in place of the configuration's
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u32).range(1..))]
    iterations: Option<u32>,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    backend: BackendArgs,
    /// Put the result on stdout as one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum TableName {
    /// Canonicalization, scene tree, global-only, projection
    Structure,
    /// Energy terms
    Energy,
    /// Elite fraction
    Elites,
}

impl From<TableName> for Table {
    fn from(name: TableName) -> Self {
        match name {
            TableName::Structure => Self::Structure,
            TableName::Energy => Self::Energy,
            TableName::Elites => Self::Elites,
        }
    }
}

/// Runs it.
pub fn run(args: &Args) -> Result<(), Failure> {
    let references = scenes::references(&args.reference, args.scenes.len())?;
    let config = config::load(&args.config, args.candidates, args.iterations)?;
    let files = ["ablation.json", "ablation.md"].map(|name| args.output.join(name));
    output::check_places(&files, &args.output.join("runs"))?;
    output::check_writable(&args.output)?;
    let backend = args.backend.open(config.candidates())?.backend;
    let subjects: Result<Vec<Subject>, Failure> = (args.scenes.iter().enumerate())
        .zip(&references)
        .map(|((i, path), reference)| {
            say(format_args!("scene {}/{}: {}", i + 1, args.scenes.len(), path.display()));
            subject(path, *reference, &files)
        })
        .collect();
    let subjects = subjects?;
    let described = describe(args);
    say(format_args!("configuration: {described} (the paper's whole budget is --config paper, and takes hours)"));

    let tables: Vec<Table> = args.tables.iter().map(|&name| name.into()).collect();
    let program = format!("{} {}", program()?, backend.arithmetic());
    let bench = Bench { subjects: &subjects, config: &config, seed: args.seed, backend: backend.as_ref(), program };
    let finished = bench.run_all(&tables, &Store::new(&args.output.join("runs")))?;
    let document = Ablation::new(
        described,
        args.seed,
        backend.describe(),
        subjects.iter().map(|subject| subject.name.clone()).collect(),
        tables.iter().map(|&table| bench.table(table, &finished)).collect(),
    );
    let mut json = serde_json::to_vec_pretty(&document)
        .map_err(|error| Failure::Other(format!("ablation.json: cannot be written as JSON: {error}")))?;
    json.push(b'\n');
    let contents = [("ablation.md".into(), document.markdown().into_bytes()), ("ablation.json".into(), json)];
    output::write_all(&args.output, &contents)?;
    print_result(args.json, &document, &document)?;
    say(format_args!("result: {}", args.output.display()));
    Ok(())
}

/// A hash of this program: a change of the simulator or the search makes other results of the same scene.
fn program() -> Result<String, Failure> {
    let bytes = std::env::current_exe().and_then(std::fs::read);
    let bytes = bytes.map_err(|error| Failure::Other(format!("the program's own file cannot be read: {error}")))?;
    Ok(blake3::hash(&bytes).to_hex().to_string())
}

fn describe(args: &Args) -> String {
    let changed = [("candidates", args.candidates), ("iterations", args.iterations)];
    let changed = changed.iter().filter_map(|(name, value)| value.map(|value| format!(" with {value} {name}")));
    args.config.clone() + &changed.collect::<String>()
}

/// Reads a scene and makes it canonical.
fn subject(path: &Path, reference: Option<&Path>, outputs: &[PathBuf]) -> Result<Subject, Failure> {
    let read = |path: &Path| -> Result<_, Failure> {
        let scene = scenes::read(path)?;
        output::refuse_to_overwrite(&scene, outputs)?;
        let meshes = shapes::meshes(&scene)?;
        Ok((scene, meshes))
    };
    let (scene, meshes) = read(path)?;
    if (0..scene.objects.len()).all(|i| scene.is_static(i)) {
        let problem = "nothing in it can move, so there is nothing to compare; leave it out";
        return Err(Failure::Input(format!("{}: {problem}", path.display())));
    }
    let mut canonical = scene.clone();
    canonicalize(&mut canonical, &meshes);
    let stage = |scene: Scene| Ok::<_, Failure>(Stage { shapes: shapes::make(&scene, true)?, scene });
    Ok(Subject {
        name: scene.name.clone(),
        raw: stage(scene)?,
        canonical: stage(canonical)?,
        meshes,
        reference: reference.map(read).transpose()?,
    })
}

/// Finished runs by identity.
type Finished = BTreeMap<String, Run>;

/// What is the same for all runs.
struct Bench<'a> {
    subjects: &'a [Subject],
    config: &'a Config,
    seed: u64,
    backend: &'a dyn Backend,
    /// What `ablate::identity` knows it by.
    program: String,
}

impl Bench<'_> {
    fn identity(&self, subject: &Subject, row: &Row) -> String {
        ablate::identity(subject, row.variant, self.config, self.seed, &self.program)
    }

    /// Carries out what the store does not have, scene by scene, and keeps it there.
    fn run_all(&self, tables: &[Table], store: &Store) -> Result<Finished, Failure> {
        let mut finished = Finished::new();
        let mut open: Vec<(String, &Subject, Row)> = Vec::new();
        for subject in self.subjects {
            for row in tables.iter().flat_map(|table| table.rows()) {
                let identity = self.identity(subject, &row);
                match store.load(&identity) {
                    Some(run) => _ = finished.insert(identity, run),
                    None if open.iter().any(|(other, ..)| *other == identity) => {}
                    None => open.push((identity, subject, row)),
                }
            }
        }
        say(format_args!("runs: {} to do, {} done before", open.len(), finished.len()));
        let stop = interrupt::watch()?;
        let count = open.len();
        let bar = progress::bar(count as u64, progress::SHORT);
        let mut watch = interrupt::Watch::new(&stop, |_| ());
        let clock = Instant::now();
        for (done, (identity, subject, row)) in open.into_iter().enumerate() {
            bar.set_position(done as u64);
            let heading = format!("{}/{count} {}, {}", done + 1, subject.name, row.label);
            bar.set_message(heading.clone());
            let ended = ablate::run(subject, row.variant, self.config, self.seed, self.backend, &mut watch)?;
            let Some((ended, seconds)) = ended.filter(|_| !stop.load(Ordering::Relaxed)) else {
                bar.finish_and_clear();
                return Err(Failure::Other(format!(
                    "stopped: {} runs are kept; the same command goes on from there",
                    finished.len()
                )));
            };
            let left = clock.elapsed().mul_f64((count - done - 1) as f64 / (done + 1) as f64);
            tell(&bar, &heading, &ended, seconds, left);
            let run = Run { scene: subject.name.clone(), variant: row.label.into(), seconds, ended };
            store.keep(&identity, &run).map_err(|error| Failure::writing(&store.path(&identity), error))?;
            finished.insert(identity, run);
        }
        bar.finish_and_clear();
        Ok(finished)
    }

    fn table(&self, table: Table, finished: &Finished) -> AblationTable {
        let rows = table.rows().into_iter().map(|row| {
            let runs = self.subjects.iter().filter_map(|subject| finished.get(&self.identity(subject, &row)).cloned());
            AblationRow::new(&row, runs.collect())
        });
        AblationTable::new(table, rows.collect())
    }
}

/// A line about a run that has ended, above the bar if there is one.
fn tell(bar: &ProgressBar, heading: &str, ended: &Ended, seconds: f64, left: Duration) {
    let ended = match ended {
        Ended::Result(measured) => {
            format!("stable {:.0} %, drift {:.1} mm", measured.stable_rate_pct, 1e3 * measured.drift_m)
        }
        Ended::Failure(why) => format!("failed: {why}"),
    };
    let left = left.as_secs();
    let line = format!("{heading}: {ended}; {seconds:.1} s, about {}:{:02} left", left / 60, left % 60);
    bar.suspend(|| say(format_args!("{line}")));
}
