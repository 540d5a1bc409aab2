//! Where a configuration comes from: a file, or one of those built in.

use super::Failure;
use rest3d_gpu::optimize::Config;
use std::fs;

/// Name and text of the configurations that are always there.
const BUILT_IN: [(&str, &str); 3] = [
    ("default", include_str!("../../configs/default.toml")),
    ("paper", include_str!("../../configs/paper.toml")),
    ("quick", include_str!("../../configs/quick.toml")),
];

/// Reads `name`, the name of a built-in configuration or else a file, and applies the command line's overrides.
pub fn load(name: &str, candidates: Option<u32>, iterations: Option<u32>) -> Result<Config, Failure> {
    let built_in = BUILT_IN.iter().find(|(known, _)| *known == name);
    let text = match built_in {
        Some((_, text)) => (*text).into(),
        None => fs::read_to_string(name).map_err(|error| {
            Failure::Input(format!(
                "{name}: cannot be read: {error}; --config takes a file or one of: default, paper, quick"
            ))
        })?,
    };
    let mut config: Config =
        toml::from_str(&text).map_err(|error| Failure::Input(format!("{name}: {}", error.to_string().trim_end())))?;
    config.validate().map_err(|error| Failure::Input(format!("{name}: {error}")))?;
    for cem in [&mut config.local, &mut config.global] {
        cem.candidates = candidates.unwrap_or(cem.candidates);
        cem.iterations = iterations.unwrap_or(cem.iterations);
    }
    config.validate().map_err(|error| Failure::Input(format!("--candidates, --iterations: {error}")))?;
    Ok(config)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_configuration_of_ours_is_valid() {
        let files = fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/configs")).unwrap();
        let files: Vec<String> = files.map(|file| file.unwrap().path().to_str().unwrap().to_owned()).collect();
        assert!(files.len() > BUILT_IN.len(), "{files:?}");
        for name in BUILT_IN.iter().map(|(name, _)| *name).chain(files.iter().map(String::as_str)) {
            load(name, None, None).unwrap();
        }
    }

    /// The paper's numbers stand twice, in the file for people and in the code for missing keys; one of them is ours.
    #[test]
    fn the_papers_file_states_the_defaults_of_the_code() {
        let mut paper = Config::default();
        paper.simulation.contact_offset = 0.01;
        assert_eq!(load("paper", None, None).unwrap(), paper);
    }
}
