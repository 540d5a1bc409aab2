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
use std::env;
use std::process::ExitCode;
use std::sync::{Arc, Mutex};

/// A test by name.
type Test = (&'static str, fn(&Device) -> Result<(), Failed>);

/// Devices that no test uses at the moment: tests on the same one would wait for each other's work.
struct Idle {
    choice: AdapterChoice,
    devices: Mutex<Vec<Device>>,
}

impl Idle {
    /// Lends a device to a test, a new one if there is none. One in which a test panicked does not come back.
    fn lend(&self, test: impl FnOnce(&Device) -> Result<(), Failed>) -> Result<(), Failed> {
        let idle = self.devices.lock().unwrap().pop();
        let device = idle.map_or_else(|| Device::open(self.choice.clone()), Ok)?;
        let result = test(&device);
        self.devices.lock().unwrap().push(device);
        result
    }
}

fn main() -> ExitCode {
    if startup::is_child() {
        return startup::child();
    }
    let arguments = Arguments::from_args();
    let required = env::var("REST3D_GPU_REQUIRE_ADAPTER").is_ok_and(|value| value != "0");
    let choice: AdapterChoice = env::var("REST3D_GPU_ADAPTER").unwrap_or_else(|_| "auto".into()).parse().unwrap();
    let (device, absent) = match Device::open(choice.clone()) {
        Ok(device) => {
            eprintln!("adapter: {}", device.gpu.report().name);
            (Some(device), false)
        }
        Err(error) => {
            eprintln!("no tests on the GPU: {error}");
            (None, !required)
        }
    };
    let idle = Arc::new(Idle { choice, devices: Mutex::new(device.into_iter().collect()) });
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
        let idle = Arc::clone(&idle);
        Trial::test(name, move || idle.lend(test)).with_ignored_flag(ignored)
    });
    let bodies = physics::physics_suite!(list_tests());
    let suite = bodies.into_iter().map(|(name, body)| {
        let idle = Arc::clone(&idle);
        let run = move |device: &Device| {
            body(device.backend()?);
            Ok(())
        };
        Trial::test(name, move || idle.lend(run)).with_ignored_flag(absent)
    });
    let trials = trials.chain(suite);
    libtest_mimic::run(&arguments, trials.collect()).exit_code()
}
