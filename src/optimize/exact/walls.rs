//! What the exact step may not do: move anything through a wall, or what hangs off its surface.

use super::super::room::{Room, TOUCHES};
use super::surface::Surface;
use crate::scene::Root;
use glam::DVec3;

/// Where every object is between the walls.
pub(super) struct Walls<'a> {
    room: &'a Room,
    /// For every object: how far it is inside each side of the room before it is moved, m.
    gaps: Vec<Vec<f64>>,
}

impl<'a> Walls<'a> {
    pub fn new(room: &'a Room, surfaces: &[Surface]) -> Self {
        let gap = |surface: &Surface, normal: DVec3, point: DVec3| surface.lowest_along(normal) - point.dot(normal);
        let gaps: Vec<Vec<f64>> = (surfaces.iter())
            .map(|surface| room.sides.iter().map(|side| gap(surface, side.normal, side.point)).collect())
            .collect();
        Self { room, gaps }
    }

    /// The normal of the surface that an object hangs on.
    pub fn surface(&self, object: usize) -> Option<DVec3> {
        self.room.side_of(object).map(|side| self.room.sides[side].normal)
    }

    /// True if an object that has been moved by `before` may be moved on by `step`: not farther through a wall, and
    /// what hangs neither off its surface nor through the ceiling.
    pub fn allow(&self, object: usize, before: DVec3, step: DVec3) -> bool {
        let hung = self.room.side_of(object);
        self.room.sides.iter().zip(&self.gaps[object]).enumerate().all(|(i, (side, gap))| {
            let (now, then) = (gap + before.dot(side.normal), gap + (before + step).dot(side.normal));
            let inside = then >= now.min(0.0);
            let touches = hung != Some(i) || then <= TOUCHES.max(now);
            touches && (inside || (side.kind == Root::Ceiling && hung.is_none()))
        })
    }
}
