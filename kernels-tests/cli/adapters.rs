//! Graphics adapters, machines without one, and the help.

use crate::common::program::program;
use crate::fixture::*;
use serde_json::Value;
use std::fs;

#[test]
fn adapters_are_listed_or_it_says_what_to_install() {
    let output = program().args(["adapters", "--json"]).output().unwrap();
    assert!(output.status.success());
    let list: Value = serde_json::from_slice(&output.stdout).unwrap();
    for (i, adapter) in list["adapters"].as_array().unwrap().iter().enumerate() {
        assert_eq!(adapter["index"], i);
        assert!(adapter["name"].is_string() && adapter["missing"].is_array());
    }
    if cfg!(target_os = "linux") {
        let output = program().arg("adapters").envs(NOWHERE).output().unwrap();
        assert!(output.status.success());
        assert!(text(&output.stdout).contains("libvulkan1"), "{}", text(&output.stdout));
    }
}

/// Variables under which no graphics driver is found.
const NOWHERE: [(&str, &str); 2] = [("VK_DRIVER_FILES", "/nonexistent"), ("VK_ICD_FILENAMES", "/nonexistent")];

#[test]
fn without_a_usable_driver_the_processor_simulates_and_it_says_why() {
    let case = Case::new(&table());
    let garbage = case.path("driver.json");
    fs::write(
        &garbage,
        r#"{"file_format_version": "1.0.0", "ICD": {"library_path": "/etc/passwd", "api_version": 7}}"#,
    )
    .unwrap();
    let garbage = garbage.to_str().unwrap();
    let faults: [(&[(&str, &str)], &str); 4] = [
        (&NOWHERE, "no graphics adapter"),
        (&[("VK_DRIVER_FILES", garbage), ("VK_ICD_FILENAMES", garbage)], "no graphics adapter"),
        (&[("REST3D_GPU_PROBE_FAULT", "crash")], "the graphics driver crashed"),
        (&[("REST3D_GPU_PROBE_FAULT", "hang"), ("REST3D_GPU_PROBE_SECONDS", "1")], "did not answer within 1 s"),
    ];
    for (variables, words) in faults {
        if !cfg!(target_os = "linux") && words.contains("adapter") {
            continue;
        }
        let output = case.command("simulate").args(["--steps", "2"]).envs(variables.iter().copied()).output().unwrap();
        let said = text(&output.stderr);
        let line = said.lines().find(|line| line.starts_with("backend: ")).unwrap_or_default();
        assert!(output.status.success() && line.contains("backend: CPU") && line.contains(words), "{said}");
    }
    let output = program().arg("adapters").env("REST3D_GPU_PROBE_FAULT", "crash").output().unwrap();
    let said = text(&output.stdout);
    assert!(output.status.success() && said.contains("crashed") && said.contains("install"), "{said}");
}

#[test]
fn help_lists_only_what_exists() {
    let help = program().arg("--help").output().unwrap();
    let help = text(&help.stdout);
    let (_, list) = help.split_once("\nCommands:\n").unwrap();
    let list = list.lines().take_while(|line| !line.is_empty()).map(|line| line.strip_prefix("  ").unwrap());
    // What a command does may go on in further lines.
    let names: Vec<&str> = list.filter(|line| !line.starts_with(' ')).flat_map(|line| line.split(' ').next()).collect();
    let commands =
        ["optimize", "simulate", "evaluate", "ablate", "bench", "canonicalize", "render", "adapters", "help"];
    assert_eq!(names, commands, "{help}");
}
