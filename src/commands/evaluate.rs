//! `evaluate`: the paper's metrics of one scene or many.

use super::backend::BackendArgs;
use super::{Failure, print_result, say, scenes, shapes};
use rest3d_gpu::metrics::{self, STEPS};
use rest3d_gpu::optimize::Rig;
use rest3d_gpu::report::{Metrics, Overall};
use rest3d_gpu::scene::Scene;
use rest3d_gpu::shape::Mesh;
use rest3d_gpu::world::Backend;
use std::path::{Path, PathBuf};

/// Measure scenes: collisions of the meshes, stability in our simulator, distance from a reference
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Each a scene.json, a folder that holds one, or a REST3D stage2 folder
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Scene to compare with: the truth, or the input. One for all scenes, or one for each in their order
    #[arg(long, value_name = "SCENE")]
    reference: Vec<PathBuf>,
    /// Folder of PNG masks that were found, one instance a file
    #[arg(long, value_name = "DIR", requires = "true_masks")]
    masks: Option<PathBuf>,
    /// Folder of the true masks
    #[arg(long, value_name = "DIR", requires = "masks")]
    true_masks: Option<PathBuf>,
    /// Steps of 1/60 s to simulate
    #[arg(long, value_name = "L", default_value_t = STEPS, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
    #[command(flatten)]
    backend: BackendArgs,
    /// Put the result on stdout as one JSON object
    #[arg(long)]
    json: bool,
}

/// Runs it.
pub fn run(args: &Args) -> Result<(), Failure> {
    let references = scenes::references(&args.reference, args.scenes.len())?;
    let backend = args.backend.open(1)?.backend;
    let detection = match (&args.masks, &args.true_masks) {
        (Some(masks), Some(truth)) => {
            Some(metrics::detection(masks, truth).map_err(|error| Failure::Input(error.to_string()))?)
        }
        _ => None,
    };
    let measure = |i: usize| -> Result<Metrics, Failure> {
        let mut metrics = measure(&args.scenes[i], references[i], args.steps, backend.as_ref())?;
        metrics.detection = detection.clone();
        Ok(metrics)
    };
    if args.scenes.len() == 1 {
        let metrics = measure(0)?;
        return print_result(args.json, &metrics, &metrics);
    }
    let (mut measured, mut failures) = (Vec::new(), Vec::new());
    for (i, path) in args.scenes.iter().enumerate() {
        say(format_args!("scene {}/{}: {}", i + 1, args.scenes.len(), path.display()));
        match measure(i) {
            Ok(metrics) => measured.push(metrics),
            // One scene without a result is a number of its own among many.
            Err(Failure::Input(problem)) => {
                say(format_args!("counted as failed: {problem}"));
                failures.push(problem);
            }
            Err(other) => return Err(other),
        }
    }
    if measured.is_empty() {
        return Err(Failure::Input("none of the scenes could be measured; see the messages above".into()));
    }
    let overall = Overall::new(measured, failures);
    print_result(args.json, &overall, &overall)
}

fn measure(path: &Path, reference: Option<&Path>, steps: u32, backend: &dyn Backend) -> Result<Metrics, Failure> {
    let (scene, meshes) = read(path)?;
    let reference = reference.map(read).transpose()?;
    let rigs: Vec<Rig> = shapes::make(&scene, false)?.iter().map(Rig::new).collect();
    let ours = (&scene, &meshes[..]);
    let theirs = reference.as_ref().map(|(scene, meshes)| (scene, &meshes[..]));
    let layout = theirs.and_then(|theirs| metrics::layout(ours, theirs));
    if let (Some((other, _)), None) = (theirs, &layout) {
        say(format_args!(
            "note: {}: fewer than three of its movable objects have the names of objects in {}: nothing is said of the layout",
            scene.file.display(),
            other.file.display()
        ));
    }
    Ok(Metrics {
        scene: path.display().to_string(),
        objects: scene.objects.len(),
        collision: metrics::collision(&scene, &meshes),
        stability: metrics::stability(&scene, &rigs, backend, steps)?,
        geometry: theirs.and_then(|theirs| metrics::geometry(ours, theirs)),
        layout,
        detection: None,
    })
}

fn read(path: &Path) -> Result<(Scene, Vec<Mesh>), Failure> {
    let scene = scenes::read(path)?;
    let meshes = shapes::meshes(&scene)?;
    Ok((scene, meshes))
}
