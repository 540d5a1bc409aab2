//! The whole run: groups in order, then settling, then the check, then what became of every object.

use super::{
    Checkpoint, Clearances, Config, Event, GroupRecord, IterationRecord, ObjectOutcome, Observer, OptimizeError,
    Outcome, Timings, cem,
    config::ResultFrom,
    exact,
    groups::{self, Group},
    projection,
    rig::Rig,
    seat::Seat,
    settle::settle,
    support,
    verify::{Motion, Verified, verify},
};
use crate::scene::{self, Scene};
use crate::shape::Shape;
use crate::world::{Backend, BackendError, Best, Flow, MemoryPlan, Pose, SearchSettings, Stream, World, angle_between};
use std::f64::consts::FRAC_PI_6;
use std::time::Instant;

/// An object turned by more than this from its input has fallen, rad.
const FALLEN: f64 = FRAC_PI_6;

/// Finds a layout near the scene's in which everything stands. `shapes` are the objects' shapes, in the scene's order.
///
/// The same scene, shapes, configuration, seed and backend give the same bits, also over any number of interruptions
/// and resumptions. If no candidate of a group can be simulated the group keeps its layout and a note says so.
///
/// # Errors
/// A configuration that makes no sense, a checkpoint of another run, or a backend that cannot go on.
pub fn run(
    scene: &Scene,
    shapes: &[Shape],
    backend: &dyn Backend,
    config: &Config,
    seed: u64,
    resume: Option<Checkpoint>,
    observer: &mut dyn Observer,
) -> Result<Outcome, OptimizeError> {
    let run = Run::new(scene, shapes, backend, config, seed, observer)?;
    let mut state = Checkpoint::start(scene, shapes, config, seed);
    state.set_layout(&run.seated);
    if let Some(checkpoint) = resume {
        checkpoint.check(&state, run.groups.len())?;
        state = checkpoint;
    }
    let mut finished = run.announce(observer)? == Flow::Continue;
    while finished && state.completed < run.groups.len() {
        finished = run.search(&mut state, observer)? == Flow::Continue;
    }
    run.finish(state, finished, observer)
}

/// What stays the same over all groups.
pub(super) struct Run<'a> {
    scene: &'a Scene,
    shapes: &'a [Shape],
    pub rigs: Vec<Rig>,
    input: Vec<scene::Pose>,
    /// What the layout term compares with: the input at the heights of its supports.
    pub seated: Vec<scene::Pose>,
    seat_seconds: f64,
    pub groups: Vec<Group>,
    pub backend: &'a dyn Backend,
    config: &'a Config,
    pub seed: u64,
}

impl<'a> Run<'a> {
    /// Plans the groups and sets the objects onto their supports.
    pub fn new(
        scene: &'a Scene,
        shapes: &'a [Shape],
        backend: &'a dyn Backend,
        config: &'a Config,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<Self, OptimizeError> {
        config.validate()?;
        let rigs: Vec<Rig> = shapes.iter().map(Rig::new).collect();
        let input: Vec<scene::Pose> = scene.objects.iter().map(|object| object.pose).collect();
        let mut seated = input.clone();
        let clock = Instant::now();
        if config.seat {
            observer.event(Event::Seating);
            let simulation = &config.fine();
            Seat { scene, rigs: &rigs, backend, simulation, settings: &config.settle }.run(&mut seated)?;
        }
        let seat_seconds = clock.elapsed().as_secs_f64();
        Ok(Self {
            scene,
            shapes,
            rigs,
            input,
            seated,
            seat_seconds,
            groups: groups::plan(scene, config.global_only),
            backend,
            config,
            seed,
        })
    }

    /// The second mean that the group's search starts from, if it has one.
    pub fn second_start(&self, group: &Group, layout: &[scene::Pose]) -> Option<Vec<f32>> {
        if self.config.project { projection::start(self.scene, &self.rigs, layout, group) } else { None }
    }

    pub fn settings(&self, group: &Group) -> SearchSettings {
        let cem = if group.held.is_some() { &self.config.local } else { &self.config.global };
        SearchSettings {
            simulation: self.config.simulation.clone(),
            energy: self.config.energy.clone(),
            cem: cem.clone(),
        }
    }

