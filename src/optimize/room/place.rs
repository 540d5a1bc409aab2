//! Puts objects where they belong: what hangs onto its wall or ceiling, what stands at a wall against it, and everything
//! else inside the walls.

use super::free::{Place, Space};
use super::outline::Outline;
use super::tolerances::{CONTACT, FAR, MAX_INSIDE, MAX_LEAN, MAX_PULL, MAX_YAW, PLUMB, TOUCHES};
use super::{Form, Placement, Room, hangs_on, stands};
use crate::optimize::groups::{carry, subtree};
use crate::optimize::rig::Rig;
use crate::optimize::upright::{lean, upright};
use crate::scene::{Parent, Pose, Root, Scene};
use glam::{DQuat, DVec3};

/// Places the objects of a scene in its room.
pub(in crate::optimize) struct Placer<'a> {
    pub scene: &'a Scene,
    pub room: &'a Room,
    pub forms: &'a [Form],
    pub rigs: &'a [Rig],
}

impl Placer<'_> {
    /// Puts what stands at a wall against it, but for the `leaning` which already are, and everything that reaches through
    /// a wall inside, each with what it bears.
    pub fn furnish(&self, leaning: &[usize], layout: &mut [Pose], placements: &mut [Option<Placement>]) {
        let mut bearers_first = self.scene.post_order();
        bearers_first.reverse();
        for object in bearers_first {
            if !stands(self.scene, object) {
                continue;
            }
            let start = layout[object];
            if self.scene.objects[object].parent == Parent::Root(Root::GroundWall) {
                placements[object] = self.against_wall(object, leaning.contains(&object), layout);
            }
            for (_, wall) in self.room.walls().filter(|(_, wall)| wall.bears) {
                let gap = wall.gap(self.forms[object].solid(&layout[object]));
                if (-MAX_INSIDE..0.0).contains(&gap) {
                    let shift = (CONTACT - gap) / wall.normal.with_y(0.0).length();
                    self.shift(object, wall.normal.with_y(0.0).normalize_or_zero() * shift, layout);
                    let note = "reached through the wall";
                    placements[object].get_or_insert_with(|| Placement::at(&wall.name, note)).shift =
                        (layout[object].translation - start.translation).dot(wall.normal);
                }
            }
        }
    }

    /// Puts something that stands on the ground against its wall.
    fn against_wall(&self, object: usize, leans: bool, layout: &mut [Pose]) -> Option<Placement> {
        let middle = self.forms[object].middle(&layout[object]);
        let wall = &self.room.sides[self.room.nearest(Root::Wall, middle)?];
        let gap = |layout: &[Pose]| wall.gap(self.forms[object].solid(&layout[object]));
        if !(-MAX_INSIDE..=MAX_PULL).contains(&gap(layout)) {
            let note = format!("left alone: it is {:.2} m from its wall", gap(layout).abs());
            return Some(Placement::at(&wall.name, &note));
        }
        if leans {
            return Some(Placement::at(&wall.name, "leans on its wall"));
        }
        let mut placement = Placement::at(&wall.name, "");
        self.turn(object, wall.normal, &mut placement, layout);
        let inward = wall.normal.with_y(0.0).normalize_or_zero();
        let shift = inward * ((CONTACT - gap(layout)) / inward.dot(wall.normal));
        placement.shift = shift.dot(wall.normal);
        self.shift(object, shift, layout);
        Some(placement)
    }

    /// Puts everything that hangs onto its wall or ceiling, the largest first: what comes later gives way.
    pub fn hang(&self, layout: &mut [Pose], placements: &mut [Option<Placement>]) {
        let space = Space::new(self.room, self.forms, self.rigs);
        let size = |i: usize| {
            let [low, high] = self.forms[i].bounds(&layout[i]);
            (high - low).element_product()
        };
        let mut hung: Vec<(usize, Root, f64)> =
            (0..layout.len()).filter_map(|i| Some((i, hangs_on(self.scene, i)?, size(i)))).collect();
        hung.sort_by(|a, b| b.2.total_cmp(&a.2).then(a.0.cmp(&b.0)));
        let mut waiting = vec![false; layout.len()];
        for &(object, ..) in &hung {
            if self.scene.objects[object].movable {
                self.riders(object).into_iter().for_each(|rider| waiting[rider] = true);
            } else {
                placements[object] = Some(Placement::held());
            }
        }
        for (object, kind, _) in hung {
            let middle = self.forms[object].middle(&layout[object]);
            if !self.scene.objects[object].movable {
                continue;
            }
            let riders = self.riders(object);
            riders.iter().for_each(|&rider| waiting[rider] = false);
            if let Some(side) = self.room.nearest(kind, middle) {
                let others: Vec<usize> = (0..layout.len()).filter(|i| !waiting[*i] && !riders.contains(i)).collect();
                placements[object] = Some(self.hang_one(object, side, &riders, &others, &space, layout));
            }
        }
    }

    fn hang_one(
        &self,
        object: usize,
        side: usize,
        riders: &[usize],
        others: &[usize],
        space: &Space<'_>,
        layout: &mut [Pose],
    ) -> Placement {
        let surface = &self.room.sides[side];
        let mut placement = Placement::at(&surface.name, "");
        let leaned = lean(&layout[object]);
        if let Some(pose) = upright(&layout[object], self.rigs[object].center_of(&layout[object]), PLUMB..MAX_LEAN) {
            placement.lean = leaned;
            self.carry(object, pose, layout);
        }
        if surface.kind == Root::Wall {
            self.turn(object, surface.normal, &mut placement, layout);
        }
        let gap = surface.gap(self.forms[object].mesh(&layout[object]));
        self.shift(object, surface.normal * (CONTACT - gap), layout);
        placement.shift = CONTACT - gap;
        if placement.shift.abs() > FAR {
            placement.remark(format!("was {:.2} m from it", gap.abs()));
        }
        let shift = match space.place(side, riders, others, layout) {
            Place::Touching(shift) => shift,
            Place::Off(shift) => {
                placement.remark("has no free place on it".to_owned());
                shift
            }
            Place::None => {
                placement.remark("has no free place near".to_owned());
                DVec3::ZERO
            }
        };
        let away = shift.dot(surface.normal);
        placement.shift += away;
        placement.slide = (shift - surface.normal * away).length();
        self.shift(object, shift, layout);
        placement
    }

    /// Turns an object about the vertical so that its flat side lies on a wall.
    fn turn(&self, object: usize, normal: DVec3, placement: &mut Placement, layout: &mut [Pose]) {
        match Outline::new(self.forms[object].mesh(&layout[object])).turn_to(-normal) {
            Some(yaw) => {
                let (turn, center) = (DQuat::from_rotation_y(yaw), self.rigs[object].center_of(&layout[object]));
                let Pose { rotation, translation } = layout[object];
                let pose = Pose {
                    rotation: (turn * rotation).normalize(),
                    translation: center + turn * (translation - center),
                };
                placement.yaw = yaw;
                self.carry(object, pose, layout);
            }
            None => placement.remark(format!("not turned: no flat side within {:.0}° of it", MAX_YAW.to_degrees())),
        }
    }

    fn shift(&self, object: usize, shift: DVec3, layout: &mut [Pose]) {
        let pose = Pose { translation: layout[object].translation + shift, ..layout[object] };
        self.carry(object, pose, layout);
    }

    fn carry(&self, object: usize, pose: Pose, layout: &mut [Pose]) {
        carry(self.scene, object, pose, layout, |child| self.scene.objects[child].movable);
    }

    /// An object and everything on it that rides along.
    fn riders(&self, object: usize) -> Vec<usize> {
        subtree(self.scene, object, |child| self.scene.objects[child].movable)
    }

    /// Measures what has become of the placements in the result, and remarks what does not touch.
    pub fn measure(&self, layout: &[Pose], placements: &mut [Option<Placement>]) {
        for (i, placement) in placements.iter_mut().enumerate() {
            let Some(placement) = placement else { continue };
            let surface = self.room.sides.iter().find(|side| Some(&side.name) == placement.surface.as_ref());
            placement.clearance = surface.map(|side| side.gap(self.forms[i].mesh(&layout[i])));
            if placement.clearance.is_some_and(|gap| hangs_on(self.scene, i).is_some() && gap.abs() > TOUCHES) {
                placement.remark("does not touch it".to_owned());
            }
        }
    }
}

impl Placement {
    fn at(surface: &str, note: &str) -> Self {
        let surface = Some(surface.to_owned());
        Self { surface, yaw: 0.0, lean: 0.0, shift: 0.0, slide: 0.0, clearance: None, note: note.to_owned() }
    }

    fn held() -> Self {
        Self { surface: None, ..Self::at("", "left alone: not movable") }
    }

    fn remark(&mut self, remark: String) {
        if !self.note.is_empty() {
            self.note.push_str("; ");
        }
        self.note.push_str(&remark);
    }
}
