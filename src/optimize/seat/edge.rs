//! What falls off its support is moved inwards, as little as need be: reconstructions put cups and fruit beyond the
//! edge of the table that they stand on.

use super::tolerances::{DISTANCES, MARGIN, MOST_LOAD, STEPS, WIDE_SHARE, WIDEST};
use super::{Rest, Seat};
use crate::optimize::{directions::directions, support::Placed};
use crate::scene::{self, Parent};
use crate::world::BackendError;
use glam::DVec3;

/// Moves an object; false if it was left as it was.
type Way<'w> = dyn Fn(&mut [scene::Pose]) -> Result<bool, BackendError> + 'w;

impl Seat<'_> {
    /// True if an object that came to rest so still stands on its parent object; also if it has none.
    pub(super) fn is_borne(&self, object: usize, rest: Option<&Rest>, layout: &[scene::Pose]) -> bool {
        let Parent::Object(parent) = self.scene.objects[object].parent else {
            return true;
        };
        let placed = |object: usize, pose| Placed::new(&self.rigs[object], &self.rigs[object].body(pose));
        let relation = self.scene.objects[object].relation;
        rest.is_some_and(|rest| placed(parent, &layout[parent]).bears(&placed(object, &rest.pose), relation))
    }

    /// Brings an object that is not borne where it is to where it is, with everything on it: upright, moved inwards
    /// upright, or moved inwards. What falls because it leans would else be moved to where it lies, and may fall off
    /// wherever it is put. Gives how it rests there; none, and left as it was, if it is borne nowhere. `fall`: how far it
    /// turns otherwise, rad.
    pub(super) fn move_onto_bearer(
        &self,
        object: usize,
        fall: f32,
        layout: &mut [scene::Pose],
    ) -> Result<Option<Rest>, BackendError> {
        let was = layout.to_vec();
        let ways: [&Way; 3] = [
            &|layout| self.set_upright(object, fall, layout),
            &|layout| self.move_upright_inwards(object, layout),
            &|layout| self.move_inwards(object, false, layout),
        ];
        for way in ways {
            if way(layout)? {
                // What balances on an edge for a while does not do so again.
                let rest = self.rest(object, layout)?;
                if self.is_borne(object, rest.as_ref(), layout) {
                    return Ok(rest);
                }
                layout.copy_from_slice(&was);
            }
        }
        Ok(None)
    }

    /// Moves an object, with everything on it, sideways to the nearest place where it stays on its parent. False, and
    /// left as it was, if there is none. `still`: it shall hardly move there, not lie where it has fallen.
    fn move_inwards(&self, object: usize, still: bool, layout: &mut [scene::Pose]) -> Result<bool, BackendError> {
        for distance in DISTANCES {
            let near: Vec<DVec3> = directions().map(|along| along * distance).collect();
            let inside: Vec<DVec3> = directions().map(|along| along * (distance + MARGIN)).collect();
            let first = self.staying(object, still, layout, &near)?;
            if first.iter().all(Option::is_none) {
                continue;
            }
            let second = self.staying(object, still, layout, &inside)?;
            let both = first.into_iter().zip(second).filter_map(|(near, inside)| near.and(inside));
            let Some((place, _)) = both.min_by(|a, b| a.1.total_cmp(&b.1)) else {
                continue;
            };
            self.carry(object, place, layout);
            return Ok(true);
        }
        Ok(false)
    }

    /// The same for what leans and stands there upright.
    fn move_upright_inwards(&self, object: usize, layout: &mut [scene::Pose]) -> Result<bool, BackendError> {
        let Some(upright) = self.upright(object, layout) else {
            return Ok(false);
        };
        let leaning = layout.to_vec();
        self.carry(object, upright, layout);
        let moved = self.move_inwards(object, true, layout)?;
        if !moved {
            layout.copy_from_slice(&leaning);
        }
        Ok(moved)
    }

    /// Moves an object that stays on its parent away from the edge, where there is one within a wide margin or, on
    /// something narrow, within `MARGIN`, with everything on it. False, and left as it was, if there is none. `still`:
    /// it hardly moves where it is, and shall not elsewhere.
    pub(super) fn move_from_edge(
        &self,
        object: usize,
        still: bool,
        layout: &mut [scene::Pose],
    ) -> Result<bool, BackendError> {
        let [low, high] = self.forms[object].bounds(&layout[object]);
        let wide = (WIDE_SHARE * (high - low).x.min((high - low).z)).clamp(MARGIN, WIDEST);
        Ok(self.move_from_edge_by(wide, object, still, layout)?
            || wide > MARGIN && self.move_from_edge_by(MARGIN, object, still, layout)?)
    }

    /// The same with one margin, m.
    fn move_from_edge_by(
        &self,
        margin: f64,
        object: usize,
        still: bool,
        layout: &mut [scene::Pose],
    ) -> Result<bool, BackendError> {
        let aside: Vec<DVec3> = directions().map(|along| along * margin).collect();
        let falls = self.staying(object, still, layout, &aside)?.into_iter().map(|stays| stays.is_none());
        let outwards: DVec3 = aside.iter().zip(falls).filter(|(_, falls)| *falls).map(|(shift, _)| *shift).sum();
        // What would fall on opposite sides stands on something narrow, and has no better place.
        if outwards.length() < 0.5 * margin {
            return Ok(false);
        }
        let outwards = outwards.normalize();
        let farther = self.staying(object, still, layout, &STEPS.map(|step| step * margin * outwards))?;
        let room = STEPS.into_iter().zip(farther).take_while(|(_, stays)| stays.is_some()).map(|(step, _)| step);
        let shift = margin * (room.fold(0.0, f64::max) - 1.0) * outwards;
        let [inside] = &self.staying(object, still, layout, &[shift])?[..] else { return Ok(false) };
        if let Some((place, _)) = inside {
            self.carry(object, *place, layout);
        }
        Ok(inside.is_some())
    }

    /// Moves an object that bears others, with these, to where it stays on its parent with them on it, and away from the
    /// edge: a tray with a plate on its rim may tip where the tray alone does not.
    pub(super) fn move_loaded_from_edge(&self, object: usize, layout: &mut [scene::Pose]) -> Result<(), BackendError> {
        let loaded = Self { loaded: true, ..self.clone() };
        let on_object = matches!(self.scene.objects[object].parent, Parent::Object(_));
        if !on_object || !(1..=MOST_LOAD).contains(&loaded.load(object).len()) {
            return Ok(());
        }
        let rest = loaded.rest(object, layout)?.filter(Rest::stays);
        match loaded.is_borne(object, rest.as_ref(), layout) {
            true => loaded.move_from_edge(object, true, layout)?,
            false => loaded.move_inwards(object, true, layout)?,
        };
        Ok(())
    }

    /// Where an object is when set down after each shift, and how far from there it comes to rest, m; none where it
    /// does not stay on its parent, or is to be `still` and is not.
    fn staying(
        &self,
        object: usize,
        still: bool,
        layout: &[scene::Pose],
        shifts: &[DVec3],
    ) -> Result<Vec<Option<(scene::Pose, f32)>>, BackendError> {
        let set_down = |shift: &DVec3| {
            let mut moved = layout.to_vec();
            moved[object].translation += *shift;
            self.settle_height(object, &mut moved);
            moved[object]
        };
        let places: Vec<scene::Pose> = shifts.iter().map(set_down).collect();
        let rests = self.rests(object, &[], layout, &places)?;
        let stays = |(place, rest): (scene::Pose, Option<Rest>)| {
            let rest = rest.filter(|rest| self.is_borne(object, Some(rest), layout) && (rest.stands() || !still))?;
            Some((place, rest.shift))
        };
        Ok(places.into_iter().zip(rests).map(stays).collect())
    }
}
