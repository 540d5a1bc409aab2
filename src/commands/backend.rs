//! Which processor simulates.

use super::{Failure, say};
use clap::ValueEnum;
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::world::Backend;

/// The options that choose it.
#[derive(Debug, clap::Args)]
pub struct BackendArgs {
    /// Processor that simulates
    #[arg(long, value_enum, default_value_t = Choice::Auto)]
    backend: Choice,
    /// Graphics adapter, a part of its name (GPU backend only)
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// CPU threads [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: Option<u32>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Choice {
    /// The best that is there
    Auto,
    Gpu,
    Cpu,
}

impl BackendArgs {
    /// Opens the backend. `--threads` also holds for the making of shapes.
    pub fn open(&self) -> Result<Box<dyn Backend>, Failure> {
        if matches!(self.backend, Choice::Gpu) {
            return Err(Failure::Input("--backend gpu: this build has no GPU backend yet; use --backend cpu".into()));
        }
        if self.adapter.is_some() {
            return Err(Failure::Input(
                "--adapter names a graphics adapter, but this build has no GPU backend yet; leave it out".into(),
            ));
        }
        // 0: as many as there are cores.
        let threads = self.threads.unwrap_or(0) as usize;
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().map_err(|error| {
            Failure::Other(format!("the threads cannot be started ({error}); take fewer with --threads"))
        })?;
        let backend = CpuBackend;
        if matches!(self.backend, Choice::Auto) {
            say(format_args!("backend: {} (this build has no GPU backend yet)", backend.describe()));
        }
        Ok(Box::new(backend))
    }
}
