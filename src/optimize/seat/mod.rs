//! Supports: every object is set onto what bears it before the search, from the ground up, and comes to rest there.
//!
//! Reconstructions float or sink by centimetres. The search looks only millimetres up and down, and an object sunk
//! deeper than half of a table top would be pushed out below it. So each object is shifted vertically, with everything
//! that stands on it, to the nearest height at which it rests on its parent: for two convex parts the shifts at which
//! they overlap are one interval, and the upper ends of the joined intervals are the heights of support under the
//! object's footprint (REST3D's stage 2b, which takes the parent's highest point instead). Then the object is simulated
//! alone on its held parent: a desk that leans by two degrees would otherwise throw about what the search has carefully
//! set onto it, when at last it falls level. What falls over alone is tried once more upright, or against its wall if
//! the scene says that it stands at one; what rolls is set down in the nearest pose in which it stays (`roll`).

mod edge;
mod height;
mod roll;
mod shared;
mod tolerances;
mod upright;
mod wall;

use super::config::SettleSettings;
use super::room::{Form, LEANING, Room};
use super::{groups::carry_standing, posture::lean, rig::Rig, settle::settle};
use crate::scene::{self, Parent, Scene};
use crate::world::{Backend, BackendError, BodyDef, Flow, Pose, STATIC, SimSettings, World, angle_between};
use glam::Vec3;
use tolerances::{MAX_SINK, MAX_SLIDE, MAX_TURN, REST_SECONDS};

/// Where an object left alone on its parent ends, and how far from where it was left.
pub(super) struct Rest {
    pub pose: scene::Pose,
    /// rad.
    pub turn: f32,
    /// Of its centre, along the ground, m.
    pub shift: f32,
    /// The same of what is below its centre at the height of its foot: what rights itself does not slide.
    pub slide: f32,
    /// How far its centre comes down, m.
    pub sinks: f32,
}

impl Rest {
    /// False if it fell over or slid away.
    pub fn stays(&self) -> bool {
        self.turn < MAX_TURN && self.slide < MAX_SLIDE
    }

    /// The same; false, too, if it came down to hang there.
    pub fn stands(&self) -> bool {
        self.stays() && self.sinks < MAX_SINK
    }
}

/// What does not stand by itself.
#[derive(Default)]
pub(super) struct Unsteady {
    /// Objects that only stay when they lean on a wall.
    pub leaning: Vec<usize>,
    /// Objects that stay on nothing as they were reconstructed: fruit.
    pub rolling: Vec<usize>,
}

/// Sets objects onto their supports.
#[derive(Clone)]
pub(super) struct Seat<'a> {
    pub scene: &'a Scene,
    pub rigs: &'a [Rig],
    /// The same objects as their other decompositions have them.
    pub alternatives: &'a [Vec<Rig>; 2],
    pub backend: &'a dyn Backend,
    pub simulation: SimSettings,
    pub settings: &'a SettleSettings,
    /// What a metre aside costs, rad: the weight of the layout term.
    pub position: f64,
    pub room: &'a Room,
    pub forms: &'a [Form],
    /// Objects are let go with everything on them, not alone.
    pub loaded: bool,
}

