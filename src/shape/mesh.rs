//! Stand-in for the mesh reader of branch `scene`: GLB with a binary chunk only.

use glam::{Mat4, Vec3};
use std::path::Path;

/// A triangle mesh.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Positions, mesh units.
    pub vertices: Vec<Vec3>,
    /// Corner numbers.
    pub triangles: Vec<[u32; 3]>,
}

/// Why a mesh could not be read.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct MeshError(String);

/// Reads a GLB.
pub fn read_mesh(path: &Path) -> Result<Mesh, MeshError> {
    let glb = gltf::Gltf::open(path).map_err(|e| MeshError(format!("{}: {e}", path.display())))?;
    let mut mesh = Mesh::default();
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
