//! Readers of mesh files, one per format.
use super::{Mesh, MeshError};
use glam::{Mat4, Vec3};
use std::path::Path;
/// temporary
pub(super) fn read(path: &Path) -> Result<Mesh, MeshError> {
    let err = |e: String| MeshError { file: path.to_path_buf(), problem: e, remedy: "x".into() };
    let mut mesh = Mesh::default();
    if path.extension().is_some_and(|e| e == "obj") {
        let text = std::fs::read_to_string(path).map_err(|e| err(e.to_string()))?;
        for line in text.lines() {
            let mut w = line.split_whitespace();
            match w.next() {
                Some("v") => {
                    let v: Vec<f32> = w.filter_map(|x| x.parse().ok()).collect();
                    mesh.vertices.push(Vec3::new(v[0], v[1], v[2]));
                }
                Some("f") => {
                    let f: Vec<u32> =
                        w.filter_map(|x| x.split('/').next()?.parse::<u32>().ok()).map(|i| i - 1).collect();
                    for k in 1..f.len() - 1 {
                        mesh.triangles.push([f[0], f[k], f[k + 1]]);
                    }
                }
                _ => {}
            }
        }
        return Ok(mesh);
    }
    let glb = gltf::Gltf::open(path).map_err(|e| err(e.to_string()))?;
    let mut stack: Vec<(gltf::Node<'_>, Mat4)> =
        glb.scenes().flat_map(|s| s.nodes()).map(|n| (n, Mat4::IDENTITY)).collect();
    while let Some((node, parent)) = stack.pop() {
        let transform = parent * Mat4::from_cols_array_2d(&node.transform().matrix());
        for primitive in node.mesh().iter().flat_map(|m| m.primitives()) {
            let reader = primitive.reader(|_| glb.blob.as_deref());
            let first = mesh.vertices.len() as u32;
            for p in reader.read_positions().into_iter().flatten() {
                mesh.vertices.push(transform.transform_point3(Vec3::from(p)));
            }
            let count = mesh.vertices.len() as u32 - first;
            let indices: Vec<u32> =
                reader.read_indices().map_or_else(|| (0..count).collect(), |i| i.into_u32().collect());
            mesh.triangles.extend(indices.chunks_exact(3).map(|t| [t[0] + first, t[1] + first, t[2] + first]));
        }
        stack.extend(node.children().map(|c| (c, transform)));
    }
    Ok(mesh)
}
