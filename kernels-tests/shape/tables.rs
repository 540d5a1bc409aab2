//! The slow ones: all meshes, and all known layouts.

use crate::fixture::*;
use glam::Vec3;
use parry3d::bounding_volume::BoundingVolume as _;
use parry3d::math::Pose3;
use parry3d::shape::{ConvexPolyhedron, Shape as _};
use rest3d_gpu::optimize::shape_requests;
use rest3d_gpu::scene::Scene;
use rest3d_gpu::shape::{Cache, Part, Quality, ShapeSettings, build_shapes, part_budget};
use std::time::Instant;

/// The table of all meshes: `cargo test --release --test shape -- --ignored --nocapture quality_table`, with the first
/// letters of names in `ONLY` if not all are wanted.
#[test]
#[ignore = "a minute or two: scripts/test-slow"]
fn quality_table() {
    let objects = objects();
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
        value(&worst.1)
    };
    report("vertices", &|q| q.vertices as f32);
    report("ratio", &|q| q.volume_ratio);
    // An object that stands by its parts stands as far off: about a millimetre is what the eye allows.
    let out = report("out95", &|q| q.outward_p95_mm);
    report("bulgeM", &|q| q.bulge_mean_mm);
    report("bulge95", &|q| q.bulge_p95_mm);
    let feet = report("feet", &|q| q.uncovered_feet_mm);
    let top = report("top", &|q| q.uncovered_top_mm);
    report("unc95", &|q| q.uncovered_p95_mm);
    println!("seconds {:.1}", all.iter().map(|o| o.2).sum::<f32>());
    assert!(out.max(feet).max(top) < 1.5, "{out} {feet} {top} mm");
}

/// In the true layouts no two meshes intersect, so the parts should hardly overlap:
/// `cargo test --release --test shape -- --ignored --nocapture truth_overlaps`. Prints the worst pairs of each scene.
#[test]
#[ignore = "a minute or two: scripts/test-slow"]
fn truth_overlaps() {
    let objects = objects();
    let scenes = objects.join("../scenes");
    let only = std::env::var("ONLY").unwrap_or_default();
    let cache = tempfile::tempdir().unwrap();
    let cache = Cache::new(cache.path());
    let mut depths: Vec<f32> = Vec::new();
    let mut pairs = 0;
    for name in [
        "bedroom",
        "deep_interpenetration",
        "dining_room",
        "living_room",
        "minimal",
        "office",
        "study",
        "tabletop_desk",
        "wall_ceiling",
    ] {
        if !only.is_empty() && !only.split(',').any(|o| name.starts_with(o)) {
            continue;
        }
        let scene = Scene::read(&scenes.join(name).join("truth.json")).unwrap();
        let requests = shape_requests(&scene);
        let start = Instant::now();
        let shapes = build_shapes(&requests, &ShapeSettings::default(), Some(&cache), &|_, _, _| ()).unwrap();
        let first = start.elapsed().as_secs_f32();
        let start = Instant::now();
        let again = build_shapes(&requests, &ShapeSettings::default(), Some(&cache), &|_, _, _| ()).unwrap();
        println!("{name}: {} objects, {first:.1} s, again {:.3} s", requests.len(), start.elapsed().as_secs_f32());
        assert_eq!(shapes, again);
        let world: Vec<Vec<ConvexPolyhedron>> = (scene.objects.iter().zip(&shapes))
            .map(|(object, shape)| {
                let place = |v: &Vec3| (object.pose.rotation * v.as_dvec3() + object.pose.translation).as_vec3();
                let placed = |part: &Part| {
                    let points: Vec<Vec3> = part.vertices.iter().map(place).collect();
                    ConvexPolyhedron::from_convex_hull(&points).unwrap()
                };
                shape.parts.iter().map(placed).collect()
            })
            .collect();
        let identity = Pose3::IDENTITY;
        let mut found: Vec<(f32, String)> = Vec::new();
        for i in 0..world.len() {
            for j in 0..i {
                pairs += 1;
                let mut deepest = 0.0_f32;
                for a in &world[i] {
                    for b in &world[j] {
                        if a.compute_local_aabb().intersects(&b.compute_local_aabb())
                            && let Ok(Some(c)) = parry3d::query::contact(&identity, a, &identity, b, 0.0)
                        {
                            deepest = deepest.max(-c.dist);
                        }
                    }
                }
                if deepest > 0.0 {
                    depths.push(1e3 * deepest);
                    found.push((1e3 * deepest, format!("{} {}", requests[i].name, requests[j].name)));
                }
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (depth, pair) in found.iter().filter(|f| f.0 > 1.0).take(8) {
            println!("  {depth:7.2} mm {pair}");
        }
    }
    let over = |limit: f32| depths.iter().filter(|d| **d > limit).count();
    let deepest = depths.iter().copied().fold(0.0, f32::max);
    println!(
        "{pairs} pairs: {} overlap, {} by more than 1 mm, {} by more than 2 mm, {deepest:.1} mm at most",
        depths.len(),
        over(1.0),
        over(2.0),
    );
    assert!(pairs > 0 && deepest < 5.0, "{deepest} mm");
}
