//! Readers of mesh files, one per format. None trusts a number in a file: what is allocated is bounded by what is
//! there.

mod accessor;
mod gltf;
mod gltf_look;
mod image;
mod obj;
mod ply;
mod polygon;
mod stl;

use super::{Look, Mesh, MeshError};
use glam::Vec3;
use std::fmt::Display;
use std::fs;
use std::path::Path;

/// Largest file that is read.
const MAX_BYTES: u64 = 1 << 31;
/// Most vertices, and most triangles, that a mesh may have; beyond, decomposing it is hopeless anyway.
const MAX_ELEMENTS: usize = 1 << 24;
/// Exponent of a screen, from numbers to linear light.
const GAMMA: f32 = 2.2;
/// Longest excerpt of a library's message, characters.
const EXCERPT: usize = 160;

/// A mesh file's path and content.
struct Source<'a> {
    path: &'a Path,
    bytes: Vec<u8>,
}

/// Reads a mesh, and how it looks if `look` is there to be filled.
pub(super) fn read(path: &Path, look: Option<&mut Look>) -> Result<Mesh, MeshError> {
    let source = Source { path, bytes: bytes_of(path)? };
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let mesh = match (source.bytes.as_slice(), extension.to_str().unwrap_or_default()) {
        ([b'g', b'l', b'T', b'F', ..], _) => gltf::read_binary(&source, look),
        ([b'p', b'l', b'y', b'\r' | b'\n', ..], _) => ply::read(&source, look),
        (_, "gltf") => gltf::read_text(&source, look),
        (_, "obj") => obj::read(&source, look),
        (_, "stl") => stl::read(&source),
        (_, "glb") => Err(source.error("it does not begin as a GLB does", "export the mesh as GLB again")),
        (_, "ply") => Err(source.error("it does not begin as a PLY does", "export the mesh as PLY again")),
        _ => Err(source.error("its format is not known", "use GLB, glTF, OBJ, PLY or STL")),
    }?;
    check(&source, &mesh)?;
    Ok(mesh)
}

/// The content of a file.
fn bytes_of(path: &Path) -> Result<Vec<u8>, MeshError> {
    let read = || {
        let data = fs::metadata(path)?;
        if !data.is_file() {
            return Err(std::io::Error::other("it is not a file"));
        }
        if data.len() > MAX_BYTES {
            return Err(std::io::Error::other("it is larger than 2 GiB"));
        }
        fs::read(path)
    };
    read().map_err(|e| error(path, format!("cannot be read: {e}"), "check the path and the file"))
}

/// What [`Mesh`] promises.
fn check(source: &Source<'_>, mesh: &Mesh) -> Result<(), MeshError> {
    if mesh.triangles.is_empty() {
        return Err(source.error("it holds no triangles", "export the mesh with its faces"));
    }
    if mesh.vertices.len().max(mesh.triangles.len()) > MAX_ELEMENTS {
        return Err(source.too_large());
    }
    if let Some(i) = mesh.vertices.iter().position(|v| !v.is_finite()) {
        return Err(source.damaged(format!("vertex {i} is not finite")));
    }
    let count = mesh.vertices.len();
    if let Some(i) = mesh.triangles.as_flattened().iter().find(|&&i| i as usize >= count) {
        return Err(source.damaged(format!("a face names vertex {i}, and there are only {count}")));
    }
    Ok(())
}

impl Source<'_> {
    /// The content as text; what is not UTF-8 can only be a name or a comment.
    fn text(&self) -> std::borrow::Cow<'_, str> {
        String::from_utf8_lossy(&self.bytes)
    }

    fn error(&self, problem: impl Display, remedy: &str) -> MeshError {
        error(self.path, problem, remedy)
    }

    /// An error for content that contradicts its format.
    fn damaged(&self, problem: impl Display) -> MeshError {
        self.error(problem, "the file is damaged, export or copy it again")
    }

    fn too_large(&self) -> MeshError {
        self.error(format!("it has more than {MAX_ELEMENTS} vertices or triangles"), "simplify the mesh")
    }
}

/// An error with a message that stays on one line, whatever a library or a file put into it.
fn error(path: &Path, problem: impl Display, remedy: &str) -> MeshError {
    let problem = problem.to_string();
    let mut line: String = problem.split_whitespace().collect::<Vec<_>>().join(" ");
    if let Some((end, _)) = line.char_indices().nth(EXCERPT) {
        line.truncate(end);
        line.push('…');
    }
    MeshError { file: path.to_path_buf(), problem: line, remedy: remedy.to_owned() }
}

impl Mesh {
    /// Adds a polygon, and gives its triangles by the numbers of its corners. What names no vertex is refused later.
    fn add_polygon(&mut self, corners: &[u32]) -> Vec<[usize; 3]> {
        let vertex = |&corner: &u32| self.vertices.get(corner as usize).copied().unwrap_or(Vec3::NAN);
        let triangles = polygon::triangles(&corners.iter().map(vertex).collect::<Vec<_>>());
        self.triangles.extend(triangles.iter().map(|triangle| triangle.map(|i| corners[i])));
        triangles
    }
}

/// Adds a strip, whose every second triangle is turned; the flat ones that stitch strips together are left out.
fn add_strip(triangles: &mut Vec<[u32; 3]>, corners: &[u32]) {
    let turned =
        corners.array_windows().enumerate().map(|(i, &[a, b, c])| if i % 2 == 0 { [a, b, c] } else { [b, a, c] });
    triangles.extend(turned.filter(|[a, b, c]| a != b && b != c && a != c));
}

/// The next three numbers of a line.
fn three_numbers<'a>(words: &mut impl Iterator<Item = &'a str>) -> Option<Vec3> {
    let mut next = || words.next()?.parse().ok();
    Some(Vec3::new(next()?, next()?, next()?))
}

/// Colours of formats that say nothing of it are meant for the screen.
fn to_linear(color: Vec3) -> Vec3 {
    color.clamp(Vec3::ZERO, Vec3::ONE).powf(GAMMA)
}
