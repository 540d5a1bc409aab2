//! Scenes to draw, and pictures compared.

use crate::common::meshes::CUBE;
use base64::Engine;
use rest3d_gpu::render::{Models, Painter, Picture, Size, Stage, Viewpoint, camera, stage};
use rest3d_gpu::scene::Scene;
use serde_json::{Value, json};
use std::fs;
use tempfile::TempDir;

pub const SIZE: Size = Size { width: 320, height: 240 };

/// A folder with meshes, removed at the end.
pub struct Case(TempDir);

impl Case {
    pub fn new() -> Self {
        let case = Self(tempfile::tempdir().unwrap());
        case.file("cube.obj", CUBE);
        case
    }

    pub fn file(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.0.path().join(name), content).unwrap();
    }

    pub fn scene(&self, document: &Value) -> Scene {
        self.file("scene.json", document.to_string());
        Scene::read(self.0.path()).unwrap()
    }
}

pub fn cuboid(name: &str, position: [f64; 3], size: [f64; 3]) -> Value {
    json!({"name": name, "mesh": "cube.obj", "position": position, "scale": size})
}

pub fn document(objects: &[Value]) -> Value {
    let walls = json!([{"name": "back", "point": [0, 0, -1], "normal": [0, 0, 1]}]);
    json!({"format": "rest3d-scene", "version": 1, "room": {"walls": walls}, "objects": objects})
}

/// A table's worth of boxes before a wall.
pub fn boxes() -> Vec<Value> {
    vec![
        cuboid("desk", [0.0, 0.35, 0.0], [1.2, 0.7, 0.6]),
        cuboid("box", [0.2, 0.8, 0.1], [0.2, 0.2, 0.2]),
        cuboid("stool", [0.1, 0.2, 0.9], [0.3, 0.4, 0.3]),
    ]
}

/// Everything that a picture can show: boxes, a wall, a texture with holes, a pane that stands for a wall.
pub fn everything(case: &Case) -> Scene {
    case.file("square.gltf", square("quarters.png"));
    case.file("quarters.png", texture());
    let mut objects = boxes();
    objects.push(json!({"name": "sign", "mesh": "square.gltf", "position": [-0.7, 0.6, 0.8]}));
    let mut pane = cuboid("pane", [0.9, 0.5, 0.6], [0.05, 1.0, 0.6]);
    (pane["category"], pane["movable"]) = ("wall".into(), false.into());
    objects.push(pane);
    case.scene(&document(&objects))
}

/// A PNG of four coloured quarters, the last one transparent.
pub fn texture() -> Vec<u8> {
    let mut pixels = image::RgbaImage::new(64, 64);
    for (x, y, pixel) in pixels.enumerate_pixels_mut() {
        *pixel = image::Rgba(match (x < 32, y < 32) {
            (true, true) => [220, 40, 40, 255],
            (false, true) => [40, 200, 60, 255],
            (true, false) => [50, 70, 220, 255],
            (false, false) => [0, 0, 0, 0],
        });
    }
    let mut bytes = Vec::new();
    pixels.write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Png).unwrap();
    bytes
}

/// A glTF of one upright square with a texture, holes where it is transparent.
pub fn square(image: &str) -> String {
    let numbers: [f32; 20] = [
        -0.5, -0.5, 0.0, 0.5, -0.5, 0.0, 0.5, 0.5, 0.0, -0.5, 0.5, 0.0, // positions
        0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, // places in the texture
    ];
    let mut bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0, 1, 2, 0, 2, 3_u16].iter().flat_map(|i| i.to_le_bytes()));
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    json!({
        "asset": {"version": "2.0"},
        "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "alphaMode": "MASK", "alphaCutoff": 0.5
        }],
        "textures": [{"source": 0}], "images": [{"uri": image}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
             "min": [-0.5, -0.5, 0], "max": [0.5, 0.5, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 32},
            {"buffer": 0, "byteOffset": 80, "byteLength": 12}
        ],
        "buffers": [{"byteLength": 92, "uri": format!("data:application/octet-stream;base64,{data}")}]
    })
    .to_string()
}

pub fn staged(scene: &Scene) -> Stage {
    stage(scene, &mut Models::default()).unwrap()
}

pub fn shot(scene: &Scene, painter: &dyn Painter) -> Picture {
    let stage = staged(scene);
    painter.paint(&stage, &camera(Viewpoint::Auto, scene, &[&stage], SIZE), SIZE).unwrap()
}

/// Mean difference of the bytes, and share of the pixels that differ by more than a sixteenth of the range.
fn difference(a: &Picture, b: &Picture) -> (f64, f64) {
    assert_eq!(a.size, b.size);
    let off = |(a, b): (&u8, &u8)| f64::from(a.abs_diff(*b));
    let mean = a.rgb.iter().zip(&b.rgb).map(off).sum::<f64>() / a.rgb.len() as f64;
    let pixels = a.rgb.chunks_exact(3).zip(b.rgb.chunks_exact(3));
    let differing = pixels.filter(|(a, b)| a.iter().zip(*b).any(|both| off(both) > 16.0)).count();
    (mean, differing as f64 / (a.rgb.len() / 3) as f64)
}

pub fn agree(a: &Picture, b: &Picture) -> bool {
    let (mean, differing) = difference(a, b);
    eprintln!("mean difference {mean:.3}, differing pixels {:.3} %", 100.0 * differing);
    mean < 0.3 && differing < 2e-3
}
