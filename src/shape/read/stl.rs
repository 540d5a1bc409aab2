//! STL, binary and ASCII.
//!
//! Our own reader, because the `stl_io` crate takes every binary file whose header begins with `solid` for text,
//! refuses a text that begins with a bare `solid`, and stops after the first of several solids.

use super::{Source, three_numbers};
use crate::shape::{Mesh, MeshError};
use glam::Vec3;

/// Header and count of triangles.
const HEADER: usize = 84;
/// Normal, three corners, attribute.
const TRIANGLE: usize = 50;

pub(super) fn read(source: &Source<'_>) -> Result<Mesh, MeshError> {
    let bytes = &source.bytes;
    let text = bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let Some((header, body)) = bytes.split_at_checked(HEADER) else {
        return if text { read_text(source) } else { Err(source.damaged("it breaks off in its header")) };
    };
    let count = u32::from_le_bytes([header[80], header[81], header[82], header[83]]) as usize;
    // The size tells more than the word: many binary headers begin with "solid" too.
    let triangles = body.chunks_exact(TRIANGLE);
    if text && body.len() != count.saturating_mul(TRIANGLE) {
        // A text announces by chance what its bytes could hold, but then it is none.
        let binary = count > 0 && triangles.len() >= count;
        return read_text(source)
            .or_else(|error| if binary { Ok(read_binary(triangles.take(count))) } else { Err(error) });
    }
    if triangles.len() < count {
        let problem = format!("it breaks off: {count} triangles announced, {} there", triangles.len());
        return Err(source.damaged(problem));
    }
    Ok(read_binary(triangles.take(count)))
}

fn read_binary<'a>(triangles: impl Iterator<Item = &'a [u8]>) -> Mesh {
    let mut mesh = Mesh::default();
    for triangle in triangles {
        let numbers = triangle.as_chunks::<4>().0;
        let corners = numbers[3..12].as_chunks::<3>().0;
        add_facet(&mut mesh, corners.iter().map(|axes| axes.map(f32::from_le_bytes).into()));
    }
    mesh
}

fn read_text(source: &Source<'_>) -> Result<Mesh, MeshError> {
    let mut mesh = Mesh::default();
    let mut corners = Vec::new();
    let mut last = String::new();
    for (number, line) in source.text().lines().enumerate() {
        let damaged = |what: &str| source.damaged(format!("line {}: {what}", number + 1));
        let mut words = line.split_ascii_whitespace();
        let Some(word) = words.next() else { continue };
        last = word.to_ascii_lowercase();
        match last.as_str() {
            "vertex" => corners.push(three_numbers(&mut words).ok_or_else(|| damaged("a vertex needs three numbers"))?),
            "endloop" if corners.len() < 3 => return Err(damaged("a facet needs three vertices")),
            "endloop" => add_facet(&mut mesh, corners.drain(..)),
            "solid" | "facet" | "outer" | "endfacet" | "endsolid" => {}
            _ => return Err(damaged("it is not a line of an STL text")),
        }
    }
    match last.as_str() {
        "endsolid" => Ok(mesh),
        _ => Err(source.damaged("it breaks off before \"endsolid\"")),
    }
}

fn add_facet(mesh: &mut Mesh, corners: impl Iterator<Item = Vec3>) {
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend(corners);
    let corners: Vec<u32> = (first..mesh.vertices.len() as u32).collect();
    mesh.add_polygon(&corners);
}
