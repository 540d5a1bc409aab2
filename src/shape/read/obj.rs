//! Wavefront OBJ: positions and faces, nothing else.
//!
//! Our own reader, because the `tobj` crate refuses whole files over things that do not matter here (a texture
//! coordinate out of range, colours on some of the vertices, a comment that is not UTF-8) and overflows on an index near
//! the end of the number range.

use super::{Source, add_polygon, three_numbers};
use crate::shape::{Mesh, MeshError};

pub(super) fn read(source: &Source<'_>) -> Result<Mesh, MeshError> {
    let mut mesh = Mesh::default();
    let mut corners = Vec::new();
    let text = source.text();
    let mut lines = text.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        let damaged = |what: &str| source.damaged(format!("line {}: {what}", number + 1));
        // A backslash at its end continues a line.
        let mut joined;
        let mut line = line.trim_end();
        while let Some(start) = line.strip_suffix('\\') {
            joined = format!("{start} {}", lines.next().map_or("", |(_, next)| next.trim_end()));
            line = &joined;
        }
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let position = three_numbers(&mut words).ok_or_else(|| damaged("a vertex needs three numbers"))?;
                mesh.vertices.push(position);
            }
            Some("f") => {
                corners.clear();
                for word in words {
                    let corner = corner(word, mesh.vertices.len());
                    corners.push(corner.ok_or_else(|| damaged("a corner of the face is not a vertex number"))?);
                }
                if corners.len() < 3 {
                    return Err(damaged("a face needs three corners"));
                }
                add_polygon(&mut mesh.triangles, &corners);
            }
            _ => {}
        }
    }
    Ok(mesh)
}

/// The vertex of a corner, `v`, `v/vt`, `v//vn` or `v/vt/vn`; counted from 1, or back from the last vertex if negative.
fn corner(word: &str, vertices: usize) -> Option<u32> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    let index = if number < 0 { i64::try_from(vertices).ok()?.checked_add(number)? } else { number - 1 };
    u32::try_from(index).ok()
}
