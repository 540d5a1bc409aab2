//! Free places near the one where an object was set onto its support, for one that the search has pushed off it or thrown
//! far from it.

use super::directions::directions;
use super::run::Run;
use super::support::Placed;
use super::tolerances::{FAR, FREE_STEP, FREE_WITHIN, MOST_FAR, NEARER};
use crate::scene::{self, Parent};
use crate::world::constants::TOUCHING_DEPTH;
use glam::DVec3;

impl Run<'_> {
    /// Where an object was set onto its support, moved along with its parent.
    pub(super) fn place(&self, object: usize, layout: &[scene::Pose]) -> scene::Pose {
        let mut pose = self.seated[object];
        if let Parent::Object(bearer) = self.scene.objects[object].parent {
            let center = |layout: &[scene::Pose]| self.rigs[bearer].center_of(&layout[bearer]);
            pose.translation += center(layout) - center(&self.seated);
        }
        pose
    }

    /// Where the object overlaps no other but its parent, the nearest to its reconstruction first: its seated pose,
    /// shifted sideways, and moved along with its parent.
    pub(super) fn free_places(&self, object: usize, layout: &[scene::Pose]) -> Vec<scene::Pose> {
        let placed = |object: usize, pose: &scene::Pose| Placed::new(&self.rigs[object], &self.rigs[object].body(pose));
        let pose = self.place(object, layout);
        let parent = self.scene.objects[object].parent;
        let others: Vec<Placed> = (0..layout.len())
            .filter(|&other| other != object && parent != Parent::Object(other))
            .map(|other| placed(other, &layout[other]))
            .collect();
        let own = placed(object, &pose);
        let is_free = |shift: &DVec3| !others.iter().any(|other| own.overlaps(shift.as_vec3(), other, TOUCHING_DEPTH));
        let at = |shift| scene::Pose { translation: pose.translation + shift, ..pose };
        shifts(FREE_WITHIN).filter(is_free).map(at).collect()
    }

    /// The layout with an object that stands farther than `FAR` from where it was set moved sideways, with all that it
    /// bears, to the nearest place to that without overlap. None if it is not so far, or out of reach, or nearly as near as it
    /// can be.
    pub(super) fn nearer(&self, object: usize, layout: &[scene::Pose]) -> Option<Vec<scene::Pose>> {
        let moves = |&object: &usize| !self.scene.is_static(object);
        let back = (self.place(object, layout).translation - layout[object].translation).with_y(0.0);
        let way = back.length();
        if !moves(&object) || !(FAR..MOST_FAR).contains(&way) {
            return None;
        }
        let unit = self.scene.subtree(object, |child| moves(&child));
        let parent = self.scene.objects[object].parent;
        let placed = |object: usize| Placed::new(&self.rigs[object], &self.rigs[object].body(&layout[object]));
        let own: Vec<Placed> = unit.iter().map(|&member| placed(member)).collect();
        let is_other = |other: &usize| !unit.contains(other) && parent != Parent::Object(*other);
        let others: Vec<Placed> = (0..layout.len()).filter(is_other).map(placed).collect();
        let overlaps = |shift: DVec3| {
            let with = |other: &Placed, own: &Placed| own.overlaps(shift.as_vec3(), other, TOUCHING_DEPTH);
            others.iter().any(|other| own.iter().any(|own| with(other, own)))
        };
        let shift = shifts(NEARER * way).map(|beside| back + beside).find(|&shift| !overlaps(shift))?;
        let mut nearer = layout.to_vec();
        unit.iter().for_each(|&member| nearer[member].translation += shift);
        Some(nearer)
    }
}

/// Horizontal shifts in all directions, from none to the farthest, m.
fn shifts(within: f64) -> impl Iterator<Item = DVec3> {
    let rings = 1..=(within / FREE_STEP).round() as u32;
    let ring = |ring: u32| directions().map(move |along| along * (FREE_STEP * f64::from(ring)));
    std::iter::once(DVec3::ZERO).chain(rings.flat_map(ring))
}
