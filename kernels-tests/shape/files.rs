//! Parts on disk: ready-made ones, the cache, and what is written.

use crate::fixture::*;
use glam::Vec3;
use rest3d_gpu::shape::{Cache, PADDING, Shape, ShapeRequest, ShapeSettings, build_shapes, part_obj, read_mesh};

#[test]
fn ready_made_parts_are_used() {
    let directory = tempfile::tempdir().unwrap();
    let (vertices, triangles) = cuboid([0.0; 3], [1.0; 3]);
    let mesh = obj(directory.path(), "mesh.obj", &vertices, &triangles);
    let (low, _) = cuboid([0.0; 3], [1.0, 0.5, 1.0]);
    let mut ball = Vec::new();
    for i in 0..200 {
        let (y, a) = (1.0 - (i as f32 + 0.5) / 100.0, 2.4 * i as f32);
        let r = (1.0 - y * y).sqrt();
        ball.push([0.5 + 0.5 * r * a.cos(), 0.5 + 0.5 * y, 0.5 + 0.5 * r * a.sin()]);
    }
    // The hull is what counts: any triangles that name all points will do.
    let fan: Vec<[u32; 3]> = (2..200).map(|i| [0, i - 1, i]).collect();
    let mut request = of_file(mesh, "box");
    request.convex_parts =
        vec![obj(directory.path(), "a.obj", &low, &triangles), obj(directory.path(), "b.obj", &ball, &fan)];
    let shape = build(request.clone(), None);
    check("ready-made", &shape);
    assert!(shape.parts.iter().any(|p| p.vertices.len() == 8));
    assert!(shape.parts.iter().all(|p| p.vertices.len() <= 64));
    // What has too many corners is cut up, not cut down.
    let kept = |corner: &[f32; 3]| {
        shape.parts.iter().flat_map(|p| &p.vertices).any(|v| v.distance(Vec3::from(*corner) * request.scale) < 1e-5)
    };
    assert!(ball.iter().all(kept));
    assert!(shape.notes.iter().any(|n| n.contains("convex_parts[1]") && n.contains("200")), "{:?}", shape.notes);

    request.convex_parts.push(directory.path().join("missing.obj"));
    let error = build_shapes(&[request], &ShapeSettings::default(), None, &|_, _, _| ()).unwrap_err().to_string();
    assert!(error.contains("thing") && error.contains("convex_parts") && error.contains("missing.obj"), "{error}");
}

#[test]
fn cache_gives_the_same_and_survives_damage() {
    let directory = tempfile::tempdir().unwrap();
    let (mut vertices, mut triangles) = cuboid([0.0; 3], [0.4, 0.05, 0.4]);
    let (back, more) = cuboid([0.0, 0.05, 0.0], [0.05, 0.4, 0.4]);
    vertices.extend(back);
    triangles.extend(more.iter().map(|t| t.map(|i| i + 8)));
    let request = of_file(obj(directory.path(), "seat.obj", &vertices, &triangles), "chair");
    let cache = Cache::new(directory.path().join("cache"));
    let first = build(request.clone(), Some(&cache));
    assert_eq!(first.parts.len(), 2);
    assert_eq!(build(request.clone(), None), first, "not deterministic");
    assert_eq!(build(request.clone(), Some(&cache)), first);
    let entries = std::fs::read_dir(cache.directory()).unwrap().map(|entry| entry.unwrap().path());
    let entries: Vec<_> = entries.collect();
    assert_eq!(entries.len(), 2);
    for entry in entries {
        let whole = std::fs::read(&entry).unwrap();
        // A canary: what is in the entry is what comes out.
        let mut other = whole.clone();
        let digit = other.iter().rposition(|b| *b == b'8').unwrap();
        other[digit] = b'7';
        for damaged in [&whole[..whole.len() / 2], &whole[..10], &[], &other] {
            std::fs::write(&entry, damaged).unwrap();
            assert_eq!(build(request.clone(), Some(&cache)), first);
            assert_eq!(std::fs::read(&entry).unwrap(), whole, "not repaired");
        }
    }
    // A file where the directory should be: the same shape, and whoever asks is told.
    let blocked = Cache::new(request.mesh.clone());
    assert_eq!(build(request.clone(), Some(&blocked)), first);
    assert!(cache.check().is_ok() && blocked.check().is_err_and(|warning| warning.contains("not usable")));
    // The mass is no part of the entry.
    let heavy = build(ShapeRequest { mass: Some(7.0), ..request }, Some(&cache));
    assert_eq!((heavy.mass.mass, &heavy.parts), (7.0, &first.parts));
}

#[test]
fn what_wants_no_second_opinions_has_the_same_parts() {
    let directory = tempfile::tempdir().unwrap();
    let (vertices, triangles) = cuboid([0.0; 3], [0.4, 0.05, 0.4]);
    let request = of_file(obj(directory.path(), "seat.obj", &vertices, &triangles), "chair");
    let cache = Cache::new(directory.path().join("cache"));
    let entries = || std::fs::read_dir(cache.directory()).unwrap().count();
    let without = ShapeSettings { alternatives: false, ..Default::default() };
    let plain =
        || build_shapes(std::slice::from_ref(&request), &without, Some(&cache), &|_, _, _| ()).unwrap().remove(0);
    let first = plain();
    assert_eq!((first.alternatives.len(), entries()), (0, 1));
    let full = build(request.clone(), Some(&cache));
    assert_eq!((full.alternatives.len(), entries()), (2, 2), "the parts are those that were there");
    assert!(full.alternatives.iter().all(|other| !other.parts.is_empty()));
    assert_eq!(Shape { alternatives: Vec::new(), ..full }, first);
    assert_eq!(plain(), first);
    // Alternatives are those of the mesh, whatever its own parts are.
    build(ShapeRequest { category: "plant".into(), ..request.clone() }, Some(&cache));
    assert_eq!(entries(), 3);
}

#[test]
fn parts_are_written_in_the_mesh_frame() {
    let directory = tempfile::tempdir().unwrap();
    let (vertices, triangles) = cuboid([1.0; 3], [2.0, 3.0, 4.0]);
    let mut request = of_file(obj(directory.path(), "box.obj", &vertices, &triangles), "");
    request.scale = Vec3::new(0.1, 0.2, 0.3);
    let shape = build(request.clone(), None);
    let file = directory.path().join("part.obj");
    std::fs::write(&file, part_obj(&shape.parts[0], request.scale)).unwrap();
    let read = read_mesh(&file).unwrap();
    let padded = |c: &[f32; 3]| {
        let corner = Vec3::from_array(*c);
        corner + (corner - Vec3::new(1.5, 2.0, 2.5)).signum() * PADDING / request.scale
    };
    let found = |c: &[f32; 3]| read.vertices.iter().any(|v| v.distance(padded(c)) < 1e-5);
    assert!(read.vertices.len() == 8 && vertices.iter().all(found), "{read:?}");
    let volume: f32 = read
        .triangles
        .iter()
        .map(|t| t.map(|i| read.vertices[i as usize]))
        .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
        .sum();
    let whole: f32 = (Vec3::new(1.0, 2.0, 3.0) + 2.0 * PADDING / request.scale).to_array().iter().product();
    assert!((volume - whole).abs() < 1e-4, "outward triangles: {volume}");
    // Back again as ready-made parts: the same shape.
    request.convex_parts = vec![file];
    let again = build(request, None);
    let found = |v: &Vec3| shape.parts[0].vertices.iter().any(|w| v.distance(*w) < 1e-6);
    assert!(again.parts.len() == 1 && again.parts[0].vertices.iter().all(found));
}
