//! The last touch on parts: a thin padding, so that the meshes of things that rest on each other clear each other.
//!
//! Bodies at rest overlap by a little (`world::constants::RESTING_DEPTH`), and a part may fall short of its mesh by a
//! little more: without padding meshes would cut into each other by less than anyone sees, and a strict test would
//! count a collision. Raising what touches instead would let it fall in an engine that has no contact margin.

use super::cover::follow;
use super::hull::Hull;
use glam::Vec4;

/// How far a part stands out beyond its mesh on all sides, m: one and a half times the largest overlap of bodies at
/// rest, so that meshes are at least twice that apart.
pub const PADDING: f32 = 0.075e-3;

/// A hull with all its faces moved outwards by `PADDING`, as far as that goes without spikes or more vertices.
pub(super) fn padded(hull: Hull) -> Hull {
    let faces: Vec<(Vec4, f32, bool)> = hull.planes.iter().map(|&n| (n, PADDING, false)).collect();
    match Hull::new(&follow(&hull, &faces)) {
        Some(grown) if grown.vertices.len() <= hull.vertices.len() => grown,
        _ => hull,
    }
}
