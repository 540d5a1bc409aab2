//! Mesh files: one tetrahedron in every format, the peculiarities of real files, and damage of every kind.
#![allow(clippy::unwrap_used)]

use glam::Vec3;
use proptest::prelude::*;
use rest3d_gpu::shape::{Mesh, MeshError, read_mesh};
use serde_json::{Value, json};
use std::f32::consts::FRAC_1_SQRT_2;
use std::fs;
use std::path::{Path, PathBuf};

/// The tetrahedron that every sample holds.
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, -2.25]];
const FACES: [[u32; 3]; 4] = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];

fn read_bytes(name: &str, bytes: impl AsRef<[u8]>) -> Result<Mesh, MeshError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    read_mesh(&path)
}

/// Every triangle's corners: what a mesh is, whatever the numbering of its vertices.
fn surface(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    mesh.triangles.iter().map(|t| t.map(|i| mesh.vertices[i as usize])).collect()
}

fn tetrahedron() -> Vec<[Vec3; 3]> {
    FACES.iter().map(|face| face.map(|i| CORNERS[i as usize].into())).collect()
}

fn floats(numbers: impl IntoIterator<Item = f32>) -> Vec<u8> {
    numbers.into_iter().flat_map(f32::to_le_bytes).collect()
}

fn obj() -> String {
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

fn ply_header(encoding: &str) -> String {
    format!(
        "ply\nformat {encoding} 1.0\ncomment sample\nelement vertex 4\nproperty float x\nproperty float y\n\
         property float z\nproperty uchar red\nelement face 4\nproperty list uchar int vertex_indices\n\
         property float quality\nend_header\n"
    )
}

fn ply_text() -> String {
    let vertices = CORNERS.map(|[x, y, z]| format!("{x} {y} {z} 255\n")).concat();
    let faces = FACES.map(|[a, b, c]| format!("3 {a} {b} {c} 0.5\n")).concat();
    ply_header("ascii") + &vertices + &faces
}

fn ply_binary(big: bool) -> Vec<u8> {
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

fn stl_text() -> String {
    let facet = |corners: [Vec3; 3]| {
        let lines: String = corners.iter().map(|v| format!("    vertex {} {} {}\n", v.x, v.y, v.z)).collect();
        format!("  facet normal 0 0 0\n   outer loop\n{lines}   endloop\n  endfacet\n")
    };
    // Two solids, the first without a name.
    let facets: Vec<String> = tetrahedron().into_iter().map(facet).collect();
    format!("solid\n{}endsolid\nsolid second\n{}endsolid second\n", facets[..1].concat(), facets[1..].concat())
}

fn stl_binary(header: &[u8]) -> Vec<u8> {
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
fn buffer() -> Vec<u8> {
    let numbers = FACES.as_flattened().iter().flat_map(|&i| (i as u16).to_le_bytes());
    floats(CORNERS.into_iter().flatten()).into_iter().chain(numbers).collect()
}

/// A document with one node, one mesh, one primitive over [`buffer`].
fn document() -> Value {
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

fn glb(document: &Value, chunk: &[u8]) -> Vec<u8> {
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
fn changed(change: impl FnOnce(&mut Value), more: &[u8]) -> Vec<u8> {
    let mut document = document();
    document["buffers"][0]["byteLength"] = (72 + more.len()).into();
    change(&mut document);
    glb(&document, &[&buffer(), more].concat())
}

fn gltf_with_data_uri() -> String {
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(buffer());
    let mut document = document();
    document["buffers"][0]["uri"] = format!("data:application/octet-stream;base64,{data}").into();
    document.to_string()
}

/// One valid file of every format.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
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

/// Makes the positions sparse: vertices 1 and 3 come from [`sparse_bytes`] (equal to what they replace).
fn add_sparse(document: &mut Value) {
    document["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": {"bufferView": 2, "componentType": 5121},
        "values": {"bufferView": 3}
    });
    let views = document["bufferViews"].as_array_mut().unwrap();
    views.push(json!({"buffer": 0, "byteOffset": 72, "byteLength": 2}));
    views.push(json!({"buffer": 0, "byteOffset": 76, "byteLength": 24}));
}

fn sparse_bytes() -> Vec<u8> {
    let values = floats([CORNERS[1], CORNERS[3]].into_iter().flatten());
    [vec![1, 3, 0, 0], values].concat()
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
                f 1 2 3 4\nl 1 2\nf -4 -3 -2\nv 2 2 2\nf 1/9/9 2/9/9 3/9/9 5 4\n";
    // The comment as Latin-1, which is not UTF-8.
    let bytes: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let mesh = read_bytes("a.obj", bytes).unwrap();
    assert_eq!(mesh.vertices.len(), 5);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 1, 2], [0, 2, 4], [0, 4, 3]]);
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

fn assert_problem(result: Result<Mesh, MeshError>, file: &str, problem: &str) {
    let message = result.expect_err(problem).to_string();
    assert!(message.contains(file) && message.contains(problem) && message.contains("; "), "{message}");
    assert!(!message.contains('\n') && message.len() < 600, "{message}");
}

#[test]
fn damaged_files_are_named() {
    let text = |old: &str, new: &str, of: String| of.replacen(old, new, 1).into_bytes();
    let ply = |old: &str, new: &str| text(old, new, ply_text());
    let set =
        |pointer: &'static str, value: Value| changed(|document| *document.pointer_mut(pointer).unwrap() = value, &[]);
    let mut nan = buffer();
    nan[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let mut short_header = glb(&document(), &buffer());
    short_header[8..12].copy_from_slice(&4u32.to_le_bytes());
    let mut version = glb(&document(), &buffer());
    version[4] = 1;
    for (name, bytes, problem) in [
        ("empty.glb", vec![], "does not begin"),
        ("not.glb", b"<html>".to_vec(), "does not begin"),
        ("json.glb", document().to_string().into_bytes(), "does not begin"),
        ("four.glb", b"glTF".to_vec(), "breaks off"),
        ("short.glb", short_header, "breaks off"),
        ("cut.glb", glb(&document(), &buffer())[..200].to_vec(), "breaks off"),
        ("version.glb", version, "not a GLB"),
        ("nan.glb", glb(&document(), &nan), "not finite"),
        ("zero.glb", set("/nodes/0", json!({"mesh": 0, "rotation": [0, 0, 0, 0]})), "not finite"),
        ("count.glb", set("/accessors/0/count", json!(5)), "breaks off"),
        ("absurd.glb", set("/accessors/0/count", json!(1u64 << 62)), "more than"),
        (
            "offset.glb",
            set(
                "/accessors/0",
                json!({"bufferView": 0, "byteOffset": u64::MAX, "componentType": 5126, "count": 4, "type": "VEC3"}),
            ),
            "breaks off",
        ),
        ("view.glb", set("/bufferViews/1/byteOffset", json!(u64::MAX)), "breaks off"),
        (
            "stride.glb",
            set("/bufferViews/0", json!({"buffer": 0, "byteLength": 48, "byteStride": u64::MAX})),
            "breaks off",
        ),
        ("none.glb", set("/accessors/1/count", json!(0)), "no triangles"),
        ("empty_positions.glb", set("/accessors/0/count", json!(0)), "a face names vertex"),
        ("index.glb", set("/accessors/0/count", json!(3)), "a face names vertex 3"),
        ("accessor.glb", set("/meshes/0/primitives/0/indices", json!(7)), "no accessor 7"),
        ("type.glb", set("/accessors/0/type", json!("VEC2")), "accessor 0 is not"),
        ("float.glb", set("/accessors/1/componentType", json!(5126)), "not unsigned"),
        ("mesh.glb", set("/nodes/0/mesh", json!(3)), "a mesh is missing"),
        ("node.glb", set("/scenes/0/nodes", json!([4])), "a node is missing"),
        ("cycle.glb", set("/nodes/0", json!({"mesh": 0, "children": [0]})), "several parents"),
        ("twice.glb", set("/scenes/0/nodes", json!([0, 0])), "several parents"),
        ("data.glb", set("/accessors/0", json!({"componentType": 5126, "count": 4, "type": "VEC3"})), "no data"),
        (
            "uri.glb",
            set("/buffers/0", json!({"byteLength": 72, "uri": "https://example.org/a.bin"})),
            "not a local file",
        ),
        ("base64.glb", set("/buffers/0", json!({"byteLength": 72, "uri": "data:;base64,*"})), "base64"),
        (
            "draco.glb",
            changed(|d| d["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]), &[]),
            "needs KHR_draco",
        ),
        ("sparse.glb", changed(add_sparse, &[1, 200, 0, 0].repeat(7)), "sparse index"),
        ("sparse_cut.glb", changed(add_sparse, &sparse_bytes()[..20]), "breaks off"),
        ("one.gltf", br#"{"asset": {"version": "1.0"}, "meshes": {}}"#.to_vec(), "glTF 2"),
        ("cut.gltf", gltf_with_data_uri().as_bytes()[..300].to_vec(), "JSON"),
        ("empty.obj", vec![], "no triangles"),
        ("points.obj", b"v 0 0 0\n".to_vec(), "no triangles"),
        ("zero.obj", text("f 1", "f 0", obj()), "line 12"),
        ("far.obj", text("f 1", "f 5", obj()), "a face names vertex 4"),
        ("back.obj", text("f 1", "f -5", obj()), "line 12"),
        ("word.obj", text("f 1", "f x", obj()), "line 12"),
        ("edge.obj", b"v 0 0 0\nv 1 0 0\nf 1 2".to_vec(), "three corners"),
        ("nan.obj", text("v 1 0 0", "v nan 0 0", obj()), "vertex 1 is not finite"),
        ("huge.obj", text("v 1 0 0", "v 1e99 0 0", obj()), "vertex 1 is not finite"),
        ("two.obj", text("v 1 0 0", "v 1 0", obj()), "three numbers"),
        ("cut.ply", ply_text().into_bytes()[..250].to_vec(), "read element line"),
        ("fewer.ply", ply("3 0 1 2 0.5\n", ""), "nexpected end"),
        ("cut_binary.ply", ply_binary(false)[..260].to_vec(), "breaks off"),
        ("header.ply", b"ply\nformat ascii 1.0\n".to_vec(), "nexpected end"),
        ("many.ply", ply("vertex 4", "vertex 18446744073709551615"), "breaks off"),
        ("corner.ply", ply("3 0 1 2", "3 0 1 7"), "a face names vertex 7"),
        ("negative.ply", ply("3 0 1 2", "3 0 1 -2"), "no vertex number"),
        ("long.ply", ply("3 0 1 2", "999999999999 0 1 2"), "element at index 3"),
        ("axis.ply", ply("float x", "float u"), "no x, y and z"),
        ("faceless.ply", ply("element face 4", "element fact 4"), "no triangles"),
        ("cut.stl", text("endsolid second", "", stl_text()), "breaks off"),
        ("cut_binary.stl", stl_binary(b"x")[..200].to_vec(), "4 triangles announced, 2 there"),
        ("header.stl", vec![0; 83], "header"),
        ("word.stl", text("outer loop", "inner loop", stl_text()), "line 3"),
        ("inf.stl", text("vertex 1 0 0", "vertex inf 0 0", stl_text()), "not finite"),
        ("none.stl", b"solid x\nendsolid x\n".to_vec(), "no triangles"),
        ("a.fbx", b"Kaydara FBX Binary".to_vec(), "not known"),
        ("noextension", b"v 0 0 0".to_vec(), "not known"),
    ] {
        assert_problem(read_bytes(name, bytes), name, problem);
    }
}

#[test]
fn what_is_no_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    assert_problem(read_mesh(folder.path()), folder.path().to_str().unwrap(), "not a file");
    assert_problem(read_mesh(&folder.path().join("absent.glb")), "absent.glb", "cannot be read");
}

#[test]
fn a_promised_terabyte_is_not_allocated() {
    // Rows without bytes: a reader that believes the count runs for centuries.
    let header = "ply\nformat binary_little_endian 1.0\nelement nothing 999999999999\nelement vertex 0\nend_header\n";
    assert_problem(read_bytes("a.ply", header), "a.ply", "no triangles");
}

#[test]
#[cfg_attr(not(shared_files), ignore = "needs ../shared")]
fn shared_objects_have_as_many_triangles_as_their_table_says() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/objects");
    let table = fs::read_to_string(folder.join("objects.csv")).unwrap();
    let mut lines = table.lines();
    let column = |name| table.lines().next().unwrap().split(',').position(|column| column == name).unwrap();
    let (file, triangles) = (column("file"), column("triangles"));
    lines.next();
    let mut count = 0;
    for cells in lines.map(|line| line.split(',').collect::<Vec<_>>()) {
        let path = folder.join(Path::new(cells[file]).file_name().unwrap());
        let mesh = read_mesh(&path).unwrap();
        assert_eq!(mesh.triangles.len().to_string(), cells[triangles], "{}", path.display());
        count += 1;
    }
    assert_eq!(count, 71);
}

/// A scratch file for many reads in a row.
struct Scratch(tempfile::TempDir);

impl Scratch {
    fn read(&self, name: &str, bytes: &[u8]) -> Result<Mesh, MeshError> {
        let path: PathBuf = self.0.path().join(name);
        fs::write(&path, bytes).unwrap();
        read_mesh(&path)
    }
}

/// Whatever the file holds: an error that names it, or a mesh that keeps the promises of [`Mesh`].
fn survives(scratch: &Scratch, name: &str, bytes: &[u8]) {
    match scratch.read(name, bytes) {
        Err(error) => assert!(error.to_string().contains(name)),
        Ok(mesh) => {
            assert!(!mesh.triangles.is_empty());
            assert!(mesh.vertices.iter().all(|v| v.is_finite()));
            assert!(mesh.triangles.as_flattened().iter().all(|&i| (i as usize) < mesh.vertices.len()));
        }
    }
}

#[test]
fn truncations_are_survived() {
    let scratch = Scratch(tempfile::tempdir().unwrap());
    for (name, bytes) in samples() {
        for length in (0..bytes.len()).step_by(1 + bytes.len() / 300) {
            survives(&scratch, name, &bytes[..length]);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn changed_bytes_are_survived(
        sample in 0..10usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        let (name, mut bytes) = samples().swap_remove(sample);
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        survives(&Scratch(tempfile::tempdir().unwrap()), name, &bytes);
    }

    /// Numbers in texts and headers become other numbers: the syntax stays, the meaning breaks.
    #[test]
    fn changed_numbers_are_survived(
        sample in 0..10usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0..NUMBERS.len()), 1..4),
    ) {
        let (name, mut bytes) = samples().swap_remove(sample);
        for (at, number) in changes {
            let digits: Vec<usize> = (0..bytes.len()).filter(|&i| bytes[i].is_ascii_digit()).collect();
            if digits.is_empty() {
                continue;
            }
            let start = digits[at.index(digits.len())];
            let end = start + bytes[start..].iter().take_while(|b| b.is_ascii_digit()).count();
            bytes.splice(start..end, NUMBERS[number].bytes());
            if bytes.starts_with(b"glTF") {
                repair_lengths(&mut bytes);
            }
        }
        survives(&Scratch(tempfile::tempdir().unwrap()), name, &bytes);
    }

    #[test]
    fn noise_is_survived(
        magic in prop::sample::select(vec!["", "glTF\u{2}\0\0\0", "ply\n", "solid ", "{\"asset\":{\"version\":\"2.0\"},"]),
        extension in prop::sample::select(vec!["glb", "gltf", "obj", "ply", "stl"]),
        noise in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        let bytes = [magic.as_bytes(), &noise].concat();
        survives(&Scratch(tempfile::tempdir().unwrap()), &format!("a.{extension}"), &bytes);
    }
}

const NUMBERS: [&str; 12] = [
    "0",
    "1",
    "2",
    "3",
    "5121",
    "5125",
    "255",
    "-1",
    "4294967295",
    "18446744073709551615",
    "9223372036854775807",
    "1e39",
];

/// Makes the lengths of a GLB fit again after its text was changed.
fn repair_lengths(bytes: &mut [u8]) {
    let Some(end) = bytes.windows(4).position(|w| w == b"BIN\0") else { return };
    let total = (bytes.len() as u32).to_le_bytes();
    let text = (end as u32).saturating_sub(4 + 20).to_le_bytes();
    bytes[8..12].copy_from_slice(&total);
    bytes[12..16].copy_from_slice(&text);
}
