//! Shapes of meshes that are thin and large, far from their origin, or have parts that are not theirs.
#![allow(clippy::unwrap_used)]

use glam::Vec3;
use proptest::{array::uniform3, collection::vec, prelude::*};
use rest3d_gpu::shape::{Shape, ShapeError, ShapeRequest, ShapeSettings, build_shapes};
use std::path::{Path, PathBuf};

/// Adds a box to an OBJ text.
fn add_box(text: &mut String, low: Vec3, high: Vec3) {
    for i in 0..8 {
        let corner = |axis: usize| if i >> axis & 1 == 1 { high[axis] } else { low[axis] };
        *text += &format!("v {} {} {}\n", corner(0), corner(1), corner(2));
    }
    for [a, b, c, d] in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]] {
        // Numbers count back from the box's own corners.
        *text += &format!("f {} {} {} {}\n", a - 9, b - 9, c - 9, d - 9);
    }
}

fn boxes(folder: &Path, name: &str, boxes: &[[Vec3; 2]]) -> PathBuf {
    let mut text = String::new();
    for [low, high] in boxes {
        add_box(&mut text, *low, *high);
    }
    let file = folder.join(name);
    std::fs::write(&file, text).unwrap();
    file
}

fn build(mesh: PathBuf, convex_parts: Vec<PathBuf>) -> Result<Shape, ShapeError> {
    let (name, category) = ("thing".into(), "rug".into());
    let request =
        ShapeRequest { name, category, mesh, scale: Vec3::ONE, mass: None, convex_parts, up: Vec3::Y, bears: true };
    Ok(build_shapes(&[request], &ShapeSettings::default(), None, &|_, _, _| ())?.remove(0))
}

/// Extent of all parts along each axis, m.
fn extent(shape: &Shape) -> Vec3 {
    let vertices = || shape.parts.iter().flat_map(|part| &part.vertices);
    let (low, high) = vertices().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    high - low
}

/// parry's hull takes a plate that is a thousand times longer than thick for flat and gives none.
#[test]
fn large_thin_plates_keep_their_size() {
    let folder = tempfile::tempdir().unwrap();
    for size in [[4.0, 0.0, 3.0], [10.0, 0.0, 10.0], [4.0, 0.0, 0.1], [10.0, 4.0, 0.003], [6.0, 0.003, 0.003]] {
        let size = Vec3::from_array(size);
        let shape = build(boxes(folder.path(), "plate.obj", &[[Vec3::ZERO, size]]), Vec::new()).unwrap();
        let off = (extent(&shape) - size).abs().max_element();
        assert!(off < 2.1e-3, "{size}: the parts are {} long", extent(&shape));
        assert!(shape.mass.inertia.min_element() > 0.0 && shape.mass.center.is_finite(), "{:?}", shape.mass);
    }
}

#[test]
fn a_large_thin_component_is_not_dropped() {
    let folder = tempfile::tempdir().unwrap();
    let (cube, sheet) = ([Vec3::ZERO, Vec3::splat(0.2)], [Vec3::Y * 0.5, Vec3::new(4.0, 0.5, 3.0)]);
    let shape = build(boxes(folder.path(), "both.obj", &[cube, sheet]), Vec::new()).unwrap();
    assert!(shape.quality.uncovered_max_mm < 1.0, "{:?}", shape.quality);
}

#[test]
fn a_mesh_far_from_its_origin_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let far = Vec3::X * 1e6;
    let error = build(boxes(folder.path(), "far.obj", &[[far, far + 1.0]]), Vec::new()).unwrap_err();
    assert!(matches!(error, ShapeError::Far { .. }), "{error}");
    assert!(error.to_string().contains("thing") && error.to_string().contains("far.obj"), "{error}");
}

#[test]
fn parts_that_are_not_of_the_mesh_are_refused_or_noted() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = || boxes(folder.path(), "mesh.obj", &[[Vec3::ZERO, Vec3::ONE]]);
    let part = |low: Vec3, high: Vec3| build(mesh(), vec![boxes(folder.path(), "part.obj", &[[low, high]])]);
    let error = part(Vec3::splat(3.0), Vec3::splat(4.0)).unwrap_err();
    assert!(matches!(error, ShapeError::Part { .. }) && error.to_string().contains("part.obj"), "{error}");
    let half = part(Vec3::ZERO, Vec3::new(1.0, 0.5, 1.0)).unwrap();
    assert!(half.notes.iter().any(|note| note.contains("uncovered")), "{:?}", half.notes);
    assert_eq!(part(Vec3::ZERO, Vec3::ONE).unwrap().notes, Vec::<String>::new());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Points on a coarse grid, and few of them: triangles without area, in one plane, on one line, twice, in one
    /// point.
    #[test]
    fn any_soup_of_triangles_has_parts_or_an_error(
        corners in vec(uniform3(-3_i32..4), 3..40),
        size in uniform3(prop_oneof![Just(0.0_f32), Just(1e-6), Just(1e-3), Just(0.1), Just(10.0)]),
    ) {
        let size = Vec3::from_array(size);
        let folder = tempfile::tempdir().unwrap();
        let mut text = String::new();
        for corner in &corners[..corners.len() / 3 * 3] {
            let v = size * Vec3::from_array(corner.map(|c| c as f32));
            text += &format!("v {} {} {}\n", v.x, v.y, v.z);
        }
        (0..corners.len() / 3).for_each(|i| text += &format!("f {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3));
        let file = folder.path().join("soup.obj");
        std::fs::write(&file, text).unwrap();
        if let Ok(shape) = build(file, Vec::new()) {
            prop_assert_eq!(shape.alternatives.len(), 2);
            let others = shape.alternatives.iter().map(|other| (&other.parts, &other.mass));
            for (parts, mass) in others.chain([(&shape.parts, &shape.mass)]) {
                prop_assert!(!parts.is_empty() && parts.iter().all(|part| (4..=64).contains(&part.vertices.len())));
                prop_assert!(mass.center.is_finite() && mass.inertia.min_element() > 0.0, "{:?}", mass);
            }
        }
    }
}

/// A can of 24 sides, 76 by 100 mm: cutting it into voxels clips a hull of which parry makes none.
#[test]
fn a_can_has_shapes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("can.obj");
    let mut text = String::new();
    for (y, k) in [-0.05, 0.05].into_iter().flat_map(|y| (0..24).map(move |k| (y, f64::from(k)))) {
        let (sin, cos) = (k / 24.0 * std::f64::consts::TAU).sin_cos();
        text += &format!("v {:.8} {y} {:.8}\n", 0.03790718 * cos, 0.03790718 * sin);
    }
    for k in 0..24 {
        let [a, b] = [k + 1, (k + 1) % 24 + 1];
        text += &format!("f {a} {b} {} {}\n", b + 24, a + 24);
    }
    let around = |first: i32| (0..24).map(|k| format!(" {}", first + k)).collect::<String>();
    text += &format!("f{}\nf{}\n", around(1), around(25));
    std::fs::write(&file, text).unwrap();
    let shape = build(file, Vec::new()).unwrap();
    assert!(shape.alternatives.len() == 2 && shape.alternatives.iter().all(|other| !other.parts.is_empty()));
}
