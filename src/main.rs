//! The command line: parses, runs one command, and turns its failure into a message and an exit code.

mod commands;

use std::process::ExitCode;

fn main() -> ExitCode {
    match commands::Cli::read().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            commands::say(format_args!("error: {failure}"));
            failure.exit_code()
        }
    }
}
