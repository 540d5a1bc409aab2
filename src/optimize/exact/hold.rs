//! What hangs on an object that it does not touch is taken to it: no simulation moves it, so nothing else brings it there.

use super::tolerances::{ASIDE, HOLDS, REST};
use super::{Exact, Move};
use crate::scene::Parent;
use glam::DVec3;

impl Exact<'_> {
    /// Lets what hangs on an object come down on it, if it is above, or else takes it to that the nearest way; where that
    /// leads into something else it stays. Bearers first.
    pub(super) fn hold(&mut self) {
        for object in self.scene.bearers_first() {
            if let Parent::Object(parent) = self.scene.objects[object].parent
                && self.scene.is_static(object)
                && !self.moving[object].is_empty()
                && let Some(way) = self.way(object, parent, HOLDS).filter(|way| way.length() > ASIDE)
            {
                let down = self.above(object, parent).map(|gap| DVec3::NEG_Y * (gap - REST));
                let nearest = -way * (1.0 - ASIDE / way.length());
                let steps = down.into_iter().chain([nearest]).map(|shift| Move { mover: object, shift, cost: 0.0 });
                if let Some(step) = steps.into_iter().find(|step| self.is_free(step)) {
                    self.apply(step);
                }
            }
        }
    }
}
