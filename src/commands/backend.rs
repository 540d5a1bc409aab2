//! Which processor simulates.

use super::{Failure, say};
use clap::ValueEnum;
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::gpu::{AdapterChoice, AdapterKind, GpuBackend, GpuError, adapters};
use rest3d_gpu::world::Backend;
use std::num::NonZeroUsize;

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
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Choice {
    /// A graphics card if there is a fit one, else the CPU
    Auto,
    Gpu,
    Cpu,
}

impl BackendArgs {
    /// Opens the backend. `--threads` also holds for the making of shapes.
    pub fn open(&self) -> Result<Box<dyn Backend>, Failure> {
        if let Some(threads) = self.threads {
            // Fails only if the pool was already built, which nothing before this does.
            let _ = rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build_global();
        }
        match (self.backend, &self.adapter) {
            (Choice::Cpu, Some(_)) => Err(Failure::Input(
                "--adapter names a graphics adapter, but --backend cpu uses none; leave one of them out".into(),
            )),
            (Choice::Cpu, None) => Ok(Box::new(CpuBackend)),
            (Choice::Gpu, choice) => gpu(choice.as_ref().unwrap_or(&AdapterChoice::Auto)),
            (Choice::Auto, Some(choice)) => gpu(choice),
            (Choice::Auto, None) => Ok(best()),
        }
    }
}

/// The adapter that was asked for, or what to do about it.
fn gpu(choice: &AdapterChoice) -> Result<Box<dyn Backend>, Failure> {
    let backend = GpuBackend::open(choice).map_err(|error| match error {
        GpuError::NoAdapter(_) | GpuError::Unfit { .. } => {
            Failure::Input(format!("{error}; or simulate on the processor with --backend cpu"))
        }
        error => Failure::Other(error.to_string()),
    })?;
    say(format_args!("backend: {}", backend.describe()));
    Ok(Box::new(backend))
}

/// A graphics card if there is one that can, else the processor, which software adapters only emulate.
fn best() -> Box<dyn Backend> {
    let hardware = adapters().into_iter().filter(|adapter| adapter.kind != AdapterKind::Software && adapter.is_fit());
    let reason = match hardware.min_by_key(|adapter| (adapter.kind, adapter.index)) {
        None => "no fit graphics card".into(),
        Some(adapter) => match GpuBackend::open(&AdapterChoice::Index(adapter.index)) {
            Ok(backend) => {
                say(format_args!("backend: {}", backend.describe()));
                return Box::new(backend);
            }
            Err(error) => error.to_string(),
        },
    };
    say(format_args!("backend: {} ({reason})", CpuBackend.describe()));
    Box::new(CpuBackend)
}
