//! Puts objects where they belong: what hangs onto its wall or ceiling, what stands at a wall against it, and
//! everything else inside the walls.

use super::free::{Place, Space};
use super::outline::{Outline, wrapped, yaw};
use super::tolerances::{CONTACT, FAR, HORIZONTAL, MAX_INSIDE, MAX_LEAN, MAX_PULL, MAX_YAW, PLUMB, THERE, TOUCHES};
use super::{Form, Placement, Room, hangs_on, name_of, stands_upright};
use crate::optimize::groups::{carry, carry_standing};
use crate::optimize::posture::{lean, upright};
use crate::optimize::rig::Rig;
use crate::scene::{Parent, Pose, Root, Scene};
use glam::{DQuat, DVec3, Vec3Swizzles};
use std::f64::consts::PI;

/// The note of what was left leaning on its wall.
const LEANS: &str = "leans on its wall";

/// Places the objects of a scene in its room.
pub(in crate::optimize) struct Placer<'a> {
    pub scene: &'a Scene,
    pub room: &'a Room,
    pub forms: &'a [Form],
    pub rigs: &'a [Rig],
}

impl Placer<'_> {
    /// Of `which`, puts what stands at a wall against it, but for the `leaning` which already are, and everything that
    /// reaches through a wall inside, each with what it bears.
    pub fn furnish(
        &self,
        which: impl Fn(usize) -> bool,
        leaning: &[usize],
        layout: &mut [Pose],
        placements: &mut [Option<Placement>],
    ) {
        for object in self.scene.bearers_first().into_iter().filter(|&object| which(object)) {
            let start = layout[object];
            if self.scene.objects[object].parent == Parent::Root(Root::GroundWall) {
                placements[object] = self.against_wall(object, leaning.contains(&object), layout);
            }
            for (index, wall) in self.room.walls().filter(|(_, wall)| wall.bears) {
                let gap = wall.gap(self.forms[object].solid(&layout[object]));
                if (-MAX_INSIDE..0.0).contains(&gap) {
                    let shift = (CONTACT - gap) / wall.normal.with_y(0.0).length();
                    self.shift(object, wall.normal.with_y(0.0).normalize_or_zero() * shift, layout);
                    let note = "reached through the wall";
                    placements[object].get_or_insert_with(|| Placement::at(self.room, index, note)).shift =
                        (layout[object].translation - start.translation).dot(wall.normal);
                }
            }
        }
    }

    /// Puts something that stands on the ground against its wall.
    fn against_wall(&self, object: usize, leans: bool, layout: &mut [Pose]) -> Option<Placement> {
        let index = self.room.nearest(Root::Wall, false, &self.forms[object], &layout[object])?;
        let wall = &self.room.sides[index];
        let gap = |layout: &[Pose]| wall.gap(self.forms[object].solid(&layout[object]));
        if !(-MAX_INSIDE..=MAX_PULL).contains(&gap(layout)) {
            let note = format!("left alone: it is {:.2} m from its wall", gap(layout).abs());
            return Some(Placement::at(self.room, index, &note));
        }
        if leans {
            return Some(Placement::at(self.room, index, LEANS));
        }
        let mut placement = Placement::at(self.room, index, "");
        if let Some(pose) = self.turned(object, wall.normal, &mut placement, layout) {
            carry_standing(self.scene, &self.rigs[object], object, pose, layout);
        }
        let inward = wall.normal.with_y(0.0).normalize_or_zero();
        let shift = inward * ((CONTACT - gap(layout)) / inward.dot(wall.normal));
        placement.shift = shift.dot(wall.normal);
        self.shift(object, shift, layout);
        Some(placement)
    }

    /// Puts everything that hangs onto its wall or ceiling, the largest first: what comes later gives way. Returns for
    /// every object the side that it was put onto.
    pub fn hang(&self, layout: &mut [Pose], placements: &mut [Option<Placement>]) -> Vec<Option<usize>> {
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
                placements[object] = Some(Placement::new("left alone: not movable"));
            }
        }
        let mut hung_on = vec![None; layout.len()];
        for (object, kind, _) in hung {
            if !self.scene.objects[object].movable {
                continue;
            }
            let riders = self.riders(object);
            riders.iter().for_each(|&rider| waiting[rider] = false);
            if let Some(side) = self.room.nearest(kind, true, &self.forms[object], &layout[object]) {
                hung_on[object] = Some(side);
                let others: Vec<usize> = (0..layout.len()).filter(|i| !waiting[*i] && !riders.contains(i)).collect();
                placements[object] = Some(self.hang_one(object, side, &riders, &others, &space, layout));
            }
        }
        hung_on
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
        let mut placement = Placement::at(self.room, side, "");
        let leaned = lean(&layout[object]);
        if let Some(pose) = upright(&layout[object], self.rigs[object].center_of(&layout[object]), PLUMB..MAX_LEAN) {
            placement.lean = leaned;
            self.carry(object, pose, layout);
        }
        if surface.kind == Root::Wall
            && let Some(pose) = self.turned(object, surface.normal, &mut placement, layout)
        {
            self.carry(object, pose, layout);
        }
        let gap = surface.gap(self.forms[object].mesh(&layout[object]));
        self.shift(object, surface.normal * (CONTACT - gap), layout);
        placement.shift = CONTACT - gap;
        if placement.shift.abs() > FAR {
            placement.remark(format!("was {:.2} m from it", gap.abs()));
        }
        let [low, high] = self.forms[object].bounds(&layout[object]);
        if self.room.ceiling().is_some_and(|ceiling| high.y - low.y > ceiling) {
            placement.remark("higher than the room".to_owned());
        }
        let shift = match space.place(side, riders, others, layout) {
            Place::Touching(shift) => shift,
            Place::Off(shift) => {
                placement.remark("has no free place on it".to_owned());
                shift
            }
            Place::None => {
                placement.remark("has no free place nearby".to_owned());
                DVec3::ZERO
            }
        };
        let away = shift.dot(surface.normal);
        placement.shift += away;
        placement.slide = (shift - surface.normal * away).length();
        self.shift(object, shift, layout);
        placement
    }

    /// An object turned about the vertical so that its flat side lies on a wall; what has none, by the axes of its mesh.
    /// None if it need not or cannot be turned.
    fn turned(&self, object: usize, normal: DVec3, placement: &mut Placement, layout: &[Pose]) -> Option<Pose> {
        let Pose { rotation, translation } = layout[object];
        let outline = Outline::new(self.forms[object].mesh(&layout[object]));
        let Some(yaw) = outline.turn_to(-normal).or_else(|| turn_of_axes(rotation, normal)) else {
            placement.remark(format!("not turned: no side within {:.0}° of it", MAX_YAW.to_degrees()));
            return None;
        };
        if yaw.abs() < PLUMB {
            return None;
        }
        let (turn, center) = (DQuat::from_rotation_y(yaw), self.rigs[object].center_of(&layout[object]));
        placement.yaw = yaw;
        Some(Pose { rotation: (turn * rotation).normalize(), translation: center + turn * (translation - center) })
    }

    fn shift(&self, object: usize, shift: DVec3, layout: &mut [Pose]) {
        if shift.length() < THERE {
            return;
        }
        let pose = Pose { translation: layout[object].translation + shift, ..layout[object] };
        self.carry(object, pose, layout);
    }

    /// What reaches out of the room. How far what hangs is from its wall stands in its placement.
    fn reaching_through(&self, layout: &[Pose]) -> Vec<String> {
        let mut notes = Vec::new();
        for (i, object) in self.scene.objects.iter().enumerate() {
            let mut beyond = |gap: f64, side: &str| {
                if gap < -TOUCHES {
                    notes.push(format!("{}: reaches {:.2} m through the {side}", object.name, -gap));
                }
            };
            let [low, high] = self.forms[i].bounds(&layout[i]);
            self.room.ceiling().into_iter().for_each(|ceiling| beyond(ceiling - high.y, "ceiling"));
            if hangs_on(self.scene, i).is_some() {
                beyond(low.y, "ground");
            } else if object.movable {
                for (_, wall) in self.room.walls().filter(|(_, wall)| wall.bears || wall.fitted) {
                    beyond(wall.gap(self.forms[i].mesh(&layout[i])), &wall.title());
                }
            }
        }
        notes
    }

    fn carry(&self, object: usize, pose: Pose, layout: &mut [Pose]) {
        carry(self.scene, object, pose, layout, |child| self.scene.objects[child].movable);
    }

    /// An object and everything on it that rides along.
    fn riders(&self, object: usize) -> Vec<usize> {
        self.scene.subtree(object, |child| self.scene.objects[child].movable)
    }

    /// Measures what has become of the placements in the result. Returns what the user should know of it.
    pub fn measure(&self, layout: &[Pose], placements: &mut [Option<Placement>]) -> Vec<String> {
        let mut notes = Vec::new();
        for (i, placement) in placements.iter_mut().enumerate() {
            let Some((placement, side)) = placement.as_mut().and_then(|it| it.side.map(|side| (it, side))) else {
                continue;
            };
            let side = &self.room.sides[side];
            let gap = side.gap(self.forms[i].mesh(&layout[i]));
            placement.clearance = Some(gap);
            if hangs_on(self.scene, i).is_none() {
                continue;
            }
            let off = if gap.abs() > TOUCHES { format!("{:.0} mm from", 1e3 * gap) } else { "on".to_owned() };
            let why = if placement.note.is_empty() { String::new() } else { format!(" ({})", placement.note) };
            if gap.abs() > TOUCHES || !why.is_empty() {
                notes.push(format!("{}: {off} the {}{why}", self.scene.objects[i].name, side.title()));
            }
        }
        notes.extend(self.reaching_through(layout));
        for (_, wall) in self.room.walls().filter(|(_, wall)| !wall.fitted && !wall.bears) {
            notes.push(format!(
                "wall \"{}\": furniture stands more than {MAX_INSIDE} m beyond it, so nothing was moved inside and nothing leans on it",
                wall.name
            ));
        }
        for (i, wall) in self.scene.room.walls.iter().enumerate().filter(|(_, wall)| !stands_upright(wall)) {
            notes.push(format!(
                "room: {}: left out, because its normal points up or down; write a level one, or \"ground\" or \"ceiling\" \
                 instead",
                name_of(i, wall)
            ));
        }
        notes
    }
}

/// How far a mesh has to be turned about +Y for its nearest horizontal axis to be along a wall's normal, rad; none if
/// that is more than 25°.
fn turn_of_axes(rotation: DQuat, normal: DVec3) -> Option<f64> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| rotation * axis);
    let turns = axes.into_iter().filter(|axis| axis.y.abs() < HORIZONTAL);
    let turns = turns.map(|axis| wrapped(yaw(normal.xz()) - yaw(axis.xz()), PI));
    turns.min_by(|a, b| a.abs().total_cmp(&b.abs())).filter(|turn| turn.abs() < MAX_YAW)
}

impl Placement {
    fn new(note: &str) -> Self {
        let note = note.to_owned();
        Self { side: None, surface: None, yaw: 0.0, lean: 0.0, shift: 0.0, slide: 0.0, clearance: None, note }
    }

    fn at(room: &Room, side: usize, note: &str) -> Self {
        Self { side: Some(side), surface: Some(room.sides[side].name.clone()), ..Self::new(note) }
    }

    fn remark(&mut self, remark: String) {
        if !self.note.is_empty() {
            self.note.push_str("; ");
        }
        self.note.push_str(&remark);
    }
}
