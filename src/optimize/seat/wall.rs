//! What leans on a wall because the scene says that it stands at one: mattresses, ladders, and what is too thin to stand
//! by itself.

use super::tolerances::FLIMSY;
use super::{Rest, Seat};
use crate::optimize::room::{self, CONTACT};
use crate::scene::{Parent, Pose, Root};
use crate::world::BackendError;

impl Seat<'_> {
    /// Lets what stands at a wall come to rest against it, squarely if it stays so, on what is below it there of the `set`
    /// ones. Tells what it rests on besides; none, and left as it was, if it does not stay there either.
    pub(super) fn lean_on_wall(
        &self,
        object: usize,
        set: &[bool],
        layout: &mut [Pose],
    ) -> Result<Option<Vec<usize>>, BackendError> {
        let form = &self.forms[object];
        if self.scene.objects[object].parent != Parent::Root(Root::GroundWall) {
            return Ok(None);
        }
        let Some(wall) = self.room.wall_to_lean_on(form, &layout[object]) else { return Ok(None) };
        let (here, rig) = (layout[object], &self.rigs[object]);
        let against = |rotation| {
            let mut pose = rig.turned(&here, rotation);
            let gap = wall.gap(form.solid(&pose));
            pose.translation += wall.normal.with_y(0.0) * (CONTACT - gap);
            pose.translation.y -= f64::from(rig.lowest(&rig.body(&pose)));
            pose
        };
        let squarely = against(wall.leant_on_by(form, &here));
        let mut leaning = layout.to_vec();
        self.carry(object, squarely, &mut leaning);
        let near = self.others_near(object, set, &leaning);
        let raise = self.below(object, &near, &leaning).into_iter().map(|(_, step)| step).fold(0.0, f32::max);
        let poses = [squarely, against(here.rotation)]
            .map(|pose| Pose { translation: pose.translation.with_y(pose.translation.y + f64::from(raise)), ..pose });
        let mut bodies = self.held(&near, layout);
        bodies.push(room::body(wall, form.bounds(&squarely)));
        let rests = self.rests(object, &bodies, layout, &poses)?;
        let Some(rest) = rests.into_iter().flatten().find(Rest::stays) else { return Ok(None) };
        self.carry(object, rest.pose, layout);
        Ok(Some(self.touched(object, near, layout)))
    }

    /// True for what stands at a wall, but is too thin to stand by itself.
    pub(super) fn is_flimsy(&self, object: usize, layout: &[Pose]) -> bool {
        let size = |pose: &Pose| {
            let [low, high] = self.forms[object].bounds(pose);
            high - low
        };
        let own = size(&Pose::IDENTITY);
        let stands_on_end = size(&layout[object]).y > 0.5 * own.max_element();
        stands_on_end && own.min_element() < FLIMSY * size(&layout[object]).y
    }
}