    /// Tells the plan, and refuses what does not fit into memory.
    pub fn announce(&self, observer: &mut dyn Observer) -> Result<Flow, BackendError> {
        let names: Vec<String> = self.groups.iter().map(|group| group.name.clone()).collect();
        let candidates: Vec<u64> = (self.groups.iter().map(|group| self.settings(group).cem))
            .map(|cem| u64::from(cem.candidates) * u64::from(cem.iterations) * u64::from(cem.episodes))
            .collect();
        let mut memory = String::from("nothing to search");
        if let Some(global) = self.groups.last() {
            let world = global.world(&self.rigs, &self.seated, &self.seated);
            let candidates = self.config.global.candidates.max(self.config.local.candidates);
            let MemoryPlan { bytes, at_once } = self.backend.memory(&world, candidates);
            let split = if at_once < candidates { format!(", {at_once} at a time") } else { String::new() };
            memory = format!(
                "{} bodies of {} hulls, {candidates} candidates{split}: about {} MB",
                world.bodies.len(),
                world.hulls.hulls.len(),
                bytes.div_ceil(1_000_000)
            );
            if let Some(free) = self.backend.free_bytes().filter(|free| bytes > *free) {
                return Err(BackendError::Capacity(format!(
                    "memory: {memory}, but {} MB are free; take fewer candidates or objects",
                    free / 1_000_000
                )));
            }
        }
        Ok(observer.event(Event::Plan { groups: &names, candidates: &candidates, memory: &memory }))
    }

    /// Searches the next group and adopts its winner. `Flow::Stop` if the observer ended it before its time; what was
    /// found so far is adopted, but the group does not count as done.
    pub fn search(&self, state: &mut Checkpoint, observer: &mut dyn Observer) -> Result<Flow, OptimizeError> {
        let clock = Instant::now();
        let index = state.completed;
        let group = &self.groups[index];
        let settings = self.settings(group);
        let mut layout = state.layout();
        let lift = group.lift(&self.rigs, &layout);
        let world = group.world(&self.rigs, &layout, &self.seated);
        let stream = Stream { seed: self.seed, stage: index as u32 };
        let second = self.second_start(group, &layout);
        let iterations = settings.cem.iterations * settings.cem.episodes;
        let searched = cem::search(self.backend, &world, &settings, stream, second, &mut |stats, _| {
            state.iterations.push(IterationRecord { group: index, stats: stats.clone() });
            observer.event(Event::Iteration { group: index, iterations, stats })
        })?;
        match &searched.best {
            Some(best) => {
                let ends: Vec<Pose> = self.result(group, best).iter().map(|pose| pose.raised(-lift)).collect();
                let starts: Vec<Pose> = world.start.iter().map(|pose| pose.raised(-lift)).collect();
                self.adopt(group, &starts, &ends, &mut layout);
                state.set_layout(&layout);
            }
            None => state.notes.push(format!(
                "{}: no candidate could be simulated, the group keeps its layout; see the status counts in the report",
                group.name
            )),
        }
        state.groups.push(GroupRecord {
            name: group.name.clone(),
            units: group.unit_roots().map(|object| self.scene.objects[object].name.clone()).collect(),
            best: searched.best.as_ref().map(|best| best.energy),
            winner: searched.best.as_ref().map(|best| (best.iteration, best.candidate)),
            flagged: searched.flagged,
            seconds: clock.elapsed().as_secs_f64(),
            kernels: searched.kernels,
        });
        if searched.stopped {
            return Ok(Flow::Stop);
        }
        state.completed += 1;
        let flow = observer.event(Event::GroupDone { group: index, checkpoint: state });
        Ok(if state.completed == self.groups.len() { Flow::Continue } else { flow })
    }

