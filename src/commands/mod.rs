//! The subcommands, one thin file each, and what they share: choosing a backend, loading a configuration, making the
//! shapes, showing progress. Only this module prints: messages and progress to stderr, the result to stdout.

mod ablate;
mod adapters;
mod backend;
mod bench;
mod canonicalize;
mod config;
mod evaluate;
mod interrupt;
mod optimize;
mod output;
mod painter;
mod pictures;
mod probe;
mod progress;
mod render;
mod replay;
mod scenes;
mod shapes;
mod simulate;

use clap::{Arg, CommandFactory, FromArgMatches, Parser, Subcommand};
use rest3d_gpu::{optimize::OptimizeError, scene::SceneError, world::BackendError};
use serde::Serialize;
use std::fmt::{Arguments, Display};
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

/// Turns a reconstructed 3D scene into one that stands still in a physics engine.
///
/// SCENE is a scene.json, a folder that holds one, or a REST3D stage2 folder. Exit codes: 0 done, 2 bad usage or bad
/// input (nothing written), 1 any other failure.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Optimize(optimize::Args),
    Simulate(simulate::Args),
    Evaluate(evaluate::Args),
    Ablate(ablate::Args),
    Bench(bench::Args),
    Canonicalize(canonicalize::Args),
    Render(render::Args),
    Adapters(adapters::Args),
    #[command(hide = true)]
    Probe(probe::Args),
}

impl Cli {
    /// What was asked for on the command line; ends the program where that makes no sense.
    pub fn read() -> Self {
        // A negative number is told what it may be, not taken for an unknown option.
        let numbers = |arg: Arg| match arg.get_action().takes_values() {
            true => arg.allow_negative_numbers(true),
            false => arg,
        };
        let matches = Self::command().mut_subcommands(|command| command.mut_args(numbers)).get_matches();
        Self::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
    }

    /// Runs the command that was asked for.
    ///
    /// # Errors
    /// What kept it from its result.
    pub fn run(&self) -> Result<(), Failure> {
        match &self.command {
            Command::Optimize(args) => optimize::run(args),
            Command::Simulate(args) => simulate::run(args),
            Command::Evaluate(args) => evaluate::run(args),
            Command::Ablate(args) => ablate::run(args),
            Command::Bench(args) => bench::run(args),
            Command::Canonicalize(args) => canonicalize::run(args),
            Command::Render(args) => render::run(args),
            Command::Adapters(args) => adapters::run(args),
            Command::Probe(args) => probe::run(args),
        }
    }
}

/// Why a command ended without its result. The message says what to do about it; the kind decides the exit code.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Bad usage or bad input; nothing was written.
    #[error("{0}")]
    Input(String),
    /// Anything else.
    #[error("{0}")]
    Other(String),
}

impl Failure {
    /// 2 for the user's input, 1 for everything else.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Input(_) => ExitCode::from(2),
            Self::Other(_) => ExitCode::FAILURE,
        }
    }

    fn writing(path: &Path, error: impl Display) -> Self {
        Self::Other(format!("{}: cannot be written: {error}", path.display()))
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<BackendError> for Failure {
    fn from(error: BackendError) -> Self {
        match error {
            BackendError::Capacity(message) | BackendError::Unsupported(message) => Self::Input(message),
            BackendError::Device(message) => Self::Other(message),
        }
    }
}

impl From<OptimizeError> for Failure {
    fn from(error: OptimizeError) -> Self {
        match error {
            OptimizeError::Config { .. } | OptimizeError::Checkpoint(_) | OptimizeError::Candidate(_) => {
                Self::Input(error.to_string())
            }
            OptimizeError::Backend(error) => error.into(),
        }
    }
}

/// A line on stderr. A closed stderr is no reason to stop.
pub fn say(line: Arguments<'_>) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// One JSON object on stdout, or a text for people.
fn print_result(json: bool, value: &impl Serialize, text: &impl Display) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    let printed = if json {
        serde_json::to_writer_pretty(&mut out, value).map_err(io::Error::from).and_then(|()| writeln!(out))
    } else {
        writeln!(out, "{text}")
    };
    printed.and_then(|()| out.flush()).map_err(|error| Failure::Other(format!("stdout: cannot be written: {error}")))
}
