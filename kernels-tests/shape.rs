//! Convex parts, mass and cache, on the shared meshes.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

use glam::Vec3;
use rest3d_gpu::shape::{Cache, Quality, Shape, ShapeRequest, ShapeSettings, build_shapes, part_budget};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// `../shared/objects`, or `None` with a line on stderr.
fn objects() -> Option<PathBuf> {
    let objects = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/objects");
    if objects.is_dir() {
        return Some(objects);
    }
    eprintln!("skipped: {} is not there", objects.display());
    None
}

fn request(objects: &Path, name: &str, category: &str) -> ShapeRequest {
    ShapeRequest {
        name: name.into(),
        category: category.into(),
        mesh: objects.join(format!("{name}.glb")),
        scale: Vec3::ONE,
        mass: None,
        convex_parts: Vec::new(),
        up: Vec3::Y,
    }
}

fn build(request: ShapeRequest, cache: Option<&Cache>) -> Shape {
    build_shapes(&[request], &ShapeSettings::default(), cache, &|_, _, _| ()).unwrap().remove(0)
}

/// The table of all meshes: `cargo test --release --test shape -- --ignored --nocapture quality_table`, with the first
/// letters of names in `ONLY` if not all are wanted.
#[test]
#[ignore = "a minute or two"]
fn quality_table() {
    let Some(objects) = objects() else { return };
    let table = std::fs::read_to_string(objects.join("objects.csv")).unwrap();
    let only = std::env::var("ONLY").unwrap_or_default();
    println!(
        "{:20} {:>5} {:>5} {:>6} | {:>6} {:>6} | {:>6} {:>6} {:>6} | {:>6} {:>6} {:>6} {:>6} | {:>5}",
        "mesh",
        "parts",
        "verts",
        "ratio",
        "out95",
        "outmax",
        "bulgeM",
        "bul95",
        "bulmax",
        "feet",
        "top",
        "unc95",
        "uncmax",
        "s"
    );
    let mut all: Vec<(String, Quality, f32)> = Vec::new();
    for line in table.lines().skip(1) {
        let mut fields = line.split(',');
        let (name, category) = (fields.next().unwrap(), fields.next().unwrap());
        if !only.is_empty() && !only.split(',').any(|o| name.starts_with(o)) {
            continue;
        }
        let start = Instant::now();
        let shape = build(request(&objects, name, category), None);
        let q = shape.quality.clone();
        println!(
            "{:20} {:>2}/{:<2} {:>5} {:>6.3} | {:>6.2} {:>6.2} | {:>6.2} {:>6.2} {:>6.1} | {:>6.2} {:>6.2} {:>6.2} {:>6.2} | {:>5.2} {}",
            name,
            q.parts,
            part_budget(category),
            q.vertices,
            q.volume_ratio,
            q.outward_p95_mm,
            q.outward_max_mm,
            q.bulge_mean_mm,
            q.bulge_p95_mm,
            q.bulge_max_mm,
            q.uncovered_feet_mm,
            q.uncovered_top_mm,
            q.uncovered_p95_mm,
            q.uncovered_max_mm,
            start.elapsed().as_secs_f32(),
            shape.notes.join("; ")
        );
        all.push((name.into(), q, start.elapsed().as_secs_f32()));
    }
    let report = |label: &str, value: &dyn Fn(&Quality) -> f32| {
        let worst = all.iter().fold(&all[0], |w, o| if value(&o.1) > value(&w.1) { o } else { w });
        let mean = all.iter().map(|o| value(&o.1)).sum::<f32>() / all.len() as f32;
        println!("{label:10} mean {mean:8.3} worst {:8.3} ({})", value(&worst.1), worst.0);
    };
    report("vertices", &|q| q.vertices as f32);
    report("ratio", &|q| q.volume_ratio);
    report("out95", &|q| q.outward_p95_mm);
    report("bulgeM", &|q| q.bulge_mean_mm);
    report("bulge95", &|q| q.bulge_p95_mm);
    report("feet", &|q| q.uncovered_feet_mm);
    report("top", &|q| q.uncovered_top_mm);
    report("unc95", &|q| q.uncovered_p95_mm);
    println!("seconds {:.1}", all.iter().map(|o| o.2).sum::<f32>());
}
