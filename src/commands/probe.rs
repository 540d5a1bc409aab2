//! `probe`: what this program asks of graphics drivers in a process of its own, because drivers crash and hang.
//!
//! The child is this program again, with a hidden subcommand; its answer is one JSON object on stdout.

use super::{Failure, print_result, say};
use rest3d_gpu::bench::{Speed, contest};
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::files::write_whole;
use rest3d_gpu::gpu::{AdapterChoice, AdapterReport, GpuBackend, Options, adapters, identity, self_test};
use rest3d_gpu::shape::Cache;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::env;
use std::io::Read;
use std::path::PathBuf;
use std::process::{Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// How long drivers may take to list their adapters, and to pass the self-test, which compiles all kernels.
const LISTING_SECONDS: u64 = 20;
const TEST_SECONDS: u64 = 120;

/// Environment variables for tests: a time limit in place of these, s, and what the child does wrong: `crash`, `hang`,
/// or `wrong`, a self-test that fails; with `fast` and `slow` it does not measure how fast the adapter is.
const SECONDS: &str = "REST3D_GPU_PROBE_SECONDS";
const FAULT: &str = "REST3D_GPU_PROBE_FAULT";

/// Ask the graphics drivers (for this program's own use)
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Run the self-test on the adapter of this number
    #[arg(long, value_name = "NUMBER")]
    test: Option<usize>,
    /// Beside so many threads
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
}

/// The child's answer.
#[derive(Debug, Serialize, Deserialize)]
struct Listing {
    adapters: Vec<AdapterReport>,
}

/// The child's verdict.
#[derive(Debug, Serialize, Deserialize)]
pub struct Verdict {
    /// What is wrong; none if the test was passed.
    pub problem: Option<String>,
    /// Until all kernels were compiled and the test was done.
    pub seconds: f64,
    /// How fast it is beside the processor, if the test was passed.
    pub speeds: Vec<Speed>,
}

/// Runs the child.
pub fn run(args: &Args) -> Result<(), Failure> {
    let fault = env::var(FAULT).unwrap_or_default();
    match fault.as_str() {
        "crash" => std::process::abort(),
        "hang" => loop {
            sleep(Duration::from_secs(60));
        },
        _ => {}
    }
    let Some(number) = args.test else { return print_result(true, &Listing { adapters: adapters() }, &"") };
    let clock = Instant::now();
    let options = Options { adapter: AdapterChoice::Index(number), cache: cache(), ..Options::default() };
    let threads = rayon::ThreadPoolBuilder::new().num_threads(args.threads).build_global();
    let test = || -> Result<(f64, Vec<Speed>), String> {
        threads.map_err(|error| error.to_string())?;
        if fault == "wrong" {
            return Err("a fault for tests".into());
        }
        let backend = GpuBackend::open_with(&options).map_err(|error| error.to_string())?;
        self_test(&backend, &CpuBackend)?;
        let seconds = clock.elapsed().as_secs_f64();
        let speeds = match fault.as_str() {
            "fast" => vec![Speed { candidates: 1, card: 2.0, processor: 1.0 }],
            "slow" => vec![Speed { candidates: 1, card: 1.0, processor: 2.0 }],
            _ => contest(&backend, &CpuBackend).map_err(|error| format!("its speed cannot be measured: {error}"))?,
        };
        Ok((seconds, speeds))
    };
    let verdict = match test() {
        Ok((seconds, speeds)) => Verdict { problem: None, seconds, speeds },
        Err(problem) => Verdict { problem: Some(problem), seconds: clock.elapsed().as_secs_f64(), speeds: Vec::new() },
    };
    print_result(true, &verdict, &"")
}

/// The adapters of this machine, or why the drivers cannot be asked.
pub fn list() -> Result<Vec<AdapterReport>, String> {
    ask::<Listing>(&["probe"], LISTING_SECONDS).map(|listing| listing.adapters)
}

/// Has an adapter tested, if it was not with this driver and this version. Tells how fast it is beside so many threads.
pub fn test(adapter: &AdapterReport, threads: usize) -> Result<Vec<Speed>, String> {
    let passed = cache().map(|folder| {
        let AdapterReport { name, api, driver, .. } = adapter;
        folder.join(format!("{}.passed", identity(&[name, api, driver, &threads.to_string()])))
    });
    let known = passed.as_ref().and_then(|file| std::fs::read(file).ok());
    let speeds: Vec<Speed> = known.and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default();
    if !speeds.is_empty() && speeds.iter().all(Speed::is_sound) {
        return Ok(speeds);
    }
    say(format_args!("testing {} once", adapter.name));
    let verdict = verdict(adapter, threads)?;
    if let Some(problem) = verdict.problem {
        return Err(problem);
    }
    if let (Some(file), Ok(text)) = (passed, serde_json::to_vec(&verdict.speeds)) {
        // Where that cannot be remembered, the next run tests again.
        let _ = write_whole(&file, &text);
    }
    Ok(verdict.speeds)
}

/// Tests an adapter, whatever is known of it, beside so many threads; 0: as many as there are cores.
pub fn verdict(adapter: &AdapterReport, threads: usize) -> Result<Verdict, String> {
    ask(&["probe", "--test", &adapter.index.to_string(), "--threads", &threads.to_string()], TEST_SECONDS)
}

/// Where compiled kernels and passed tests are kept.
pub fn cache() -> Option<PathBuf> {
    Cache::default_location().map(|cache| cache.directory().to_owned())
}

/// Runs this program with these arguments and reads its answer.
fn ask<T: DeserializeOwned>(arguments: &[&str], seconds: u64) -> Result<T, String> {
    let seconds = env::var(SECONDS).ok().and_then(|text| text.parse().ok()).unwrap_or(seconds);
    let failed = |error: std::io::Error| format!("the graphics drivers cannot be asked: {error}");
    let program = env::current_exe().map_err(failed)?;
    let mut command = Command::new(program);
    // Drivers talk on stderr.
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn().map_err(failed)?;
    let mut pipe = child.stdout.take();
    let answer = std::thread::spawn(move || {
        let mut text = String::new();
        let read = pipe.as_mut().map(|pipe| pipe.read_to_string(&mut text));
        read.transpose().map(|_| text)
    });
    let asked = Instant::now();
    let status = loop {
        match child.try_wait().map_err(failed)? {
            Some(status) => break status,
            None if asked.elapsed() >= Duration::from_secs(seconds) => {
                let _ = child.kill();
                let _ = child.wait();
                return Err(format!("the graphics driver did not answer within {seconds} s"));
            }
            None => sleep(Duration::from_millis(5)),
        }
    };
    let text = answer.join().ok().and_then(Result::ok).unwrap_or_default();
    match serde_json::from_str(&text) {
        Ok(answer) if status.success() => Ok(answer),
        _ => Err(format!("the graphics driver crashed ({})", ended(status))),
    }
}

fn ended(status: ExitStatus) -> String {
    #[cfg(unix)]
    {
        use std::os::unix::process::ExitStatusExt;
        if let Some(signal) = status.signal() {
            return format!("signal {signal}");
        }
    }
    status.to_string()
}
