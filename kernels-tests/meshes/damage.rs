//! Damaged files are errors that name them; whatever the bytes, nothing panics.

use crate::fixture::*;
use proptest::prelude::*;
use rest3d_gpu::shape::{Mesh, MeshError, read_mesh};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

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
        magic in prop::sample::select(
            vec!["", "glTF\u{2}\0\0\0", "ply\n", "solid ", "{\"asset\":{\"version\":\"2.0\"},"]
        ),
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
