//! The same tetrahedron in every format.

use glam::Vec3;
use rest3d_gpu::shape::{Mesh, MeshError, read_mesh};
use serde_json::{Value, json};
use std::fs;

/// The tetrahedron that every sample holds.
pub const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, -2.25]];
pub const FACES: [[u32; 3]; 4] = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];

pub fn read_bytes(name: &str, bytes: impl AsRef<[u8]>) -> Result<Mesh, MeshError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    read_mesh(&path)
}

/// Every triangle's corners: what a mesh is, whatever the numbering of its vertices.
pub fn surface(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    mesh.triangles.iter().map(|t| t.map(|i| mesh.vertices[i as usize])).collect()
}

pub fn tetrahedron() -> Vec<[Vec3; 3]> {
    FACES.iter().map(|face| face.map(|i| CORNERS[i as usize].into())).collect()
}

pub fn floats(numbers: impl IntoIterator<Item = f32>) -> Vec<u8> {
    numbers.into_iter().flat_map(f32::to_le_bytes).collect()
}

pub fn obj() -> String {
    let mut text = "# tetrahedron\nmtllib absent.mtl\no thing\n".to_owned();
    for [x, y, z] in CORNERS {
        text += &format!("v {x} {y} {z}\n");
    }
    text += "vn 0 0 1\nvt 0 0\nusemtl wood\ns off\n";
    for [a, b, c] in FACES.map(|face| face.map(|i| i + 1)) {
        text += &format!("f {a}/1/1 {b}//1 {c}\n");
    }
    text
}

pub fn ply_header(encoding: &str) -> String {
    format!(
        "ply\nformat {encoding} 1.0\ncomment sample\nelement vertex 4\nproperty float x\nproperty float y\n\
         property float z\nproperty uchar red\nelement face 4\nproperty list uchar int vertex_indices\n\
         property float quality\nend_header\n"
    )
}

pub fn ply_text() -> String {
    let vertices = CORNERS.map(|[x, y, z]| format!("{x} {y} {z} 255\n")).concat();
    let faces = FACES.map(|[a, b, c]| format!("3 {a} {b} {c} 0.5\n")).concat();
    ply_header("ascii") + &vertices + &faces
}

pub fn ply_binary(big: bool) -> Vec<u8> {
    let four = |bytes: [u8; 4]| if big { [bytes[3], bytes[2], bytes[1], bytes[0]] } else { bytes };
    let mut bytes = ply_header(if big { "binary_big_endian" } else { "binary_little_endian" }).into_bytes();
    for corner in CORNERS {
        bytes.extend(corner.iter().flat_map(|x| four(x.to_le_bytes())));
        bytes.push(255);
    }
    for face in FACES {
        bytes.push(3);
        bytes.extend(face.iter().flat_map(|i| four(i.to_le_bytes())));
        bytes.extend(four(0.5f32.to_le_bytes()));
    }
    bytes
}

pub fn stl_text() -> String {
    let facet = |corners: [Vec3; 3]| {
        let lines: String = corners.iter().map(|v| format!("    vertex {} {} {}\n", v.x, v.y, v.z)).collect();
        format!("  facet normal 0 0 0\n   outer loop\n{lines}   endloop\n  endfacet\n")
    };
    // Two solids, the first without a name.
    let facets: Vec<String> = tetrahedron().into_iter().map(facet).collect();
    format!("solid\n{}endsolid\nsolid second\n{}endsolid second\n", facets[..1].concat(), facets[1..].concat())
}

pub fn stl_binary(header: &[u8]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend(4u32.to_le_bytes());
    for corners in tetrahedron() {
        bytes.extend(floats([0.0; 3].into_iter().chain(corners.iter().flat_map(|v| v.to_array()))));
        bytes.extend([0; 2]);
    }
    bytes
}

/// Positions of the tetrahedron, then its vertex numbers as u16.
pub fn buffer() -> Vec<u8> {
    let numbers = FACES.as_flattened().iter().flat_map(|&i| (i as u16).to_le_bytes());
    floats(CORNERS.into_iter().flatten()).into_iter().chain(numbers).collect()
}

/// A document with one node, one mesh, one primitive over [`buffer`].
pub fn document() -> Value {
    json!({
        "asset": {"version": "2.0", "extras": 7},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "thing"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "_CUSTOM": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"uri": "absent.png"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 24}
        ],
        "buffers": [{"byteLength": 72}]
    })
}

pub fn glb(document: &Value, chunk: &[u8]) -> Vec<u8> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut chunk = chunk.to_vec();
    chunk.resize(chunk.len().next_multiple_of(4), 0);
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + text.len() as u32 + chunk.len() as u32).to_le_bytes());
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(text);
    bytes.extend((chunk.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(chunk);
    bytes
}

/// The default document after a change, over the default buffer with more bytes at its end.
pub fn changed(change: impl FnOnce(&mut Value), more: &[u8]) -> Vec<u8> {
    let mut document = document();
    document["buffers"][0]["byteLength"] = (72 + more.len()).into();
    change(&mut document);
    glb(&document, &[&buffer(), more].concat())
}

pub fn gltf_with_data_uri() -> String {
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(buffer());
    let mut document = document();
    document["buffers"][0]["uri"] = format!("data:application/octet-stream;base64,{data}").into();
    document.to_string()
}

/// One valid file of every format.
pub fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let sparse = changed(add_sparse, &sparse_bytes());
    vec![
        ("a.obj", obj().into_bytes()),
        ("text.ply", ply_text().into_bytes()),
        ("little.ply", ply_binary(false)),
        ("big.ply", ply_binary(true)),
        ("text.stl", stl_text().into_bytes()),
        ("binary.stl", stl_binary(b"exported")),
        ("solid.stl", stl_binary(b"solid exported")),
        ("a.glb", glb(&document(), &buffer())),
        ("sparse.glb", sparse),
        ("a.gltf", gltf_with_data_uri().into_bytes()),
    ]
}

/// Makes the positions sparse: vertices 1 and 3 come from [`sparse_bytes`] (equal to what they replace).
pub fn add_sparse(document: &mut Value) {
    document["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": {"bufferView": 2, "componentType": 5121},
        "values": {"bufferView": 3}
    });
    let views = document["bufferViews"].as_array_mut().unwrap();
    views.push(json!({"buffer": 0, "byteOffset": 72, "byteLength": 2}));
    views.push(json!({"buffer": 0, "byteOffset": 76, "byteLength": 24}));
}

pub fn sparse_bytes() -> Vec<u8> {
    let values = floats([CORNERS[1], CORNERS[3]].into_iter().flatten());
    [vec![1, 3, 0, 0], values].concat()
}

pub fn assert_problem(result: Result<Mesh, MeshError>, file: &str, problem: &str) {
    let message = result.expect_err(problem).to_string();
    assert!(message.contains(file) && message.contains(problem) && message.contains("; "), "{message}");
    assert!(!message.contains('\n') && message.len() < 600, "{message}");
}
