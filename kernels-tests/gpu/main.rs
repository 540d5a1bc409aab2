//! Every GPU kernel against its twin in `src/cpu`, and pictures against those of the processor, on the adapter at hand.
//!
//! Without an adapter the tests show as ignored; with `REST3D_GPU_REQUIRE_ADAPTER=1` they fail. `REST3D_GPU_ADAPTER`
//! chooses the adapter as `--adapter` does.

#![allow(clippy::unwrap_used)]

mod auto;
mod best;
mod bisect;
mod boxes;
mod chain;
mod collide;
#[path = "../common/mod.rs"]
mod common;
mod contacts;
mod crowd;
mod depth;
mod device;
mod elites;
mod energy;
mod first_loads;
mod fixture;
mod funnel;
mod hull_pairs;
mod manifold;
mod moments;
#[path = "../physics/mod.rs"]
mod physics;
mod pictures;
mod place;
#[path = "../render/fixture.rs"]
mod render;
mod sample;
mod simulation;
mod solver;
mod stages;
mod startup;
mod states;
mod stats;
mod times;
mod touching;
mod waves;
mod whole;

use fixture::Device;
use libtest_mimic::{Arguments, Failed, Trial};
use rest3d_gpu::gpu::AdapterChoice;
use std::process::ExitCode;
use std::{env, sync::Arc};

/// A test by name.
type Test = (&'static str, fn(&Device) -> Result<(), Failed>);

fn main() -> ExitCode {
    if startup::is_child() {
        return startup::child();
    }
    let arguments = Arguments::from_args();
    let required = env::var("REST3D_GPU_REQUIRE_ADAPTER").is_ok_and(|value| value != "0");
    let choice: AdapterChoice = env::var("REST3D_GPU_ADAPTER").unwrap_or_else(|_| "auto".into()).parse().unwrap();
    let opened = Arc::new(Device::open(choice));
    let absent = match opened.as_ref() {
        Ok(device) => {
            eprintln!("adapter: {}", device.gpu.report().name);
            false
        }
        Err(error) => {
            eprintln!("no tests on the GPU: {error}");
            !required
        }
    };
    let modules = [
        sample::TESTS,
        place::TESTS,
        energy::TESTS,
        elites::TESTS,
        best::TESTS,
        funnel::TESTS,
        moments::TESTS,
        stats::TESTS,
        simulation::TESTS,
        first_loads::TESTS,
        solver::TESTS,
        waves::TESTS,
        boxes::TESTS,
        hull_pairs::TESTS,
        depth::TESTS,
        collide::TESTS,
        chain::TESTS,
        manifold::TESTS,
        contacts::TESTS,
        device::TESTS,
        times::TESTS,
        startup::TESTS,
        auto::TESTS,
        pictures::TESTS,
        bisect::TESTS,
        whole::TESTS,
    ];
    let alone = modules.into_iter().flatten().map(|test| (test, absent));
    let shared = whole::SHARED_TESTS.iter().map(|test| (test, absent || !cfg!(shared_files)));
    let trials = alone.chain(shared).map(|(&(name, test), ignored)| {
        let opened = Arc::clone(&opened);
        let run = move || test(opened.as_ref().as_ref().map_err(|error| error.to_string())?);
        Trial::test(name, run).with_ignored_flag(ignored)
    });
    let bodies = physics::physics_suite!(list_tests());
    let suite = bodies.into_iter().map(|(name, body)| {
        let opened = Arc::clone(&opened);
        let run = move || {
            let device = opened.as_ref().as_ref().map_err(|error| error.to_string())?;
            body(device.backend()?);
            Ok(())
        };
        Trial::test(name, run).with_ignored_flag(absent)
    });
    let trials = trials.chain(suite);
    libtest_mimic::run(&arguments, trials.collect()).exit_code()
}
