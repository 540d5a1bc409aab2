//! The end of a run: the layout that the search left settles, gets a second opinion, is parted and checked.

use super::tolerances::{FALLEN, FLOATS, FOOTINGS, JAMMED, MOST_TOLD, MOVED_FAR};
use super::{
    Checkpoint, Clearances, Event, GroupRecord, ObjectOutcome, Observer, OptimizeError, Outcome, Timings, exact,
    footing::{Written, keep},
    groups::Group,
    opinion::Opinions,
    posture::angle,
    rig::Rig,
    room::Placer,
    run::Run,
    settle::{GO_ON, settle, to_rest},
    support,
    verify::{Motion, Verified, verify},
};
use crate::scene::{self, Object};
use crate::world::{BackendError, Flow, Pose, World, angle_between};
use std::time::Instant;

/// What the check of a layout found.
struct Checked {
    /// The bodies and parts that are written.
    written: Written,
    /// None if nothing could be simulated.
    verified: Option<Verified>,
    /// Whether each object stays with its other parts.
    otherwise: Vec<bool>,
    /// Each object's deepest overlap with another, m.
    overlaps: Vec<f32>,
    /// The names of those that only stay because of a wall.
    leaning: Vec<String>,
}

impl Run<'_> {
    /// Settles and checks the layout that the search left. Both also run after an early stop: they are short, and an
    /// unfinished layout needs them most. The second opinion is not, and may be stopped itself.
    pub fn finish(
        &self,
        mut state: Checkpoint,
        mut finished: bool,
        observer: &mut dyn Observer,
    ) -> Result<Outcome, OptimizeError> {
        let mut layout = state.layout();
        let mut timings = Timings { seat: self.seat_seconds, ..timings(&self.groups, &state.groups) };
        let (mut settled_after, mut at_rest) = (0.0, true);
        let mut moving = None;
        if let Some(global) = self.groups.last() {
            let clock = Instant::now();
            observer.event(Event::Settling);
            (settled_after, at_rest) = self.settle(global, &mut layout, &mut state.notes)?;
            let opinions = Opinions::new(self, global, &layout, observer.stop())?;
            if finished && self.config.second_opinion {
                finished = opinions.improve(&mut layout, &mut state, observer)? == Flow::Continue;
            }
            timings.settle = clock.elapsed().as_secs_f64();
            moving = Some((global, opinions));
        }
        let clock = Instant::now();
        observer.event(Event::Parting);
        let clearances = self.part(&mut layout);
        timings.exact = clock.elapsed().as_secs_f64();

        let clock = Instant::now();
        observer.event(Event::Verifying);
        let checked = self.check(moving.as_ref(), &layout, &mut state.notes)?;
        timings.verify = clock.elapsed().as_secs_f64();
        if !clearances.complete {
            state.notes.push("the meshes are too large to be looked at whole: some may still overlap".into());
        }
        state.notes.extend(self.floating(&clearances));
        let mut placements = self.placements.clone();
        let placer = Placer { scene: self.scene, room: &self.room, forms: &self.forms, rigs: &self.rigs };
        state.notes.extend(placer.measure(&layout, &mut placements));
        if !checked.leaning.is_empty() {
            let names = checked.leaning.join(", ");
            state.notes.push(format!(
                "on a wall leans: {names}; where objects are loaded without walls, add those of report.json as static \
                 planes, or it falls"
            ));
        }
        state.notes.extend(support::detached(self.scene, &self.rigs, &layout).into_iter().map(|pair| {
            let [object, parent] = pair.map(|i| &self.scene.objects[i].name);
            format!("\"{object}\" does not touch \"{parent}\", which is to hold it, and keeps its place: see to it")
        }));
        for (object, overlap) in self.scene.objects.iter().zip(&checked.overlaps).filter(|(_, deep)| **deep > JAMMED) {
            state.notes.push(format!(
                "\"{}\" is stuck {:.0} mm deep in another object: engines throw such things apart",
                object.name,
                1e3 * overlap
            ));
        }
        let objects = self.assess(&layout, &checked);
        state.notes.extend(self.far(&objects));
        Ok(Outcome {
            room: self.room.clone(),
            placements,
            objects,
            parts: checked.written.parts,
            groups: state.groups,
            iterations: state.iterations,
            finished,
            timings,
            settled_after,
            at_rest,
            clearances,
            notes: state.notes,
        })
    }

    /// Checks a layout: what is written of it, and with the other parts. `moving`: what is movable, if anything is.
    fn check(
        &self,
        moving: Option<&(&Group, Opinions)>,
        layout: &Vec<scene::Pose>,
        notes: &mut Vec<String>,
    ) -> Result<Checked, BackendError> {
        let Some((global, opinions)) = moving else {
            notes.push("nothing in the scene is movable: no search, no simulation".into());
            let written = Written::new(self.shapes, layout, &vec![true; layout.len()]);
            let (otherwise, overlaps) = (vec![true; layout.len()], vec![0.0; layout.len()]);
            return Ok(Checked { written, verified: None, otherwise, overlaps, leaning: Vec::new() });
        };
        let (written, verified) = self.written(global, layout)?;
        let otherwise = opinions.second(layout)?;
        notes.extend(opinions.filled.iter().map(|&object| {
            let name = &self.scene.objects[object].name;
            format!("\"{name}\": convex parts of other kinds fill what is in it; load those that the result names")
        }));
        if verified.is_none() {
            notes.push("the check could not be simulated: nothing is known to be stable".into());
        }
        let (world, starts) = self.let_go(global, &written.rigs, layout);
        let depths = self.backend.overlaps(&world, &self.config.fine(), &starts)?;
        let mut overlaps = vec![0.0; layout.len()];
        for (pair, &depth) in world.pairs.iter().zip(&depths) {
            // A wall is no object.
            for &object in pair.iter().filter_map(|&body| global.objects.get(body as usize)) {
                overlaps[object] = depth.max(overlaps[object]);
            }
        }
        let leaning = match &verified {
            Some(verified) if !self.leant_on.is_empty() => self.leaning(global, &written.rigs, layout, verified)?,
            _ => Vec::new(),
        };
        Ok(Checked { written, verified, otherwise, overlaps, leaning })
    }

    /// What stays with the walls there, as `verified`, but not without them.
    fn leaning(
        &self,
        global: &Group,
        rigs: &[Rig],
        layout: &[scene::Pose],
        verified: &Verified,
    ) -> Result<Vec<String>, BackendError> {
        let world = global.world(rigs, &[], layout, &self.seated);
        let starts = global.starts(rigs, &[], layout);
        let free = verify(self.backend, &world, &self.config.fine(), &self.config.verify, &starts, &GO_ON)?;
        let still = |motions: &[Motion], body: usize| motions[body].is_still(&self.config.verify);
        let leans = |&(body, _): &(usize, usize)| still(&verified.motions, body) && !still(&free.motions, body);
        Ok(global.moving().filter(leans).map(|(_, object)| self.scene.objects[object].name.clone()).collect())
    }

    /// What rests on its convex parts far above the meshes under it.
    fn floating(&self, clearances: &Clearances) -> Vec<String> {
        let drops = self.scene.objects.iter().zip(&clearances.drops).enumerate();
        let is_seen = |i: usize| !self.scene.is_static(i) && !self.shapes[i].surface.triangles.is_empty();
        let floats =
            drops.filter(|(i, (_, drop))| clearances.complete && is_seen(*i) && drop.is_none_or(|drop| drop > FLOATS));
        let note = |(_, (object, drop)): (usize, (&Object, &Option<f64>))| {
            let far = drop.map_or_else(|| "more than 50 mm".into(), |drop| format!("{:.0} mm", 1e3 * drop));
            format!(
                "\"{}\" rests {far} above the meshes under it: its convex parts, or theirs, bulge beyond them",
                object.name
            )
        };
        floats.map(note).collect()
    }

    /// What has gone far, but not with what it is on, the farthest first.
    fn far(&self, objects: &[ObjectOutcome]) -> Option<String> {
        let went = |i: usize| objects[i].simulated && objects[i].moved > MOVED_FAR;
        let alone = |&i: &usize| went(i) && !self.scene.bearers(i).next().is_some_and(went);
        let mut far: Vec<usize> = (0..objects.len()).filter(alone).collect();
        far.sort_by(|&a, &b| objects[b].moved.total_cmp(&objects[a].moved));
        let told = far.iter().take(MOST_TOLD);
        let mut told: Vec<String> =
            told.map(|&i| format!("\"{}\" ({:.2} m)", self.scene.objects[i].name, objects[i].moved)).collect();
        if far.len() > MOST_TOLD {
            told.push(format!("{} more", far.len() - MOST_TOLD));
        }
        let note = "there was no place for it nearer, or its parent is not what bears it";
        (!far.is_empty()).then(|| format!("moved by more than {MOVED_FAR} m: {}: {note}", told.join(", ")))
    }

    fn part(&self, layout: &mut [scene::Pose]) -> Clearances {
        match self.config.exact {
            true => exact::part_meshes(self.scene, self.shapes, &self.room, layout),
            false => exact::look(self.scene, self.shapes, &self.room, layout),
        }
    }

    /// The layout as it is let go for the check, with these bodies.
    fn let_go(&self, global: &Group, rigs: &[Rig], layout: &[scene::Pose]) -> (World, Vec<Pose>) {
        (global.world(rigs, &self.leant_on, layout, &self.seated), global.starts(rigs, &self.leant_on, layout))
    }

    /// What is written of a layout, and its check, if that can be simulated: with four corners where something bears.
    /// What then moves farther than with the parts that were searched with keeps these, and if it still does, so does
    /// what bears it.
    fn written(&self, global: &Group, layout: &[scene::Pose]) -> Result<(Written, Option<Verified>), BackendError> {
        let check = |written: &Written| {
            let (world, starts) = self.let_go(global, &written.rigs, layout);
            verify(self.backend, &world, &self.config.fine(), &self.config.verify, &starts, &GO_ON)
        };
        let searched = Written::new(self.shapes, layout, &vec![true; layout.len()]);
        let known = check(&searched)?;
        if !known.usable[0] {
            return Ok((searched, None));
        }
        // Parts that somebody made are what they want.
        let mut kept: Vec<bool> = self.scene.objects.iter().map(|object| !object.convex_parts.is_empty()).collect();
        for _ in 0..FOOTINGS {
            let written = Written::new(self.shapes, layout, &kept);
            let checked = check(&written)?;
            let moves = |body: usize| !checked.usable[0] || !checked.motions[body].is_like(&known.motions[body]);
            let moving: Vec<usize> =
                global.moving().filter(|&(body, _)| moves(body)).map(|(_, object)| object).collect();
            if moving.is_empty() {
                return Ok((written, Some(checked)));
            }
            keep(&mut kept, &moving, |object| self.scene.bearers(object).next());
        }
        Ok((searched, Some(known)))
    }

    fn settle(
        &self,
        global: &Group,
        layout: &mut [scene::Pose],
        notes: &mut Vec<String>,
    ) -> Result<(f64, bool), BackendError> {
        let settings = &self.config.settle;
        if settings.max_seconds == 0.0 {
            return Ok((0.0, false));
        }
        let world = global.world(&self.rigs, &self.walls, layout, &self.seated);
        let starts = global.starts(&self.rigs, &self.walls, layout);
        let settled = settle(self.backend, &world, &self.config.fine(), settings, &starts, &to_rest)?;
        if !settled.usable[0] {
            notes.push("settling could not be simulated: the search's layout is kept as it is".into());
            return Ok((0.0, false));
        }
        if !settled.at_rest {
            notes.push(format!("something still moved after {} s of settling", settings.max_seconds));
        }
        global.adopt(&self.rigs, &starts, &settled.poses, layout);
        Ok((settled.seconds, settled.at_rest))
    }

    /// What became of every object.
    fn assess(&self, layout: &[scene::Pose], checked: &Checked) -> Vec<ObjectOutcome> {
        let Checked { written: Written { rigs, .. }, verified, otherwise, overlaps, .. } = checked;
        let mut bodies: Vec<Pose> = rigs.iter().zip(layout).map(|(rig, pose)| rig.body(pose)).collect();
        let mut motions = vec![None; layout.len()];
        if let (Some(verified), Some(global)) = (verified, self.groups.last()) {
            for (body, object) in global.moving() {
                bodies[object] = verified.poses[body];
                motions[object] = Some(verified.motions[body]);
            }
        }
        let lost = support::lost(self.scene, rigs, &bodies);
        (0..layout.len())
            .map(|i| {
                let (rig, pose, input) = (&rigs[i], &layout[i], &self.input[i]);
                let simulated = !self.scene.is_static(i);
                let turned = angle(pose, input);
                let turned_at_end = f64::from(angle_between(bodies[i].rotation, rig.body(input).rotation));
                let motion = motions[i].unwrap_or_default();
                let Motion { drift, turn, peak_speed, peak_spin } = motion;
                let still = motion.is_still(&self.config.verify);
                ObjectOutcome {
                    pose: *pose,
                    simulated,
                    moved: rig.center_of(pose).distance(rig.center_of(input)),
                    turned,
                    fallen: turned.max(turned_at_end) > FALLEN,
                    lost_support: lost[i],
                    overlap: overlaps[i].into(),
                    drift,
                    drift_turn: turn,
                    peak_speed,
                    peak_spin,
                    stable: !simulated || (motions[i].is_some() && still && overlaps[i] <= JAMMED),
                    stable_otherwise: otherwise[i],
                }
            })
            .collect()
    }
}

fn timings(groups: &[Group], records: &[GroupRecord]) -> Timings {
    let sum = |local: bool| {
        let of_kind = groups.iter().zip(records).filter(|(group, _)| group.held.is_some() == local);
        of_kind.map(|(_, record)| record.seconds).sum()
    };
    Timings { local: sum(true), global: sum(false), ..Timings::default() }
}
