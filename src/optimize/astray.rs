//! Free places near the one where an object was set onto its support, for one that the search has pushed off it.

use super::directions::directions;
use super::run::Run;
use super::support::Placed;
use super::tolerances::{FREE_STEP, FREE_WITHIN};
use crate::scene::{self, Parent};
use crate::world::constants::TOUCHING_DEPTH;
use glam::DVec3;

impl Run<'_> {
    /// Where the object overlaps no other but its parent, the nearest to its reconstruction first: its seated pose,
    /// shifted sideways, and moved along with its parent.
    pub(super) fn free_places(&self, object: usize, layout: &[scene::Pose]) -> Vec<scene::Pose> {
        let placed = |object: usize, pose: &scene::Pose| Placed::new(&self.rigs[object], &self.rigs[object].body(pose));
        let mut pose = self.seated[object];
        let mut parent = None;
        if let Parent::Object(bearer) = self.scene.objects[object].parent {
            let center = |layout: &[scene::Pose]| self.rigs[bearer].center_of(&layout[bearer]);
            pose.translation += center(layout) - center(&self.seated);
            parent = Some(bearer);
        }
        let others: Vec<Placed> = (0..layout.len())
            .filter(|&other| other != object && Some(other) != parent)
            .map(|other| placed(other, &layout[other]))
            .collect();
        let own = placed(object, &pose);
        let is_free = |shift: &DVec3| !others.iter().any(|other| own.overlaps(shift.as_vec3(), other, TOUCHING_DEPTH));
        let at = |shift| scene::Pose { translation: pose.translation + shift, ..pose };
        shifts().filter(is_free).map(at).collect()
    }
}

/// Horizontal shifts in all directions, from none to the farthest, m.
fn shifts() -> impl Iterator<Item = DVec3> {
    let rings = 1..=(FREE_WITHIN / FREE_STEP).round() as u32;
    let ring = |ring: u32| directions().map(move |along| along * (FREE_STEP * f64::from(ring)));
    std::iter::once(DVec3::ZERO).chain(rings.flat_map(ring))
}
