//! Parts of real meshes.

use crate::fixture::*;
use glam::Vec3;
use rest3d_gpu::world::{HullTables, Pose};
use std::path::Path;

/// Vertices of the convex parts of a shared scene.
fn real_hulls() -> Vec<Vec<Vec3>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes/bench12/meshes");
    let mut files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    files.retain(|f| f.file_name().unwrap().to_string_lossy().contains("_part"));
    files
        .iter()
        .map(|file| {
            let text = std::fs::read_to_string(file).unwrap();
            text.lines()
                .filter_map(|line| line.strip_prefix("v "))
                .map(|line| {
                    let numbers: Vec<f32> = line.split_whitespace().map(|n| n.parse().unwrap()).collect();
                    Vec3::from_slice(&numbers)
                })
                .collect()
        })
        .collect()
}

#[test]
#[cfg_attr(not(shared_files), ignore = "needs ../shared")]
fn twin_agrees_with_reference_on_real_hulls() {
    let parts = real_hulls();
    let mut tables = HullTables::default();
    parts.iter().for_each(|part| tables.push(part));
    assert_eq!(tables.hulls.len(), parts.len(), "a part was taken for flat");
    let mut random = Random(13);
    for i in 0..5000 {
        let [a, b] = [0, 1].map(|_| random.below(parts.len()));
        let (p, q) = (tables.hulls[a], tables.hulls[b]);
        let turned = [random.rotation(), random.rotation()];
        let apart = random.vector().normalize() * random.between(0.0, p.radius + q.radius);
        let poses = [Pose::new(turned[0], turned[0] * -p.center), Pose::new(turned[1], apart - turned[1] * q.center)];
        let case = Case::new([&parts[a], &parts[b]], poses);
        check(&case).unwrap_or_else(|e| panic!("pair {i}, parts {a} and {b}: {e}"));
    }
}
