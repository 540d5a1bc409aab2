//! How near a scene is to a reference: as surfaces, as boxes, and object by object.

use super::alignment::{fit, icp, middle, moved};
use super::surface::{Surface, spread};
use super::{FALLEN, MATCHED, THICKNESS, bounds, mean, placed};
use crate::scene::{Pose, Scene};
use crate::shape::Mesh;
use glam::{DMat3, DVec3};
use serde::Serialize;

/// Points spread over each scene to measure distances from.
const SAMPLES: usize = 20_000;
/// Those of them that the alignment uses.
const ALIGNING: usize = 2_000;
/// Fewer objects in common leave the alignment by objects undetermined.
const MIN_COMMON: usize = 3;

/// Distance of a scene's surface to a reference's after rigid alignment (paper: CD, F-score, B-IoU).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Geometry {
    /// Mean distance from the scene to the reference plus that from the reference to the scene, m.
    pub chamfer_distance_m: f64,
    /// Harmonic mean of the shares of either surface that lie within [`MATCHED`] of the other, 0 to 1.
    pub f_score: f64,
    /// Mean over the reference's objects of the intersection over union of the axis-aligned boxes of the objects of one
    /// name, 0 to 1; an object that is missing counts 0.
    pub box_iou: f64,
    /// How far the alignment moved the scene's middle, m.
    pub aligned_by_m: f64,
    /// And turned it, rad.
    pub aligned_by_rad: f64,
}

/// How far the movable objects are from where the reference has them, after the one rigid motion that fits their
/// middles and turns best: what a result that is faithful to its picture keeps small.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Layout {
    /// Movable objects of both scenes.
    pub objects: usize,
    /// m.
    pub mean_translation_m: f64,
    /// m.
    pub max_translation_m: f64,
    /// rad.
    pub mean_rotation_rad: f64,
    /// rad.
    pub max_rotation_rad: f64,
    /// Names of those turned by more than [`FALLEN`].
    pub fallen: Vec<String>,
}

/// Compares surfaces; each scene comes with its objects' meshes in metres. None if either has no surface.
pub fn geometry(scene: (&Scene, &[Mesh]), reference: (&Scene, &[Mesh])) -> Option<Geometry> {
    let [ours, theirs] = [scene, reference].map(|(scene, meshes)| objects(scene, meshes));
    let [all, all_theirs] = [&ours, &theirs].map(|objects| objects.concat());
    let surface = Surface::new(&all_theirs)?;
    let [points, points_theirs] = [&all, &all_theirs].map(|triangles| spread(triangles, SAMPLES));
    let few: Vec<DVec3> = points.iter().step_by(SAMPLES / ALIGNING).copied().collect();
    // Closest points find the nearest optimum: start from where the scene is, and from where the objects of one name
    // are.
    let guesses = [Some(Pose::IDENTITY), by_names(scene, reference).map(|(motion, _)| motion)];
    let motion = guesses
        .into_iter()
        .flatten()
        .map(|guess| icp(&few, &surface, guess))
        .map(|motion| (error(&few, &surface, &motion), motion))
        .min_by(|a, b| a.0.total_cmp(&b.0))?
        .1;
    let aligned = |triangles: &[[DVec3; 3]]| -> Vec<[DVec3; 3]> {
        triangles.iter().map(|t| t.map(|p| moved(&motion, p))).collect()
    };
    let there = surface.distances(&points.iter().map(|p| moved(&motion, *p)).collect::<Vec<_>>());
    let back = Surface::new(&aligned(&all))?.distances(&points_theirs);
    let [precision, recall] = [&there, &back].map(|distances| {
        distances.iter().filter(|distance| **distance <= MATCHED).count() as f64 / distances.len().max(1) as f64
    });
    let boxes: Vec<[DVec3; 2]> = ours.iter().map(|object| bounds(aligned(object).iter().flatten().copied())).collect();
    let center = middle(&points);
    Some(Geometry {
        chamfer_distance_m: mean(there.into_iter()) + mean(back.into_iter()),
        f_score: if precision + recall > 0.0 { 2.0 * precision * recall / (precision + recall) } else { 0.0 },
        box_iou: mean(reference.0.objects.iter().zip(&theirs).map(|(object, triangles)| {
            let own = scene.0.objects.iter().position(|own| own.name == object.name);
            own.map_or(0.0, |i| iou(boxes[i], bounds(triangles.iter().flatten().copied())))
        })),
        aligned_by_m: moved(&motion, center).distance(center),
        aligned_by_rad: motion.rotation.angle_between(Pose::IDENTITY.rotation),
    })
}

