//! Which processor simulates, and which one goes on when it fails.

use super::{Failure, probe, say};
use clap::ValueEnum;
use rest3d_gpu::bench::Speed;
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::gpu::{AdapterChoice, AdapterKind, AdapterReport, GpuBackend, GpuError, Options};
use rest3d_gpu::world::{Backend, BackendError};
use std::env;

/// How many times fewer candidates are simulated at a time after a device failed.
const RETRY_SPLIT: u32 = 4;

/// A graphics card that takes up to so many times as long as the processor is taken, too.
const EVEN: f64 = 1.05;

/// Environment variables for tests: `auto` takes this kind of adapter, too; devices are lost after so many
/// iterations and winners that are asked for.
const AUTO_KIND: &str = "REST3D_GPU_AUTO";
const LOST_AFTER: &str = "REST3D_GPU_LOST_AFTER";

/// The options that choose it.
#[derive(Debug, clap::Args)]
pub struct BackendArgs {
    /// Processor that simulates
    #[arg(long, value_enum, default_value_t = Choice::Auto)]
    backend: Choice,
    /// Graphics adapter: its number in `adapters`, a kind such as `discrete`, or a part of its name
    #[arg(long, value_name = "NAME")]
    adapter: Option<AdapterChoice>,
    /// CPU threads [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: Option<u32>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Choice {
    /// A graphics card that passes a short test and is faster, else the CPU
    Auto,
    Gpu,
    Cpu,
}

/// A backend, and what may follow it.
pub struct Opened {
    /// To begin with.
    pub backend: Box<dyn Backend>,
    /// What follows when its device fails or holds too little.
    pub spares: Spares,
    /// The graphics adapter that it simulates on, if it is one.
    pub adapter: Option<AdapterChoice>,
}

/// What is still to be tried, in this order.
#[derive(Debug, Default)]
pub struct Spares {
    /// The same adapter with less at a time.
    again: Option<Options>,
    cpu: bool,
}

impl Spares {
    /// The backend to go on with after one failed so; none if there is none. Fewer candidates at a time do not help
    /// where too little room for one of them, or for all, was the failure.
    pub fn next(&mut self, failure: &BackendError) -> Option<Box<dyn Backend>> {
        let again = self.again.take();
        if let Some(options) = again.filter(|_| matches!(failure, BackendError::Device(_))) {
            match GpuBackend::open_with(&options) {
                Ok(backend) => {
                    say(format_args!("{failure}: trying again with {RETRY_SPLIT} times fewer candidates at a time"));
                    return Some(Box::new(backend));
                }
                Err(error) => say(format_args!("the graphics device cannot be opened again: {error}")),
            }
        }
        if !std::mem::take(&mut self.cpu) {
            return None;
        }
        say(format_args!("{failure}: going on from the last finished group on {}", CpuBackend.describe()));
        Some(Box::new(CpuBackend))
    }
}

impl BackendArgs {
    /// Opens the backend for so many candidates at a time. `--threads` also holds for the making of shapes.
    pub fn open(&self, candidates: u32) -> Result<Opened, Failure> {
        // 0: as many as there are cores.
        let threads = self.threads.unwrap_or(0) as usize;
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().map_err(|error| {
            Failure::Other(format!("the threads cannot be started ({error}); take fewer with --threads"))
        })?;
        match (self.backend, &self.adapter) {
            (Choice::Cpu, Some(_)) => Err(Failure::Input(
                "--adapter names a graphics adapter, but --backend cpu uses none; leave one of them out".into(),
            )),
            (Choice::Cpu, None) => Ok(cpu()),
            (Choice::Gpu, choice) => wanted(choice.as_ref().unwrap_or(&AdapterChoice::Auto)),
            (Choice::Auto, Some(choice)) => wanted(choice),
            (Choice::Auto, None) => Ok(best(candidates, rayon::current_num_threads())),
        }
    }
}

fn cpu() -> Opened {
    Opened { backend: Box::new(CpuBackend), spares: Spares::default(), adapter: None }
}

fn gpu(choice: &AdapterChoice) -> Result<Opened, GpuError> {
    let lost_after = env::var(LOST_AFTER).ok().and_then(|text| text.parse().ok());
    let options = Options { adapter: choice.clone(), cache: probe::cache(), split: 1, submission: None, lost_after };
    let backend = GpuBackend::open_with(&options)?;
    say(format_args!("backend: {}", backend.describe()));
    let adapter = AdapterChoice::Index(backend.report().index);
    let again = Some(Options { adapter: adapter.clone(), split: RETRY_SPLIT, ..options });
    Ok(Opened { backend: Box::new(backend), spares: Spares { again, cpu: true }, adapter: Some(adapter) })
}

/// The adapter that was asked for, or what to do about it.
fn wanted(choice: &AdapterChoice) -> Result<Opened, Failure> {
    gpu(choice).map_err(|error| match error {
        GpuError::NoAdapter(_) | GpuError::Unfit { .. } => {
            Failure::Input(format!("{error}; or simulate on the processor with --backend cpu"))
        }
        error => Failure::Other(error.to_string()),
    })
}

/// The best graphics card that can be trusted, if it is faster than so many threads with about so many candidates at a
/// time; else the processor and why.
fn best(candidates: u32, threads: usize) -> Opened {
    let opened = card().and_then(|adapter| {
        let name = &adapter.name;
        let speeds = probe::test(&adapter, threads).map_err(|problem| format!("{name}: {problem}"))?;
        match Speed::of(&speeds, candidates) {
            Some(speed) if speed.processor > EVEN * speed.card => Err(format!(
                "{name} takes {:.1} times as long as {threads} threads with {} candidates at a time; --backend gpu takes it all \
                 the same",
                speed.processor / speed.card,
                speed.candidates
            )),
            _ => gpu(&AdapterChoice::Index(adapter.index)).map_err(|error| error.to_string()),
        }
    });
    opened.unwrap_or_else(|reason| {
        say(format_args!("backend: {} ({reason})", CpuBackend.describe()));
        cpu()
    })
}

/// The best hardware adapter, or why there is none. A software adapter is slower than the CPU backend.
fn card() -> Result<AdapterReport, String> {
    let found = probe::list()?;
    let extra: Option<AdapterKind> = match env::var(AUTO_KIND).unwrap_or_default().parse() {
        Ok(AdapterChoice::Kind(kind)) => Some(kind),
        _ => None,
    };
    let usual = [AdapterKind::Discrete, AdapterKind::Integrated, AdapterKind::Virtual];
    let is_card = |adapter: &&AdapterReport| usual.contains(&adapter.kind) || Some(adapter.kind) == extra;
    let best = found.iter().filter(is_card).min_by_key(|adapter| (!adapter.is_fit(), adapter.kind, adapter.index));
    match best {
        None if found.is_empty() => Err("no graphics adapter; `adapters` says what to install".into()),
        None => Err("no graphics card; `adapters` lists what there is".into()),
        Some(adapter) if !adapter.is_fit() => Err(format!("{} lacks {}", adapter.name, adapter.missing.join("; "))),
        Some(adapter) => Ok(adapter.clone()),
    }
}
