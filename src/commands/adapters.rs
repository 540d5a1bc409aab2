//! `adapters`: the graphics adapters of this machine, and whether they can simulate.

use super::{Failure, print_result, probe};
use rest3d_gpu::bench::Speed;
use rest3d_gpu::gpu::{AdapterKind, AdapterReport, INSTALL_HINT};
use serde::Serialize;
use std::fmt;

/// List the graphics adapters and what keeps each from simulating
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Test each fit adapter with a small simulation
    #[arg(long)]
    test: bool,
    /// Put the list on stdout as one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Listing {
    adapters: Vec<Entry>,
    /// Why the drivers could not be asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<String>,
}

#[derive(Serialize)]
struct Entry {
    #[serde(flatten)]
    adapter: AdapterReport,
    /// What the test found, if it was wanted: "passed in 2.1 s", or what went wrong.
    #[serde(skip_serializing_if = "Option::is_none")]
    test: Option<String>,
}

impl fmt::Display for Listing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for Entry { adapter, test } in &self.adapters {
            let AdapterReport { index, name, kind, api, driver, max_binding_bytes, missing } = adapter;
            writeln!(f, "{index}: {name} ({kind}, {api}, {driver}, buffers up to {} MiB)", max_binding_bytes >> 20)?;
            match missing.as_slice() {
                [] => writeln!(f, "   fit")?,
                missing => writeln!(f, "   not fit, lacks {}", missing.join("; "))?,
            }
            test.iter().try_for_each(|test| writeln!(f, "   {test}"))?;
        }
        if let Some(problem) = &self.problem {
            write!(f, "{problem}: {INSTALL_HINT}; until then --backend cpu simulates")
        } else if self.adapters.is_empty() {
            write!(f, "no graphics adapter: {INSTALL_HINT}")
        } else if self
            .adapters
            .iter()
            .all(|Entry { adapter, .. }| adapter.kind == AdapterKind::Software || !adapter.is_fit())
        {
            write!(f, "no fit hardware adapter; if this machine has a graphics card, {INSTALL_HINT}")
        } else {
            write!(f, "any of these numbers, or a part of a name, selects an adapter")
        }
    }
}

/// "passed the test in 0.4 s; takes 3.3 times as long as the processor for 64 candidates, 0.8 times for 512".
fn passed(seconds: f64, speeds: &[Speed]) -> String {
    let times = |speed: &Speed| format!("{:.1} times", speed.processor / speed.card);
    let beside: Vec<String> = match speeds {
        [] => Vec::new(),
        [first, more @ ..] => {
            let first = format!("takes {} as long as the processor for {} candidates", times(first), first.candidates);
            std::iter::once(first).chain(more.iter().map(|it| format!("{} for {}", times(it), it.candidates))).collect()
        }
    };
    format!("passed the test in {seconds:.1} s; {}", beside.join(", "))
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), Failure> {
    let (found, problem) = match probe::list() {
        Ok(found) => (found, None),
        Err(problem) => (Vec::new(), Some(problem)),
    };
    let tested = |adapter: &AdapterReport| match probe::verdict(adapter, 0) {
        Ok(probe::Verdict { problem: None, seconds, speeds }) => passed(seconds, &speeds),
        Ok(probe::Verdict { problem: Some(problem), .. }) | Err(problem) => format!("failed the test: {problem}"),
    };
    let entry = |adapter: AdapterReport| {
        let test = (args.test && adapter.is_fit()).then(|| tested(&adapter));
        Entry { adapter, test }
    };
    let listing = Listing { adapters: found.into_iter().map(entry).collect(), problem };
    print_result(args.json, &listing, &listing)
}
