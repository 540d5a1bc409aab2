//! `adapters`: the graphics adapters of this machine, and whether they can simulate.

use super::{Failure, print_result};
use rest3d_gpu::gpu::{AdapterKind, AdapterReport, INSTALL_HINT, adapters};
use serde::Serialize;
use std::fmt;

/// List the graphics adapters and what keeps each from simulating
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Put the list on stdout as one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Listing {
    adapters: Vec<AdapterReport>,
}

impl fmt::Display for Listing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for adapter in &self.adapters {
            let AdapterReport { index, name, kind, api, driver, max_binding_bytes, missing } = adapter;
            writeln!(f, "{index}: {name} ({kind}, {api}, {driver}, buffers up to {} MiB)", max_binding_bytes >> 20)?;
            match missing.as_slice() {
                [] => writeln!(f, "   fit")?,
                missing => writeln!(f, "   not fit, lacks {}", missing.join("; "))?,
            }
        }
        if self.adapters.is_empty() {
            write!(f, "no graphics adapter: {INSTALL_HINT}")
        } else if self.adapters.iter().all(|adapter| adapter.kind == AdapterKind::Software || !adapter.is_fit()) {
            write!(f, "no fit hardware adapter; if this machine has a graphics card, {INSTALL_HINT}")
        } else {
            write!(f, "any of these numbers, or a part of a name, selects an adapter")
        }
    }
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), Failure> {
    let listing = Listing { adapters: adapters() };
    print_result(args.json, &listing, &listing)
}
