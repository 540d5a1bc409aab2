//! Which processor draws.

use super::{Failure, probe, say};
use clap::ValueEnum;
use rest3d_gpu::cpu::CpuPainter;
use rest3d_gpu::gpu::{AdapterChoice, AdapterReport, GpuError, GpuPainter};
use rest3d_gpu::render::{Painter, RenderError};

/// The options that choose it.
#[derive(Debug, clap::Args)]
pub struct PainterArgs {
    /// Processor that draws
    #[arg(long, value_enum, default_value_t = Choice::Auto)]
    backend: Choice,
    /// Graphics adapter: its number in `adapters`, a kind such as `discrete`, or a part of its name
    #[arg(long, value_name = "NAME")]
    adapter: Option<AdapterChoice>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Choice {
    /// The best graphics adapter, or the CPU where there is none
    Auto,
    Gpu,
    Cpu,
}

impl PainterArgs {
    /// Opens the painter.
    pub fn open(&self) -> Result<Box<dyn Painter>, Failure> {
        match (self.backend, &self.adapter) {
            (Choice::Cpu, Some(_)) => Err(Failure::Input(
                "--adapter names a graphics adapter, but --backend cpu uses none; leave one of them out".into(),
            )),
            (Choice::Cpu, None) => Ok(Box::new(CpuPainter)),
            (Choice::Auto, None) => Ok(best()),
            (_, choice) => match GpuPainter::open(choice.as_ref().unwrap_or(&AdapterChoice::Auto)) {
                Ok(painter) => Ok(Box::new(painter)),
                Err(error @ (GpuError::NoAdapter(_) | GpuError::Unfit { .. })) => {
                    Err(Failure::Input(format!("{error}; or draw on the processor with --backend cpu")))
                }
                Err(error) => Err(Failure::Other(error.to_string())),
            },
        }
    }
}

/// The best adapter, else the processor and why. Drivers are asked in a process of their own, because some crash.
fn best() -> Box<dyn Painter> {
    let fit = probe::list().and_then(|found| match found.iter().any(AdapterReport::is_fit) {
        true => Ok(()),
        false => Err("no adapter that is fit; `adapters` lists what there is".to_owned()),
    });
    match fit {
        Ok(()) => any(&AdapterChoice::Auto),
        Err(reason) => {
            say(format_args!("drawn by the cpu: {reason}"));
            Box::new(CpuPainter)
        }
    }
}

/// The adapter if it can be had, else the CPU, which draws the same more slowly.
pub fn any(choice: &AdapterChoice) -> Box<dyn Painter> {
    match GpuPainter::open(choice) {
        Ok(painter) => Box::new(painter),
        Err(error) => {
            say(format_args!("drawn by the cpu, not by a graphics adapter: {error}"));
            Box::new(CpuPainter)
        }
    }
}

impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Input(message) => Self::Input(message),
            RenderError::Failed(message) => Self::Other(message),
        }
    }
}
