//! Textures and colours.

use crate::common::meshes::CUBE;
use crate::fixture::*;
use glam::Vec3;
use rest3d_gpu::cpu::CpuPainter;
use rest3d_gpu::render::{Painter, Viewpoint, camera};
use serde_json::json;

#[test]
fn textures_are_seen_and_their_holes_are_seen_through() {
    let case = Case::new();
    case.file("square.gltf", square("quarters.png"));
    case.file("quarters.png", texture());
    let mut scene = document(&[json!({"name": "sign", "mesh": "square.gltf", "position": [0, 0.5, 0]})]);
    scene["room"] = json!({});
    let scene = case.scene(&scene);
    let stage = staged(&scene);
    assert!(stage.notes.is_empty(), "{:?}", stage.notes);
    let camera = camera(Viewpoint::Toward { azimuth: 0.0, elevation: 0.0 }, &scene, &[&stage], SIZE);
    let picture = CpuPainter.paint(&stage, &camera, SIZE).unwrap();
    let at = |x: f64, y: f64| {
        let pixel = (y * 240.0) as usize * 320 + (x * 320.0) as usize;
        Vec3::from_array([0, 1, 2].map(|i| f32::from(picture.rgb[3 * pixel + i])))
    };
    let [red, green, blue, hole] = [at(0.4, 0.35), at(0.6, 0.35), at(0.4, 0.65), at(0.6, 0.65)];
    assert!(red.x > 1.5 * red.y.max(red.z), "{red}");
    assert!(green.y > 1.5 * green.x.max(green.z), "{green}");
    assert!(blue.z > 1.5 * blue.x.max(blue.y), "{blue}");
    assert!(hole.min_element() > 100.0, "{hole}");
}

#[test]
fn a_broken_texture_is_told_and_the_colour_drawn() {
    let case = Case::new();
    case.file("square.gltf", square("quarters.png"));
    let document = document(&[json!({"name": "sign", "mesh": "square.gltf", "position": [0, 0.5, 0]})]);
    for content in [None, Some(&b"no image"[..]), Some(&texture()[..100])] {
        if let Some(content) = content {
            case.file("quarters.png", content);
        }
        let scene = case.scene(&document);
        let stage = staged(&scene);
        let notes = stage.notes.join("\n");
        assert!(notes.contains("square.gltf") && notes.contains("plain colour"), "{notes}");
        assert_eq!(stage.textures.len(), 0);
        shot(&scene, &CpuPainter);
    }
}

/// Colours of OBJ materials and of the vertices of a PLY reach the picture's triangles.
#[test]
fn colours_of_other_formats_are_read() {
    let case = Case::new();
    case.file("red.mtl", "newmtl red\nKd 1 0 0\n");
    case.file("red.obj", format!("mtllib red.mtl\nusemtl red\n{CUBE}"));
    let vertices = "0 0 0 0 0 255\n1 0 0 0 0 255\n0 1 0 0 0 255\n";
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                  property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n\
                  property list uchar int vertex_indices\nend_header\n";
    case.file("blue.ply", format!("{header}{vertices}3 0 1 2\n"));
    for (mesh, color) in [("red.obj", [255, 0, 0]), ("blue.ply", [0, 0, 255])] {
        let scene = case.scene(&document(&[json!({"name": "x", "mesh": mesh})]));
        let stage = staged(&scene);
        assert_eq!(stage.vertices[0].color.to_le_bytes()[..3], color, "{mesh}");
        assert!(stage.notes.is_empty(), "{:?}", stage.notes);
    }
}
