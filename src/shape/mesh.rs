//! A triangle mesh and the files that hold one: GLB, glTF, OBJ, PLY, STL.

use super::{Look, read};
use glam::Vec3;
use std::path::{Path, PathBuf};

/// A triangle mesh in the file's own frame and unit, the transforms of its nodes applied.
///
/// Every index is in range, every vertex finite, and there is at least one triangle. Vertices may be duplicated or
/// unused, triangles degenerate, the surface open.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions, mesh units.
    pub vertices: Vec<Vec3>,
    /// Corners as indices into `vertices`, counter-clockwise seen from outside where the file keeps to that.
    pub triangles: Vec<[u32; 3]>,
}

/// Why a mesh file cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {problem}; {remedy}", file.display())]
pub struct MeshError {
    /// The mesh file, or the file of buffers that it names.
    pub file: PathBuf,
    /// What was found.
    pub problem: String,
    /// What to do.
    pub remedy: String,
}

/// Reads a mesh, by content where it tells and by extension otherwise. Images and materials are never looked at.
///
/// # Errors
/// A file that is not there, not of a known format, damaged, without triangles, or with numbers that are not finite.
pub fn read_mesh(path: &Path) -> Result<Mesh, MeshError> {
    read::read(path, None)
}

/// As [`read_mesh`], with how it looks. What is wrong with that is a note, never an error.
///
/// # Errors
/// As [`read_mesh`].
pub fn read_look(path: &Path) -> Result<(Mesh, Look), MeshError> {
    let mut look = Look::default();
    let mesh = read::read(path, Some(&mut look))?;
    look.complete(mesh.triangles.len());
    Ok((mesh, look))
}
