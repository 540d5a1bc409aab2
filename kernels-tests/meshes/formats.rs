//! What each format may say, and what is read of it.

use crate::fixture::*;
use glam::Vec3;
use rest3d_gpu::shape::{Mesh, read_mesh};
use serde_json::{Value, json};
use std::f32::consts::FRAC_1_SQRT_2;
use std::fs;

#[test]
fn every_format_gives_the_same_surface() {
    for (name, bytes) in samples() {
        let mesh = read_bytes(name, bytes).unwrap();
        assert_eq!(surface(&mesh), tetrahedron(), "{name}");
    }
}

#[test]
fn content_decides_over_the_extension() {
    for (name, bytes) in [("ply.obj", ply_text().into_bytes()), ("glb.stl", glb(&document(), &buffer()))] {
        assert_eq!(surface(&read_bytes(name, bytes).unwrap()), tetrahedron(), "{name}");
    }
}

#[test]
fn gltf_finds_its_buffer_beside_it_and_asks_for_no_image() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = document();
    document["buffers"][0]["uri"] = "my%20buffer.bin".into();
    // A second buffer that nothing but an image uses need not be there.
    document["buffers"].as_array_mut().unwrap().push(json!({"uri": "absent.bin", "byteLength": 9}));
    fs::write(folder.path().join("my buffer.bin"), buffer()).unwrap();
    let path = folder.path().join("a.gltf");
    fs::write(&path, document.to_string()).unwrap();
    assert_eq!(surface(&read_mesh(&path).unwrap()), tetrahedron());
    fs::remove_file(folder.path().join("my buffer.bin")).unwrap();
    assert_problem(read_mesh(&path), "a.gltf", "my buffer.bin");
}

#[test]
fn transforms_of_all_nodes_are_applied() {
    let bytes = changed(
        |document| {
            document["nodes"] = json!([
                {"children": [1, 2], "scale": [2, 2, 2]},
                {"mesh": 0, "translation": [1, 0, 0]},
                {"mesh": 0, "rotation": [0, 0, FRAC_1_SQRT_2, FRAC_1_SQRT_2]},
                {"mesh": 0, "translation": [9, 9, 9], "name": "not in the scene"}
            ]);
        },
        &[],
    );
    let mesh = read_bytes("a.glb", bytes).unwrap();
    let moved = |f: fn(Vec3) -> Vec3| tetrahedron().into_iter().map(move |t| t.map(f));
    let expected = moved(|v| 2.0 * (v + Vec3::X)).chain(moved(|v| 2.0 * Vec3::new(-v.y, v.x, v.z)));
    let surface = surface(&mesh);
    let distance = surface.as_flattened().iter().zip(expected.flatten()).map(|(a, b)| a.distance(b));
    // The quaternion is rounded to single precision.
    assert_eq!(mesh.triangles.len(), 8);
    assert!(distance.fold(0.0, f32::max) < 1e-6);
}

#[test]
fn mirrored_nodes_stay_right_side_out() {
    let volume = |mesh: &Mesh| surface(mesh).iter().map(|[a, b, c]| a.dot(b.cross(*c)) / 6.0).sum::<f32>();
    let plain = volume(&read_bytes("a.glb", glb(&document(), &buffer())).unwrap());
    for node in [
        json!({"mesh": 0, "scale": [-1, 1, 1]}),
        json!({"mesh": 0, "matrix": [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1]}),
    ] {
        let mirrored = read_bytes("a.glb", changed(|document| document["nodes"] = json!([node]), &[])).unwrap();
        // Exact: the same products, only signs differ, apart from the shift by 3 along x.
        assert!((volume(&mirrored) - plain).abs() < 1e-5, "{} {plain}", volume(&mirrored));
    }
}

#[test]
fn all_kinds_of_primitives() {
    let primitives = |list: Value| changed(move |document| document["meshes"][0]["primitives"] = list, &[]);
    let corners = |mesh: Mesh| mesh.triangles;
    let attributes = json!({"POSITION": 0});
    for (primitive, expected) in [
        (json!({"attributes": attributes}), vec![[0, 1, 2]]),
        (json!({"attributes": attributes, "mode": 5}), vec![[0, 1, 2], [2, 1, 3]]),
        (json!({"attributes": attributes, "mode": 6}), vec![[0, 1, 2], [0, 2, 3]]),
    ] {
        assert_eq!(corners(read_bytes("a.glb", primitives(json!([primitive]))).unwrap()), expected);
    }
    // Points, lines and primitives without positions are passed over, what stands beside them is not.
    let mixed = json!([
        {"attributes": attributes, "mode": 0}, {"attributes": attributes, "mode": 1}, {"attributes": {}},
        {"attributes": attributes}, {"attributes": attributes}
    ]);
    assert_eq!(corners(read_bytes("a.glb", primitives(mixed)).unwrap()), [[0, 1, 2], [4, 5, 6]]);
}

