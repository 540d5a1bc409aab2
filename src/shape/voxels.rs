//! Convex parts by V-HACD (Mamou, "Volumetric hierarchical approximate convex decomposition", 2016), as most physics
//! engines make them of a mesh: what a layout meets when its own parts are not used.

use super::hull::Hull;
use super::mesh::Mesh;
use super::tolerances::voxels::RESOLUTION;
use parry3d::transformation::vhacd::{VHACD, VHACDParameters};

/// At most `budget` convex parts of the mesh, whose vertices lie on it; none if the mesh has no extent or
/// parry fails.
pub(super) fn decompose(mesh: &Mesh, budget: usize) -> Vec<Hull> {
    let parameters = VHACDParameters {
        resolution: RESOLUTION,
        max_convex_hulls: budget as u32,
        // Hulls of clipped hulls are faster, and for one round mesh in several hundred parry finds none and panics.
        convex_hull_approximation: false,
        ..VHACDParameters::default()
    };
    // The other hulls that it makes on the way are of voxels; none of 900 primitives made it panic so, but a mesh
    // might.
    let cut = || VHACD::decompose(&parameters, &mesh.vertices, &mesh.triangles, true);
    let Ok(found) = std::panic::catch_unwind(cut) else { return Vec::new() };
    let parts = found.compute_primitive_intersections(&mesh.vertices, &mesh.triangles);
    parts.iter().filter_map(|points| Hull::new(points)).collect()
}