impl Seat<'_> {
    /// Sets the objects of `layout` that `which` names onto their supports, each with everything on it. What never
    /// moves stays. What others stay on besides their parents goes into `bearers`: of what is not named only that can be
    /// it which is `there`, in its place, already.
    pub fn run(
        &self,
        which: impl Fn(usize) -> bool,
        there: impl Fn(usize) -> bool,
        layout: &mut [scene::Pose],
        bearers: &mut [Vec<usize>],
    ) -> Result<Unsteady, BackendError> {
        let mut unsteady = Unsteady::default();
        let mut set: Vec<bool> = (0..layout.len()).map(|i| self.scene.is_static(i) || there(i)).collect();
        for object in self.by_level(layout) {
            if set[object] || !which(object) {
                continue;
            }
            self.step_inside(object, layout);
            let pile = self.rest_on_pile(object, &set, layout)?;
            set[object] = true;
            if let Some(below) = pile {
                bearers[object] = vec![below];
                continue;
            }
            self.settle_height(object, layout);
            let mut left_alone = self.rest(object, layout)?;
            let stands = left_alone.as_ref().is_some_and(|rest| rest.stays());
            // What is too thin cannot do without the wall, and what leans far was meant to lean; else it stands if it can.
            let meant = self.is_flimsy(object, layout) || (!stands && lean(&layout[object]) > LEANING);
            if meant && let Some(others) = self.lean_on_wall(object, &set, layout)? {
                bearers[object] = others;
                unsteady.leaning.push(object);
                continue;
            }
            if !(stands && self.is_borne(object, left_alone.as_ref(), layout))
                && let Some(others) = self.rest_on_others(object, &set, layout)?
            {
                bearers[object] = others;
                continue;
            }
            if !self.is_borne(object, left_alone.as_ref(), layout)
                && let Some(rest) = self.move_onto_bearer(object, fall(left_alone.as_ref()), layout)?
            {
                left_alone = Some(rest);
            }
            if let Some(rest) = left_alone.as_ref().filter(|rest| self.is_borne(object, Some(rest), layout))
                && self.move_from_edge(object, rest.stays(), layout)?
            {
                left_alone = self.rest(object, layout)?;
            }
            if let Some(rest) = left_alone.as_ref().filter(|rest| rest.stays()) {
                let pose = self.put_back(object, rest, layout)?;
                self.carry(object, pose, layout);
                continue;
            }
            let fall = fall(left_alone.as_ref());
            if self.set_upright(object, fall, layout)? {
                continue;
            }
            if let Some(others) = self.lean_on_wall(object, &set, layout)? {
                bearers[object] = others;
                unsteady.leaning.push(object);
            } else {
                self.set_at_rest(object, fall, layout)?;
                unsteady.rolling.push(object);
            }
        }
        for object in self.by_level(layout).into_iter().rev() {
            if which(object) && !self.scene.is_static(object) && bearers[object].is_empty() {
                self.move_loaded_from_edge(object, layout)?;
            }
        }
        Ok(unsteady)
    }

    /// What is let go with an object.
    fn load(&self, object: usize) -> Vec<usize> {
        let enter = |child| self.loaded && !self.scene.is_static(child);
        self.scene.subtree(object, enter).split_off(1)
    }

    /// All objects, what stands on roots first, then what that bears, and so on; of what one bears the lowest first, and
    /// what leans last: on the others.
    fn by_level(&self, layout: &[scene::Pose]) -> Vec<usize> {
        let lowest = |&i: &usize| self.rigs[i].lowest(&self.rigs[i].body(&layout[i]));
        let upwards = |mut objects: Vec<usize>| {
            let leans = |&i: &usize| lean(&layout[i]) > LEANING;
            objects.sort_by(|a, b| leans(a).cmp(&leans(b)).then(lowest(a).total_cmp(&lowest(b))));
            objects
        };
        let on_root = |&i: &usize| matches!(self.scene.objects[i].parent, Parent::Root(_));
        let mut order = upwards((0..layout.len()).filter(on_root).collect());
        let mut next = 0;
        while next < order.len() {
            order.extend(upwards(self.scene.children(order[next]).collect()));
            next += 1;
        }
        order
    }

    /// The same with each decomposition of the objects.
    pub(super) fn with_all_parts(&self) -> [Self; 3] {
        let [a, b] = self.alternatives;
        [self.rigs, a, b].map(|rigs| Self { rigs, ..self.clone() })
    }

    /// Moves an object to `pose`, with everything on it.
    pub(super) fn carry(&self, object: usize, pose: scene::Pose, layout: &mut [scene::Pose]) {
        carry_standing(self.scene, &self.rigs[object], object, pose, layout);
    }

    /// Where the object comes to rest on its held parent, alone or `loaded`; none if that cannot be simulated.
    pub(super) fn rest(&self, object: usize, layout: &[scene::Pose]) -> Result<Option<Rest>, BackendError> {
        Ok(self.rests(object, &[], layout, &[layout[object]])?.remove(0))
    }

    /// The same for several poses of the object, and with other things held, too.
    pub(super) fn rests(
        &self,
        object: usize,
        others: &[BodyDef],
        layout: &[scene::Pose],
        poses: &[scene::Pose],
    ) -> Result<Vec<Option<Rest>>, BackendError> {
        self.rests_within(&|_| true, object, others, layout, poses)
    }

    /// The same, but where the object comes to a pose that is not `within` it stops there.
    pub(super) fn rests_within(
        &self,
        within: &dyn Fn(&scene::Pose) -> bool,
        object: usize,
        others: &[BodyDef],
        layout: &[scene::Pose],
        poses: &[scene::Pose],
    ) -> Result<Vec<Option<Rest>>, BackendError> {
        let rig = &self.rigs[object];
        let load = self.load(object);
        let body = |i: usize, layout: &[scene::Pose]| self.rigs[i].body(&layout[i]);
        let moves = |i: usize| self.rigs[i].def(0, body(i, layout), body(i, layout));
        let mut defs: Vec<BodyDef> = [object].iter().chain(&load).map(|&i| moves(i)).collect();
        if let Parent::Object(parent) = self.scene.objects[object].parent {
            let held = self.rigs[parent].body(&layout[parent]);
            defs.push(self.rigs[parent].def(STATIC, held, held));
        }
        defs.extend_from_slice(others);
        let world = World::new(&defs, &[0]);
        let settings = SettleSettings { max_seconds: REST_SECONDS, ..self.settings.clone() };
        let start = |pose: &scene::Pose| {
            let mut start = vec![rig.body(pose)];
            if !load.is_empty() {
                let mut carried = layout.to_vec();
                self.carry(object, *pose, &mut carried);
                start.extend(load.iter().map(|&i| body(i, &carried)));
            }
            start.extend_from_slice(&world.start[start.len()..]);
            start
        };
        let starts: Vec<Pose> = poses.iter().flat_map(start).collect();
        let goes_on = |now: &[Pose]| if within(&rig.object(&now[0])) { Flow::Continue } else { Flow::Stop };
        let settled = settle(self.backend, &world, &self.simulation, &settings, &starts, &goes_on)?;
        let bodies = world.start.len();
        let ends = starts.chunks_exact(bodies).zip(settled.poses.chunks_exact(bodies));
        let rest = |(start, end): (&[Pose], &[Pose])| Rest {
            pose: rig.object(&end[0]),
            turn: angle_between(end[0].rotation, start[0].rotation),
            shift: (end[0].translation - start[0].translation).with_y(0.0).length(),
            slide: slide(&start[0], &end[0], rig.lowest(&start[0])),
            sinks: start[0].translation.y - end[0].translation.y,
        };
        Ok(ends.zip(settled.usable).map(|(ends, usable)| usable.then(|| rest(ends))).collect())
    }
}

