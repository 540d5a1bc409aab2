//! Stand-in until the readers arrive.
use super::mesh::{Mesh, MeshError};
use glam::{Mat4, Vec3};
use std::path::Path;
pub(super) fn read(path: &Path) -> Result<Mesh, MeshError> {
    let err = |e: String| MeshError { file: path.into(), problem: e, remedy: "export again".into() };
    let mut mesh = Mesh::default();
    if path.extension().is_some_and(|e| e == "obj") {
        for line in std::fs::read_to_string(path).map_err(|e| err(e.to_string()))?.lines() {
            let w: Vec<&str> = line.split_whitespace().collect();
            match w.first() {
                Some(&"v") => mesh.vertices.push({
                    let f = |i: usize| w[i].parse().unwrap_or(0.0);
                    Vec3::new(f(1), f(2), f(3))
                }),
                Some(&"f") => {
                    let c: Vec<u32> = w[1..].iter().map(|x| x.parse::<u32>().unwrap_or(1) - 1).collect();
                    mesh.triangles.extend((1..c.len() - 1).map(|k| [c[0], c[k], c[k + 1]]));
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