#[test]
fn vertex_numbers_of_every_width() {
    for (kind, bytes) in [
        (5121, FACES.as_flattened().iter().map(|&i| i as u8).collect::<Vec<_>>()),
        (5125, FACES.as_flattened().iter().flat_map(|&i| i.to_le_bytes()).collect()),
    ] {
        let change = |document: &mut Value| {
            document["bufferViews"][1] = json!({"buffer": 0, "byteOffset": 72, "byteLength": bytes.len()});
            document["accessors"][1]["componentType"] = kind.into();
        };
        assert_eq!(surface(&read_bytes("a.glb", changed(change, &bytes)).unwrap()), tetrahedron());
    }
}

#[test]
fn interleaved_and_quantized_positions() {
    // Each vertex: three i16, two bytes of padding, four of a colour.
    let bytes: Vec<u8> = CORNERS
        .iter()
        .flat_map(|c| c.map(|x| (x * 4.0) as i16).into_iter().flat_map(i16::to_le_bytes).chain([9; 6]))
        .collect();
    let change = |document: &mut Value| {
        document["bufferViews"][0] = json!({"buffer": 0, "byteOffset": 72, "byteLength": 48, "byteStride": 12});
        document["accessors"][0]["componentType"] = 5122.into();
        document["nodes"][0]["scale"] = json!([0.25, 0.25, 0.25]);
        document["extensionsRequired"] = json!(["KHR_mesh_quantization", "KHR_texture_basisu"]);
    };
    assert_eq!(surface(&read_bytes("a.glb", changed(change, &bytes)).unwrap()), tetrahedron());
}

#[test]
fn sparse_positions_over_nothing() {
    // Without a base all others are zero: triangle (1, 3, 2) keeps two corners.
    let change = |document: &mut Value| {
        add_sparse(document);
        document["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    };
    let mesh = read_bytes("a.glb", changed(change, &sparse_bytes())).unwrap();
    assert_eq!(surface(&mesh)[3], [CORNERS[1].into(), CORNERS[3].into(), Vec3::ZERO]);
}

#[test]
fn without_scenes_the_top_nodes_count() {
    let change = |document: &mut Value| {
        document.as_object_mut().unwrap().retain(|key, _| !key.starts_with("scene"));
        document["nodes"] = json!([{"mesh": 0, "translation": [1, 0, 0]}, {"children": [0], "scale": [2, 2, 2]}]);
    };
    let mesh = read_bytes("a.glb", changed(change, &[])).unwrap();
    assert_eq!((mesh.vertices[0], mesh.triangles.len()), (2.0 * Vec3::X, 4));
}

#[test]
fn obj_peculiarities() {
    let text = "v 0 0 0 1 0 0\nv 1 0 0\r\nv 1 1 \\\n 0\nv 0 1 0\nvt 0\n# caf\u{e9}\ng a b\n\
                f 1 2 3 4\nl 1 2\nf -4 -3 -2\nv 0.5 2 0\nf 1/9/9 2/9/9 3/9/9 5 4\n";
    // The comment as Latin-1, which is not UTF-8.
    let bytes: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let mesh = read_bytes("a.obj", bytes).unwrap();
    assert_eq!(mesh.vertices.len(), 5);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 1, 2], [0, 2, 4], [0, 4, 3]]);
}

/// The cap of an L-shaped prism, as modelling programs write it: filled alike whichever corner comes first.
#[test]
fn a_concave_face_is_filled_in_every_format_that_has_one() {
    let corners = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]];
    for first in 0..corners.len() {
        let numbers: Vec<usize> = (0..corners.len()).map(|i| (first + i) % corners.len()).collect();
        let rows = |prefix: &str| corners.map(|[x, y]| format!("{prefix}{x} {y} 0\n")).concat();
        let face = |base: usize| numbers.iter().map(|i| format!(" {}", i + base)).collect::<String>();
        let obj = format!("{}f{}\n", rows("v "), face(1));
        let ply = format!(
            "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n{}6{}\n",
            rows(""),
            face(0)
        );
        for (name, text) in [("a.obj", obj), ("a.ply", ply)] {
            let mesh = read_bytes(name, text.into_bytes()).unwrap();
            let area = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|i| mesh.vertices[i as usize]);
                0.5 * (b - a).cross(c - a).z
            };
            let areas: Vec<f32> = mesh.triangles.iter().map(area).collect();
            assert!(
                areas.iter().all(|area| *area > 0.0) && areas.iter().sum::<f32>() == 3.0,
                "{name} {first}: {areas:?}"
            );
        }
    }
}

#[test]
fn ply_peculiarities() {
    let text = "ply\r\nformat ascii 1.0\r\nobj_info x\r\nelement camera 1\r\nproperty double focal\r\n\
                element vertex 4\r\nproperty double z\r\nproperty double y\r\nproperty int x\r\n\
                element face 1\r\nproperty list uchar float uv\r\nproperty list uchar uint vertex_index\r\n\
                element tristrips 1\r\nproperty list int int vertex_indices\r\nelement edge 0\r\nend_header\r\n\
                1.5\r\n0 0 0\r\n0 0 1\r\n0 1 1\r\n0 1 0\r\n2 0.5 0.5 4 0 1 2 3\r\n8 0 1 2 3 -1 3 2 1\r\n";
    let mesh = read_bytes("a.ply", text).unwrap();
    assert_eq!(mesh.vertices[2], Vec3::new(1.0, 1.0, 0.0));
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2], [2, 1, 3], [3, 2, 1]]);
}
