//! The command line on a machine with an adapter: what `--backend auto` takes, and what happens when a device is lost.

use super::Test;
use super::fixture::Device;
use crate::common::meshes::CUBE;
use crate::common::program::program;
use libtest_mimic::Failed;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Output;

pub const TESTS: &[Test] = &[
    ("auto::takes_an_adapter_that_passes_and_remembers_it", takes_an_adapter_that_passes),
    ("auto::does_not_take_a_slow_adapter", does_not_take_a_slow_adapter),
    ("auto::does_not_trust_a_wrong_or_crashing_driver", does_not_trust_a_wrong_driver),
    ("auto::adapters_are_tested_on_demand", adapters_are_tested_on_demand),
    ("auto::a_lost_device_ends_on_the_processor", a_lost_device_ends_on_the_processor),
];

/// A table in the air with a box on it.
const SCENE: &str = r#"{"format": "rest3d-scene", "version": 1, "name": "boxes", "objects": [
    {"name": "table", "mesh": "cube.obj", "position": [0, 0.27, 0], "scale": [1, 0.5, 0.6], "parent": "ground"},
    {"name": "box", "mesh": "cube.obj", "position": [0, 0.6, 0], "scale": [0.2, 0.2, 0.2], "parent": "table"}]}"#;

/// The adapter counts as faster than the processor.
const FAST: (&str, &str) = ("REST3D_GPU_PROBE_FAULT", "fast");

struct Case(tempfile::TempDir);

impl Case {
    fn new() -> Result<Self, Failed> {
        let folder = tempfile::tempdir()?;
        fs::write(folder.path().join("cube.obj"), CUBE)?;
        fs::write(folder.path().join("scene.json"), SCENE)?;
        Ok(Self(folder))
    }

    /// Runs a command with these variables; the cache is the case's own.
    fn run(&self, arguments: &[&str], variables: &[(&str, &str)]) -> Result<Output, Failed> {
        let mut command = program();
        command.current_dir(&self.0).args(arguments).env("REST3D_GPU_CACHE", self.0.path().join("cache"));
        Ok(command.envs(variables.iter().copied()).output()?)
    }

    fn optimize(&self, out: &str, more: &[&str], variables: &[(&str, &str)]) -> Result<String, Failed> {
        let fixed = ["optimize", ".", "-o", out, "--candidates", "16", "--iterations", "3"];
        let output = self.run(&[&fixed, more].concat(), variables)?;
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        if output.status.success() { Ok(said) } else { Err(said.into()) }
    }

    fn read(&self, name: &str) -> Result<String, Failed> {
        Ok(fs::read_to_string(self.0.path().join(name))?)
    }
}

/// Has `auto` take the adapter under test, which may be a software adapter.
fn taken(device: &Device) -> (&'static str, String) {
    ("REST3D_GPU_AUTO", device.gpu.report().kind.to_string())
}

fn takes_an_adapter_that_passes(device: &Device) -> Result<(), Failed> {
    let case = Case::new()?;
    let (variable, kind) = taken(device);
    let first = case.optimize("first", &[], &[(variable, &kind), FAST])?;
    let second = case.optimize("second", &[], &[(variable, &kind)])?;
    let tested = [&first, &second].map(|said| said.contains("testing "));
    let on_it = [&first, &second].iter().all(|said| said.contains("backend: GPU, "));
    if tested != [true, false] || !on_it || !passed(case.0.path()) {
        return Err(format!("{first}\n{second}").into());
    }
    let report: Value = serde_json::from_str(&case.read("second/report.json")?)?;
    let times = report["kernels_ms"].as_object().map_or(0, serde_json::Map::len);
    if report["backend"].as_str().is_none_or(|name| !name.starts_with("GPU")) || (times > 0) != device.gpu.has_times() {
        return Err(format!("{} {times}", report["backend"]).into());
    }
    Ok(())
}

