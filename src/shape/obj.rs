//! A convex part as a Wavefront OBJ file.

use super::Part;
use super::hull::Hull;
use glam::Vec3;
use std::fmt::Write;

/// The part as the bytes of an OBJ file in the mesh's own frame: vertices (m) divided by `scale`.
pub fn part_obj(part: &Part, scale: Vec3) -> Vec<u8> {
    let mut text = String::from("# convex part\n");
    // A valid part is its own hull with the same vertices; only the triangles are new here.
    let hull = Hull::new(&part.vertices).unwrap_or_default();
    for v in hull.vertices.iter().map(|v| *v / scale) {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "v {} {} {}", v.x, v.y, v.z);
    }
    for [a, b, c] in hull.triangles {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    text.into_bytes()
}
