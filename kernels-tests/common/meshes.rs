//! Meshes, where they are, and whether they meet.

use glam::DVec3;
use rest3d_gpu::scene::Pose;
use rest3d_gpu::shape::Mesh;

/// Unit cube around the origin, as an OBJ file.
pub const CUBE: &str = "\
v -0.5 -0.5 -0.5\nv 0.5 -0.5 -0.5\nv 0.5 0.5 -0.5\nv -0.5 0.5 -0.5
v -0.5 -0.5 0.5\nv 0.5 -0.5 0.5\nv 0.5 0.5 0.5\nv -0.5 0.5 0.5
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 5 8 4\nf 2 3 7 6\n";

/// A mesh, and where its object is.
pub type Placed<'a> = (&'a Mesh, &'a Pose);

/// Corners in the world, m.
pub fn corners((mesh, pose): Placed<'_>) -> Vec<DVec3> {
    mesh.vertices.iter().map(|v| pose.translation + pose.rotation * v.as_dvec3()).collect()
}

/// True if an edge of one mesh passes through a triangle of the other, all against all.
pub fn meet(a: Placed<'_>, b: Placed<'_>) -> bool {
    pierces(a, b) || pierces(b, a)
}

/// True if an edge of the first passes through a triangle of the second.
fn pierces(first: Placed<'_>, second: Placed<'_>) -> bool {
    let (a, b) = (corners(first), corners(second));
    let bounds = |points: &[DVec3]| {
        points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)))
    };
    let apart = |(l, h): (DVec3, DVec3), (m, k): (DVec3, DVec3)| l.cmpgt(k).any() || m.cmpgt(h).any();
    // Möller and Trumbore.
    let through = |[p, q]: [DVec3; 2], [u, v, w]: [DVec3; 3]| {
        let (e, f, along, from) = (v - u, w - u, q - p, p - u);
        let det = e.dot(along.cross(f));
        let (s, r) = (from.dot(along.cross(f)) / det, along.dot(from.cross(e)) / det);
        let t = f.dot(from.cross(e)) / det;
        s >= 0.0 && r >= 0.0 && s + r <= 1.0 && (0.0..=1.0).contains(&t)
    };
    let within = bounds(&b);
    let triangles: Vec<[DVec3; 3]> = second.0.triangles.iter().map(|t| t.map(|k| b[k as usize])).collect();
    let edges = first.0.triangles.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
    edges.map(|edge| edge.map(|k| a[k as usize])).filter(|edge| !apart(bounds(edge), within)).any(|edge| {
        let reach = bounds(&edge);
        triangles.iter().any(|t| !apart(reach, bounds(t)) && through(edge, *t))
    })
}
