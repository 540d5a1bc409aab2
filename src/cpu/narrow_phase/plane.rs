//! Contacts of a hull with a plane: every vertex near it, thinned to the corners of their footprint.

use super::{Manifold, ManifoldPoint, reduce};
use crate::world::constants::MAX_HULL_VERTICES;
use crate::world::{HullTables, Pose};
use glam::Vec3;

/// Contact points between the half-space `normal · x ≤ offset` (unit normal, m), as A, and a hull, as B: the vertices
/// whose separation is at most `margin` (m), reduced to the corners of their footprint.
pub fn plane_hull(
    tables: &HullTables,
    hull: u32,
    pose: &Pose,
    (normal, offset): (Vec3, f32),
    margin: f32,
    out: &mut Manifold,
) {
    out.normal = normal;
    out.count = 0;
    let hull = &tables.hulls[hull as usize];
    let local = pose.rotation.conjugate() * normal;
    let height = normal.dot(pose.translation) - offset;
    if local.dot(hull.center) + height > margin + hull.radius {
        return;
    }
    let mut near = [(Vec3::ZERO, 0.0_f32); MAX_HULL_VERTICES];
    let mut count = 0;
    for v in tables.vertices_of(hull) {
        let separation = local.dot(v.truncate()) + height;
        if separation <= margin && count < MAX_HULL_VERTICES {
            near[count] = (v.truncate(), separation);
            count += 1;
        }
    }
    let mut put = |(v, separation): (Vec3, f32)| {
        let on_b = pose.point(v);
        out.slots[out.count as usize] = ManifoldPoint { on_a: on_b - normal * separation, on_b, separation };
        out.count += 1;
    };
    if count <= 3 {
        near[..count].iter().for_each(|&p| put(p));
    } else {
        let kept = reduce(count, |i| near[i], local);
        kept.indices().iter().for_each(|&i| put(near[i as usize]));
    }
}