    /// Local groups keep where their winner came to rest, as in the released code; the global stage is configurable.
    fn result<'b>(&self, group: &Group, best: &'b Best) -> &'b [Pose] {
        match self.config.settle.from {
            ResultFrom::Placed if group.held.is_none() => &best.placed,
            _ => &best.settled,
        }
    }

    /// Takes over the poses of the bodies that moved; everything else keeps its pose to the bit.
    fn adopt(&self, group: &Group, starts: &[Pose], ends: &[Pose], layout: &mut [scene::Pose]) {
        for (body, object) in group.moving() {
            if starts[body] != ends[body] {
                layout[object] = self.rigs[object].object(&ends[body]);
            }
        }
    }

    fn starts(&self, group: &Group, layout: &[scene::Pose]) -> Vec<Pose> {
        group.objects.iter().map(|&object| self.rigs[object].body(&layout[object])).collect()
    }

    /// Settles and checks the layout that the search left. Both also run after an early stop: they are short, and an
    /// unfinished layout needs them most.
    fn finish(
        &self,
        mut state: Checkpoint,
        finished: bool,
        observer: &mut dyn Observer,
    ) -> Result<Outcome, OptimizeError> {
        let mut layout = state.layout();
        let mut timings = Timings { seat: self.seat_seconds, ..timings(&self.groups, &state.groups) };
        let (mut settled_after, mut at_rest) = (0.0, true);
        let mut verified = None;
        let mut overlaps = vec![0.0; layout.len()];
        let clearances;
        if let Some(global) = self.groups.last() {
            let world = global.world(&self.rigs, &layout, &self.seated);
            let clock = Instant::now();
            observer.event(Event::Settling);
            let starts = self.starts(global, &layout);
            (settled_after, at_rest) = self.settle(global, &world, &starts, &mut layout, &mut state.notes)?;
            timings.settle = clock.elapsed().as_secs_f64();

            let clock = Instant::now();
            observer.event(Event::Parting);
            clearances = self.part(&mut layout);
            timings.exact = clock.elapsed().as_secs_f64();

            let clock = Instant::now();
            observer.event(Event::Verifying);
            let (simulation, starts) = (self.config.fine(), self.starts(global, &layout));
            verified = verify(self.backend, &world, &simulation, &self.config.verify, &starts)?;
            timings.verify = clock.elapsed().as_secs_f64();
            let depths = self.backend.overlaps(&world, &simulation, &starts)?;
            for (pair, &depth) in world.pairs.iter().zip(&depths) {
                for object in pair.map(|body| global.objects[body as usize]) {
                    overlaps[object] = depth.max(overlaps[object]);
                }
            }
            if verified.is_none() {
                state.notes.push("the check could not be simulated: nothing is known to be stable".into());
            }
        } else {
            clearances = self.part(&mut layout);
            state.notes.push("nothing in the scene is movable: no search, no simulation".into());
        }
        if !clearances.complete {
            state.notes.push("the meshes are too large to be looked at whole: some may still overlap".into());
        }
        Ok(Outcome {
            objects: self.assess(&layout, verified.as_ref(), &overlaps),
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

    fn part(&self, layout: &mut [scene::Pose]) -> Clearances {
        match self.config.exact {
            true => exact::part_meshes(self.scene, self.shapes, layout),
            false => exact::look(self.scene, self.shapes, layout),
        }
    }

    fn settle(
        &self,
        global: &Group,
        world: &World,
        starts: &[Pose],
        layout: &mut [scene::Pose],
        notes: &mut Vec<String>,
    ) -> Result<(f64, bool), BackendError> {
        let settings = &self.config.settle;
        if settings.max_seconds == 0.0 {
            return Ok((0.0, false));
        }
        match settle(self.backend, world, &self.config.fine(), settings, starts)? {
            Some(settled) => {
                if !settled.at_rest {
                    notes.push(format!("something still moved after {} s of settling", settings.max_seconds));
                }
                self.adopt(global, starts, &settled.poses, layout);
                Ok((settled.seconds, settled.at_rest))
            }
            None => {
                notes.push("settling could not be simulated: the search's layout is kept as it is".into());
                Ok((0.0, false))
            }
        }
    }

    /// What became of every object. `overlaps`: deepest overlap with another, m.
    fn assess(&self, layout: &[scene::Pose], verified: Option<&Verified>, overlaps: &[f32]) -> Vec<ObjectOutcome> {
        let mut bodies: Vec<Pose> = self.rigs.iter().zip(layout).map(|(rig, pose)| rig.body(pose)).collect();
        let mut motions = vec![None; layout.len()];
        if let (Some(verified), Some(global)) = (verified, self.groups.last()) {
            for (body, object) in global.moving() {
                bodies[object] = verified.poses[body];
                motions[object] = Some(verified.motions[body]);
            }
        }
        let lost = support::lost(self.scene, &self.rigs, &bodies);
        (0..layout.len())
            .map(|i| {
                let (rig, pose, input) = (&self.rigs[i], &layout[i], &self.input[i]);
                let simulated = !self.scene.is_static(i);
                let turned = angle(pose, input);
                let turned_at_end = f64::from(angle_between(bodies[i].rotation, rig.body(input).rotation));
                let limits = &self.config.verify;
                let Motion { drift, turn, peak_speed, peak_spin } = motions[i].unwrap_or_default();
                let still = drift <= limits.max_drift.into() && turn <= limits.max_turn.into();
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
                    stable: !simulated || (motions[i].is_some() && still),
                }
            })
            .collect()
    }
}

/// Angle between two poses, rad; accurate for small ones.
fn angle(a: &scene::Pose, b: &scene::Pose) -> f64 {
    let d = a.rotation.conjugate() * b.rotation;
    2.0 * d.xyz().length().atan2(d.w.abs())
}

fn timings(groups: &[Group], records: &[GroupRecord]) -> Timings {
    let sum = |local: bool| {
        let of_kind = groups.iter().zip(records).filter(|(group, _)| group.held.is_some() == local);
        of_kind.map(|(_, record)| record.seconds).sum()
    };
    Timings { local: sum(true), global: sum(false), ..Timings::default() }
}