/// How far an object turns that is left alone, rad.
fn fall(left_alone: Option<&Rest>) -> f32 {
    left_alone.map_or(f32::INFINITY, |rest| rest.turn)
}

/// How far a body whose foot is at the height `lowest` has slid, m.
fn slide(start: &Pose, end: &Pose, lowest: f32) -> f32 {
    let foot = Vec3::Y * (lowest - start.translation.y);
    let turned = end.rotation * start.rotation.conjugate() * foot;
    (end.translation + turned - start.translation).with_y(0.0).length()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use glam::Quat;

    #[test]
    fn what_rights_itself_does_not_slide() {
        let upright = Pose::new(Quat::IDENTITY, Vec3::Y * 0.65);
        let (edge, lean) = (Vec3::X * 0.1, Quat::from_rotation_z(-0.1));
        let leaning = Pose::new(lean, edge + lean * (upright.translation - edge));
        assert!((leaning.translation.x - upright.translation.x) > 0.06, "its centre moves");
        assert!(slide(&leaning, &upright, 0.0) < 2e-3, "{}", slide(&leaning, &upright, 0.0));
        let pushed = Pose::new(upright.rotation, upright.translation + Vec3::X * 0.08);
        assert!((slide(&upright, &pushed, 0.0) - 0.08).abs() < 1e-6);
    }

    #[test]
    fn what_comes_down_by_a_hand_does_not_stand() {
        let rest = |sinks| Rest { pose: scene::Pose::IDENTITY, turn: 0.1, shift: 0.0, slide: 0.0, sinks };
        assert!(rest(0.001).stands() && rest(-0.05).stands());
        assert!(rest(0.06).stays() && !rest(0.06).stands());
    }
}
