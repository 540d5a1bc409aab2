//! Which processor simulates.

use super::{Failure, say};
use clap::ValueEnum;
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::gpu::{AdapterChoice, GpuBackend, GpuError};
use rest3d_gpu::world::Backend;

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
    /// The CPU, until the GPU backend is proven on graphics cards
    Auto,
    Gpu,
    Cpu,
}

impl BackendArgs {
    /// Opens the backend. `--threads` also holds for the making of shapes.
    pub fn open(&self) -> Result<Box<dyn Backend>, Failure> {
        // 0: as many as there are cores.
        let threads = self.threads.unwrap_or(0) as usize;
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().map_err(|error| {
            Failure::Other(format!("the threads cannot be started ({error}); take fewer with --threads"))
        })?;
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

/// The processor. The GPU backend has been run on a software adapter only, so it is not yet chosen unasked.
fn best() -> Box<dyn Backend> {
    say(format_args!("backend: {} (--backend gpu is there to be tried)", CpuBackend.describe()));
    Box::new(CpuBackend)
}
