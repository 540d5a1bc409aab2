//! What its parent alone does not hold: a board on two trestles, a broom that leans on a wardrobe, a book on another that
//! the scene has on the same table. A scene names one bearer; the others are found here, and bear wherever the object is
//! simulated apart from the rest of the scene.

use super::height::{Solid, support_shift};
use super::tolerances::{BESIDE, MAX_TURN, NARROW, SLENDER, STEADY, STEP, THIN};
use super::{Rest, Seat};
use crate::optimize::{posture::lean, room::LEANING, support::Placed};
use crate::scene::{self, Object, Parent, Relation};
use crate::world::{BackendError, BodyDef, STATIC};
use glam::Vec3;

impl Seat<'_> {
    /// Lets an object that does not stay on its parent come to rest with what else is below it held, too, upright if it
    /// must, or, if it leans on the ground and so was meant to, with what is beside it. Of the `set` ones. Tells what it
    /// rests on then; none, and left as it was, if it stays on nothing.
    pub(super) fn rest_on_others(
        &self,
        object: usize,
        set: &[bool],
        layout: &mut [scene::Pose],
    ) -> Result<Option<Vec<usize>>, BackendError> {
        // A board that leans is a hand higher over one trestle than over the other.
        for pose in [Some(layout[object]), self.upright(object, layout)].into_iter().flatten() {
            let mut turned = layout.to_vec();
            self.carry(object, pose, &mut turned);
            if let Some(bearers) = self.rest_on_others_from(object, set, &mut turned)? {
                layout.copy_from_slice(&turned);
                return Ok(Some(bearers));
            }
        }
        Ok(None)
    }

    /// The same from the object's pose in `layout`.
    fn rest_on_others_from(
        &self,
        object: usize,
        set: &[bool],
        layout: &mut [scene::Pose],
    ) -> Result<Option<Vec<usize>>, BackendError> {
        let on_ground = matches!(self.scene.objects[object].parent, Parent::Root(_));
        let near = self.others_near(object, set, layout);
        let below = self.below(object, &near, layout);
        let raise = below.iter().map(|(_, step)| *step).fold(0.0, f32::max);
        let below: Vec<usize> = below.into_iter().map(|(other, _)| other).collect();
        let leans = on_ground && lean(&layout[object]) > LEANING;
        let steady = if self.is_slender(object) { MAX_TURN } else { STEADY };
        let (bearers, most) = if below.is_empty() && leans { (near, steady) } else { (below, f32::INFINITY) };
        if bearers.is_empty() {
            return Ok(None);
        }
        let Some(rest) = self.rest_raised(object, raise, &bearers, layout)? else { return Ok(None) };
        if rest.turn >= most || !self.is_borne(object, Some(&rest), layout) {
            return Ok(None);
        }
        self.carry(object, rest.pose, layout);
        Ok(Some(self.touched(object, bearers, layout)))
    }

    /// Those of the `near` ones on which an object may rest, and by how much it is to be raised for that, m.
    pub(super) fn below(&self, object: usize, near: &[usize], layout: &[scene::Pose]) -> Vec<(usize, f32)> {
        let steps = near.iter().filter_map(|&other| self.step(object, other, layout).map(|step| (other, step)));
        steps.filter(|(_, step)| step.abs() <= STEP).collect()
    }

    /// Those of the `others` that an object touches.
    pub(super) fn touched(&self, object: usize, mut others: Vec<usize>, layout: &[scene::Pose]) -> Vec<usize> {
        let placed = |i: usize| Placed::new(&self.rigs[i], &self.rigs[i].body(&layout[i]));
        others.retain(|&other| placed(other).touches(&placed(object)));
        others
    }

    /// Lets an object come to rest on another of the `set` ones with the same parent, if its middle is over that, and its
    /// height or how thin that is speaks for a pile. Tells which; none, and left as it was, if it is on its parent itself.
    pub(super) fn rest_on_pile(
        &self,
        object: usize,
        set: &[bool],
        layout: &mut [scene::Pose],
    ) -> Result<Option<usize>, BackendError> {
        let Object { parent, relation, .. } = self.scene.objects[object];
        if self.scene.is_static(object) || relation == Relation::Attached {
            return Ok(None);
        }
        let narrow = Solid::new(&self.rigs[object], &layout[object], NARROW);
        let step = |other: usize| {
            let solid = Solid::new(&self.rigs[other], &layout[other], 1.0);
            support_shift(&narrow, Vec3::ZERO, &solid)
                .and_then(|_| self.step(object, other, layout))
                .map(|step| (other, step))
        };
        let nearest = (0..layout.len())
            .filter(|&other| other != object && set[other] && self.scene.objects[other].parent == parent)
            .filter(|&other| self.is_near(object, other, layout))
            .filter_map(step)
            .min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let Some((other, step)) = nearest else { return Ok(None) };
        let down = self.shift(object, &layout[object], self.bearer(object, layout).as_ref());
        // What is below its own surface of the parent is on the other side of a board.
        if step.abs() > down.abs() && (step - down > THIN || step < down) {
            return Ok(None);
        }
        let Some(rest) = self.rest_raised(object, step, &[other], layout)? else { return Ok(None) };
        let placed = |i: usize, pose: &scene::Pose| Placed::new(&self.rigs[i], &self.rigs[i].body(pose));
        if !placed(other, &layout[other]).bears(&placed(object, &rest.pose), relation) {
            return Ok(None);
        }
        self.carry(object, rest.pose, layout);
        Ok(Some(other))
    }

    /// Where an object that is raised, m, stays with others held, too; none if it does not.
    fn rest_raised(
        &self,
        object: usize,
        raise: f32,
        others: &[usize],
        layout: &[scene::Pose],
    ) -> Result<Option<Rest>, BackendError> {
        let mut raised = layout[object];
        raised.translation.y += f64::from(raise);
        Ok(self.rests(object, &self.held(others, layout), layout, &[raised])?.remove(0).filter(Rest::stays))
    }

    /// These objects as bodies that do not move.
    pub(super) fn held(&self, objects: &[usize], layout: &[scene::Pose]) -> Vec<BodyDef> {
        let held = |&object: &usize| {
            let pose = self.rigs[object].body(&layout[object]);
            self.rigs[object].def(STATIC, pose, pose)
        };
        objects.iter().map(held).collect()
    }

    /// The `set` objects near one that neither bear it nor stand on it.
    pub(super) fn others_near(&self, object: usize, set: &[bool], layout: &[scene::Pose]) -> Vec<usize> {
        let mut kin = self.scene.subtree(object, |_| true);
        kin.extend(self.scene.bearers(object));
        let other = |i: &usize| set[*i] && !kin.contains(i);
        (0..layout.len()).filter(other).filter(|&i| self.is_near(object, i, layout)).collect()
    }

    /// True for what hardly stands by itself along its longest side.
    fn is_slender(&self, object: usize) -> bool {
        let [low, high] = self.forms[object].bounds(&scene::Pose::IDENTITY);
        let size = high - low;
        size.min_element() < SLENDER * size.max_element()
    }

    /// True if the boxes of two objects are near each other.
    fn is_near(&self, object: usize, other: usize, layout: &[scene::Pose]) -> bool {
        let bounds = |i: usize| self.forms[i].bounds(&layout[i]);
        let ([low, high], [other_low, other_high]) = (bounds(object), bounds(other));
        (other_low - BESIDE).cmple(high).all() && (other_high + BESIDE).cmpge(low).all()
    }
}
