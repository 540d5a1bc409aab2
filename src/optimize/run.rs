//! The whole run: what is planned, and the search of one group after the other. How it ends is `finish`.

use super::{
    Checkpoint, Config, Event, GroupRecord, IterationRecord, Observer, OptimizeError, Outcome, cem,
    config::ResultFrom,
    groups::{self, Group},
    projection,
    rig::Rig,
    room::{Form, Placement, Placer, Room, stands},
    seat::{Seat, Unsteady},
};
use crate::scene::{self, Parent, Scene};
use crate::shape::Shape;
use crate::world::{Backend, BackendError, Best, BodyDef, Flow, MemoryPlan, Pose, SearchSettings, Stream};
use std::time::Instant;

/// Finds a layout near the scene's in which everything stands. `shapes` are the objects' shapes, in the scene's order;
/// without alternatives they are their own second opinion.
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
    pub scene: &'a Scene,
    pub shapes: &'a [Shape],
    pub rigs: Vec<Rig>,
    /// The same objects as their other decompositions have them, and the second of these with other masses, too.
    pub alternatives: [Vec<Rig>; 2],
    pub input: Vec<scene::Pose>,
    /// What the layout term compares with: the input at the heights of its supports, on its walls and ceiling.
    pub seated: Vec<scene::Pose>,
    pub seat_seconds: f64,
    pub room: Room,
    pub forms: Vec<Form>,
    pub placements: Vec<Option<Placement>>,
    /// Walls that bear, in every group's world.
    pub walls: Vec<BodyDef>,
    /// Those of them that something was set to lean on. Only these are there when a layout is let go: what came to lean
    /// on another by chance falls wherever there are no walls.
    pub leant_on: Vec<BodyDef>,
    /// Objects that stay on nothing as they were reconstructed.
    pub rolling: Vec<usize>,
    pub groups: Vec<Group>,
    pub backend: &'a dyn Backend,
    pub config: &'a Config,
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
        let other = |shape: &Shape, which: usize| match shape.alternatives.get(which) {
            Some(alternative) => Rig::alternative(alternative),
            None => Rig::new(shape),
        };
        let first = shapes.iter().map(|shape| other(shape, 0)).collect();
        let second = shapes.iter().map(|shape| other(shape, 1));
        let second = second.zip(&scene.objects).map(|(rig, object)| rig.with_stated_mass(object.mass)).collect();
        let input: Vec<scene::Pose> = scene.objects.iter().map(|object| object.pose).collect();
        let mut run = Self {
            scene,
            shapes,
            seated: input.clone(),
            input,
            seat_seconds: 0.0,
            room: Room::default(),
            forms: Form::all(shapes),
            placements: vec![None; shapes.len()],
            walls: Vec::new(),
            leant_on: Vec::new(),
            rolling: Vec::new(),
            rigs,
            alternatives: [first, second],
            groups: Vec::new(),
            backend,
            config,
            seed,
        };
        let clock = Instant::now();
        run.arrange(observer)?;
        run.seat_seconds = clock.elapsed().as_secs_f64();
        Ok(run)
    }

    /// Sets the objects onto their supports: first what stands on the ground, and at walls against these, then what that
    /// bears, then what is on walls and ceiling, which gives way to it, then what that bears.
    fn arrange(&mut self, observer: &mut dyn Observer) -> Result<(), OptimizeError> {
        let scene = self.scene;
        let mut layout = self.input.clone();
        let mut room = match self.config.room {
            true => Room::new(scene, &self.forms, &layout),
            false => Room::default(),
        };
        let hangs = |object: usize| !stands(scene, object);
        let on_ground = |object: usize| !hangs(object) && matches!(scene.objects[object].parent, Parent::Root(_));
        let on_others = |object: usize| !hangs(object) && !on_ground(object);
        let (mut unsteady, mut bearers) = (Unsteady::default(), vec![Vec::new(); layout.len()]);
        if self.config.seat {
            observer.event(Event::Seating);
            unsteady = self.seat(&room).run(on_ground, hangs, &mut layout, &mut bearers)?;
        }
        room.keep_needed(scene, &self.forms, &unsteady.leaning, &layout);
        let placer = Placer { scene, room: &room, forms: &self.forms, rigs: &self.rigs };
        if !room.sides.is_empty() {
            observer.event(Event::Placing);
            placer.furnish(on_ground, &unsteady.leaning, &mut layout, &mut self.placements);
        }
        if self.config.seat {
            let others = self.seat(&room).run(on_others, |i| !on_others(i), &mut layout, &mut bearers)?;
            unsteady.rolling.extend(others.rolling);
        }
        if !room.sides.is_empty() {
            placer.furnish(on_others, &[], &mut layout, &mut self.placements);
            let hung = placer.hang(&mut layout, &mut self.placements);
            room.hung = hung;
        }
        if self.config.seat {
            let others = self.seat(&room).run(hangs, |i| !hangs(i), &mut layout, &mut bearers)?;
            unsteady.rolling.extend(others.rolling);
        }
        self.walls = room.bodies(|_| true, &self.forms, &layout);
        self.leant_on = room.bodies(|side| side.leant_on, &self.forms, &layout);
        self.groups = groups::plan(self.scene, self.config.global_only, &bearers);
        (self.room, self.seated, self.rolling) = (room, layout, unsteady.rolling);
        Ok(())
    }

    pub fn seat<'b>(&'b self, room: &'b Room) -> Seat<'b> {
        let Self { scene, rigs, alternatives, backend, forms, .. } = self;
        let Config { settle: settings, energy, .. } = self.config;
        let (simulation, position) = (self.config.fine(), f64::from(energy.position));
        Seat {
            scene,
            rigs,
            alternatives,
            backend: *backend,
            simulation,
            settings,
            position,
            room,
            forms,
            loaded: false,
        }
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
            let world = global.world(&self.rigs, &self.walls, &self.seated, &self.seated);
            let plan = |group| {
                let settings = self.settings(group);
                (self.backend.memory(&world, &settings), settings.cem)
            };
            let plans = self.groups.iter().map(plan).max_by_key(|(plan, _)| plan.bytes);
            let (MemoryPlan { bytes, at_once }, cem) = plans.unwrap_or_else(|| plan(global));
            let (candidates, drawn) = (cem.candidates, cem.drawn());
            let choice = if drawn > candidates { format!(" of {drawn}") } else { String::new() };
            let split = if at_once < candidates { format!(", {at_once} at a time") } else { String::new() };
            memory = format!(
                "{} bodies of {} hulls, {candidates} candidates{choice}{split}: about {} MB",
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
        let world = group.world(&self.rigs, &self.walls, &layout, &self.seated);
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
                group.adopt(&self.rigs, &starts, &ends, &mut layout);
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
            steps: searched.steps,
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
}