/// And remembers that it is slow.
fn does_not_take_a_slow_adapter(device: &Device) -> Result<(), Failed> {
    let case = Case::new()?;
    let (variable, kind) = taken(device);
    for variables in [&[(variable, kind.as_str()), ("REST3D_GPU_PROBE_FAULT", "slow")][..], &[(variable, &kind)]] {
        let said = case.optimize("out", &[], variables)?;
        if !said.contains("backend: CPU") || !said.contains("takes 2.0 times as long as") {
            return Err(said.into());
        }
    }
    Ok(())
}

fn does_not_trust_a_wrong_driver(device: &Device) -> Result<(), Failed> {
    let case = Case::new()?;
    let (variable, kind) = taken(device);
    for (fault, words) in [("wrong", "a fault for tests"), ("crash", "crashed"), ("hang", "did not answer within 1 s")]
    {
        let seconds = if fault == "hang" { "1" } else { "60" };
        let faults =
            [(variable, kind.as_str()), ("REST3D_GPU_PROBE_FAULT", fault), ("REST3D_GPU_PROBE_SECONDS", seconds)];
        let said = case.optimize("out", &[], &faults)?;
        if !said.contains(words) || !said.contains("backend: CPU") || passed(case.0.path()) {
            return Err(format!("{fault}: {said}").into());
        }
    }
    Ok(())
}

/// True if a test is remembered.
fn passed(folder: &Path) -> bool {
    let entries = fs::read_dir(folder.join("cache")).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).any(|path| path.extension().is_some_and(|ending| ending == "passed"))
}

fn adapters_are_tested_on_demand(device: &Device) -> Result<(), Failed> {
    let case = Case::new()?;
    let index = device.gpu.report().index;
    for (fault, words) in [("", "passed the test"), ("wrong", "failed the test: a fault for tests")] {
        let output = case.run(&["adapters", "--test", "--json"], &[("REST3D_GPU_PROBE_FAULT", fault)])?;
        let listing: Value = serde_json::from_slice(&output.stdout)?;
        if !listing["adapters"][index]["test"].as_str().is_some_and(|text| text.contains(words)) {
            return Err(format!("{listing}").into());
        }
    }
    Ok(())
}

fn a_lost_device_ends_on_the_processor(device: &Device) -> Result<(), Failed> {
    let case = Case::new()?;
    let adapter = device.gpu.report().index.to_string();
    let gpu = ["--backend", "gpu", "--adapter", &adapter];
    let said = case.optimize("lost", &gpu, &[("REST3D_GPU_LOST_AFTER", "0")])?;
    case.optimize("cpu", &["--backend", "cpu"], &[])?;
    let words = ["4 times fewer candidates", "going on from the last finished group on CPU", "lost"];
    if let Some(word) = words.iter().find(|word| !said.contains(**word)) {
        return Err(format!("does not say `{word}`: {said}").into());
    }
    // Lost before the first group was done: the processor did it all.
    if case.read("lost/scene.json")? != case.read("cpu/scene.json")? {
        return Err("the result is not the processor's".into());
    }
    // Lost when asked for the winner of the first group, twice: a group without a winner does not count as done.
    case.optimize("winner", &gpu, &[("REST3D_GPU_LOST_AFTER", "1")])?;
    if case.read("winner/scene.json")? != case.read("cpu/scene.json")? {
        return Err("a device lost at the winner: the result is not the processor's".into());
    }
    // Two groups of an iteration and a winner each: the device that is opened again does the second.
    let said = case.optimize("again", &gpu, &[("REST3D_GPU_LOST_AFTER", "2")])?;
    let report: Value = serde_json::from_str(&case.read("again/report.json")?)?;
    let note = report["notes"][0].as_str().unwrap_or_default();
    if !note.contains("went on after 1 groups") || report["backend"].as_str().is_none_or(|it| !it.starts_with("GPU")) {
        return Err(format!("{note}: {said}").into());
    }
    Ok(())
}
