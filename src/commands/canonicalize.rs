//! `canonicalize`: turns a reconstruction upright and puts its objects at the heights of their supports.

use super::{Failure, output, print_result, say, scenes, shapes};
use rest3d_gpu::canonicalize::{Canonicalization, canonicalize};
use rest3d_gpu::scene::Scene;
use std::path::PathBuf;

/// Turn a reconstruction upright: +Y up, the ground at 0, everything at the height of its support
///
/// Leaves scene.json and canonicalize.json, the report, in DIR.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene.json, a folder that holds one, or a REST3D stage2 folder
    scene: PathBuf,
    /// Folder for the result
    #[arg(short, long = "output", value_name = "DIR")]
    output: PathBuf,
    /// Put the report on stdout as one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs it.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut scene = scenes::read(&args.scene)?;
    let dir = &args.output;
    let places = [dir.join("scene.json"), dir.join("canonicalize.json")];
    output::check_places(&places, dir)?;
    output::refuse_to_overwrite(&scene, &places)?;
    output::check_writable(dir)?;
    let report = apply(&mut scene)?;
    let mut text = serde_json::to_vec_pretty(&report)
        .map_err(|error| Failure::Other(format!("canonicalize.json: cannot be written as JSON: {error}")))?;
    text.push(b'\n');
    let files = [("canonicalize.json".into(), text), ("scene.json".into(), scene.to_json(dir).into_bytes())];
    output::write_all(dir, &files)?;
    print_result(args.json, &report, &report)?;
    say(format_args!("result: {}", dir.display()));
    Ok(())
}

/// Makes the scene canonical.
pub fn apply(scene: &mut Scene) -> Result<Canonicalization, Failure> {
    let meshes = shapes::meshes(scene)?;
    Ok(canonicalize(scene, &meshes))
}
