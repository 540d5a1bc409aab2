//! What its parent alone does not hold: a board on two trestles, a broom that leans on a wardrobe. A scene names one
//! bearer; the others are found here, and bear wherever the object is simulated apart from the rest of the scene.

use super::tolerances::{BESIDE, STEADY, STEP};
use super::{Rest, Seat};
use crate::optimize::{posture::lean, room::LEANING, support::Placed};
use crate::scene::{self, Parent};
use crate::world::{BackendError, BodyDef, STATIC};

impl Seat<'_> {
    /// Lets an object that does not stay on its parent come to rest with what else is below it held, too, or, if it
    /// leans on the ground and so was meant to, what is beside it. Of the `set` ones. Tells what it rests on then;
    /// none, and left as it was, if it stays on nothing.
    pub(super) fn rest_on_others(
        &self,
        object: usize,
        set: &[bool],
        layout: &mut [scene::Pose],
    ) -> Result<Option<Vec<usize>>, BackendError> {
        let on_ground = matches!(self.scene.objects[object].parent, Parent::Root(_));
        let mut kin = self.scene.subtree(object, |_| true);
        let mut bearer = self.scene.objects[object].parent;
        while let Parent::Object(ancestor) = bearer {
            kin.push(ancestor);
            bearer = self.scene.objects[ancestor].parent;
        }
        let other = |i: &usize| set[*i] && !kin.contains(i);
        let near: Vec<usize> = (0..layout.len()).filter(other).filter(|&i| self.is_near(object, i, layout)).collect();
        let below: Vec<(usize, f32)> = near
            .iter()
            .filter_map(|&other| self.step(object, other, layout).map(|step| (other, step)))
            .filter(|(_, step)| step.abs() <= STEP)
            .collect();
        let raise = below.iter().map(|(_, step)| *step).fold(0.0, f32::max);
        let below: Vec<usize> = below.into_iter().map(|(other, _)| other).collect();
        let leans = on_ground && lean(&layout[object]) > LEANING;
        let (bearers, most) = if below.is_empty() && leans { (near, STEADY) } else { (below, f32::INFINITY) };
        if bearers.is_empty() {
            return Ok(None);
        }
        let held = |&other: &usize| -> BodyDef {
            let pose = self.rigs[other].body(&layout[other]);
            self.rigs[other].def(STATIC, pose, pose)
        };
        let held: Vec<BodyDef> = bearers.iter().map(held).collect();
        let mut raised = layout[object];
        raised.translation.y += f64::from(raise);
        let rest = self.rests(object, &held, layout, &[raised])?.remove(0);
        let stays = |rest: &Rest| rest.stays() && rest.turn < most && self.is_borne(object, Some(rest), layout);
        let Some(rest) = rest.filter(stays) else { return Ok(None) };
        self.carry(object, rest.pose, layout);
        let placed = |i: usize| Placed::new(&self.rigs[i], &self.rigs[i].body(&layout[i]));
        Ok(Some(bearers.into_iter().filter(|&other| placed(other).touches(&placed(object))).collect()))
    }

    /// True if the boxes of two objects are near each other.
    fn is_near(&self, object: usize, other: usize, layout: &[scene::Pose]) -> bool {
        let bounds = |i: usize| self.forms[i].bounds(&layout[i]);
        let ([low, high], [other_low, other_high]) = (bounds(object), bounds(other));
        (other_low - BESIDE).cmple(high).all() && (other_high + BESIDE).cmpge(low).all()
    }
}