/// Compares the places of the objects of one name. None if fewer than three of them can move.
pub fn layout(scene: (&Scene, &[Mesh]), reference: (&Scene, &[Mesh])) -> Option<Layout> {
    let (motion, pairs) = by_names(scene, reference)?;
    let moves: Vec<f64> = pairs.iter().map(|pair| moved(&motion, pair.middle).distance(pair.wanted)).collect();
    let turn = |pair: &Pair| {
        let [own, other] = [&scene.0.objects[pair.own].pose, &reference.0.objects[pair.other].pose];
        (motion.rotation * own.rotation).normalize().angle_between(other.rotation)
    };
    let turns: Vec<f64> = pairs.iter().map(turn).collect();
    let fallen = pairs.iter().zip(&turns).filter(|(_, turn)| **turn > FALLEN);
    Some(Layout {
        objects: pairs.len(),
        mean_translation_m: mean(moves.iter().copied()),
        max_translation_m: moves.iter().copied().fold(0.0, f64::max),
        mean_rotation_rad: mean(turns.iter().copied()),
        max_rotation_rad: turns.iter().copied().fold(0.0, f64::max),
        fallen: fallen.map(|(pair, _)| scene.0.objects[pair.own].name.clone()).collect(),
    })
}

/// One movable object in both scenes.
struct Pair {
    own: usize,
    other: usize,
    /// Middle of its box where it stands and where it should, m.
    middle: DVec3,
    wanted: DVec3,
}

/// The motion that takes the movable objects to those of their names: their middles, and with the same weight their
/// turns.
fn by_names(scene: (&Scene, &[Mesh]), reference: (&Scene, &[Mesh])) -> Option<(Pose, Vec<Pair>)> {
    let middle_of = |(scene, meshes): (&Scene, &[Mesh]), i: usize| {
        let corners =
            meshes[i].triangles.iter().flatten().map(|&corner| meshes[i].vertices[corner as usize].as_dvec3());
        let [low, high] = bounds(corners);
        moved(&scene.objects[i].pose, 0.5 * (low + high))
    };
    let pairs: Vec<Pair> = (0..scene.0.objects.len())
        .filter(|&own| !scene.0.is_static(own))
        .filter_map(|own| {
            let name = &scene.0.objects[own].name;
            let other = reference.0.objects.iter().position(|other| other.name == *name)?;
            Some(Pair { own, other, middle: middle_of(scene, own), wanted: middle_of(reference, other) })
        })
        .collect();
    if pairs.len() < MIN_COMMON {
        return None;
    }
    let turns = pairs.iter().fold(DMat3::ZERO, |sum, pair| {
        let [own, other] = [&scene.0.objects[pair.own].pose, &reference.0.objects[pair.other].pose];
        sum + DMat3::from_quat((other.rotation * own.rotation.conjugate()).normalize())
    });
    let from: Vec<DVec3> = pairs.iter().map(|pair| pair.middle).collect();
    let to: Vec<DVec3> = pairs.iter().map(|pair| pair.wanted).collect();
    let center = middle(&from);
    let spread = from.iter().map(|p| p.distance_squared(center)).sum::<f64>().max(1e-9);
    Some((fit(&from, &to, turns * (spread / pairs.len() as f64)), pairs))
}

/// Triangles of every object where it stands.
fn objects(scene: &Scene, meshes: &[Mesh]) -> Vec<Vec<[DVec3; 3]>> {
    (0..meshes.len()).map(|i| placed(scene, i, &meshes[i])).collect()
}

/// Mean distance of the points from the surface after the motion, m.
fn error(points: &[DVec3], surface: &Surface, motion: &Pose) -> f64 {
    let points: Vec<DVec3> = points.iter().map(|p| moved(motion, *p)).collect();
    mean(surface.distances(&points).into_iter())
}

/// Intersection over union of two boxes, 0 to 1: of flat ones as if they were a micrometre thick.
fn iou(a: [DVec3; 2], b: [DVec3; 2]) -> f64 {
    let [a, b] = [a, b].map(|[low, high]| [low - 0.5 * THICKNESS, high + 0.5 * THICKNESS]);
    let volume = |[low, high]: [DVec3; 2]| (high - low).max(DVec3::ZERO).element_product();
    let common = volume([a[0].max(b[0]), a[1].min(b[1])]);
    let union = volume(a) + volume(b) - common;
    if union > 0.0 { common / union } else { 0.0 }
}
