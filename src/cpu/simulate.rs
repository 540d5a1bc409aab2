//! One candidate: its state, and its collision detection.

use super::{
    broad_phase::{BroadPhase, HullPair},
    clock::{Clock, Kernel},
    contacts::{ContactSet, GROUND, Gatherer},
    narrow_phase::{self, Manifold, PairCache, Separator, manifold, passes, plane_hull},
};
use crate::world::{Capacities, Pose, SimSettings, Status, Velocity, World, constants::MAX_CAPACITY_GROWTH};
use glam::Vec3;

/// Everything that one candidate needs besides the world; made once per thread and reused.
pub struct Workspace {
    /// Pose of every body, centre of mass and principal axes.
    pub poses: Vec<Pose>,
    /// Velocity of every body.
    pub velocities: Vec<Velocity>,
    /// What went wrong since `start`.
    pub status: Status,
    /// Slot sizes; they grow when a candidate needs more.
    capacities: Capacities,
    broad: BroadPhase,
    pairs: Vec<HullPair>,
    old_pairs: Vec<HullPair>,
    caches: Vec<PairCache>,
    old_caches: Vec<PairCache>,
    gatherer: Gatherer,
    manifold: Manifold,
    /// Contacts of the last substep.
    pub(super) contacts: ContactSet,
    old_contacts: ContactSet,
}

impl Workspace {
    /// Scratch for one candidate of `world`.
    pub fn new(world: &World) -> Self {
        let hull_pairs = world.capacities.hull_pairs;
        Self {
            poses: world.start.clone(),
            velocities: vec![Velocity::default(); world.bodies.len()],
            status: Status::default(),
            capacities: world.capacities,
            broad: BroadPhase::default(),
            pairs: Vec::with_capacity(hull_pairs as usize),
            old_pairs: Vec::with_capacity(hull_pairs as usize),
            caches: Vec::with_capacity(hull_pairs as usize),
            old_caches: Vec::with_capacity(hull_pairs as usize),
            gatherer: Gatherer::default(),
            manifold: Manifold::default(),
            contacts: ContactSet::default(),
            old_contacts: ContactSet::default(),
        }
    }

    /// Forgets the last candidate: the bodies are at rest at `placed`, nothing touches yet.
    pub fn start(&mut self, placed: &[Pose]) {
        self.poses.copy_from_slice(placed);
        self.velocities.fill(Velocity::default());
        self.status = Status::default();
        self.pairs.clear();
        self.caches.clear();
        self.contacts.clear();
    }

    /// Contacts of the last substep.
    pub fn contacts(&self) -> &ContactSet {
        &self.contacts
    }

    /// Boxes of the last substep.
    pub fn broad_phase(&self) -> &BroadPhase {
        &self.broad
    }

    /// Hull pairs of the last substep.
    pub fn pairs(&self) -> &[HullPair] {
        &self.pairs
    }

    /// Flags a candidate that has left the numbers.
    pub(super) fn check(&mut self) {
        if self.poses.iter().any(|p| !p.is_finite()) || self.velocities.iter().any(|v| !v.is_finite()) {
            self.status.insert(Status::NOT_FINITE);
        }
    }

    /// Finds the contacts of the next substep.
    pub fn collide(&mut self, world: &World, settings: &SimSettings, narrow: &Separator) {
        self.collide_timed(world, settings, narrow, &mut ());
    }

    /// The same, and tells `clock` of every part and of what it found.
    pub fn collide_timed(&mut self, world: &World, settings: &SimSettings, narrow: &Separator, clock: &mut impl Clock) {
        let dt = settings.substep();
        // Contacts act up to a small step beyond the end.
        let horizon = dt + settings.small_step();
        self.broad.update(world, &self.poses, &self.velocities, settings.contact_offset, dt);
        std::mem::swap(&mut self.pairs, &mut self.old_pairs);
        std::mem::swap(&mut self.caches, &mut self.old_caches);
        std::mem::swap(&mut self.contacts, &mut self.old_contacts);
        self.list_pairs(world, None);
        self.carry_caches();
        self.contacts.clear();
        clock.lap(Kernel::BroadPhase);
        let mut old = 0;
        let mut next = 0;
        while next < self.pairs.len() {
            let index = self.pairs[next].pair;
            let pair = world.pairs[index as usize];
            let margin = self.broad.margin(pair);
            let [pose_a, pose_b] = pair.map(|i| self.poses[i as usize]);
            let velocities = pair.map(|i| self.falling(world, horizon * settings.gravity, i as usize));
            self.gatherer.clear();
            while next < self.pairs.len() && self.pairs[next].pair == index {
                let HullPair { a, b, .. } = self.pairs[next];
                let before = self.caches[next];
                let cache = &mut self.caches[next];
                next += 1;
                let hulls = narrow_phase::HullPair { tables: &world.hulls, hulls: [a, b], poses: [&pose_a, &pose_b] };
                let found = narrow.separation(&hulls, margin, cache);
                clock.lap(Kernel::NarrowPhase);
                if let Some(found) = found {
                    manifold(&hulls, &found, margin, &mut self.manifold);
                    if passes(&hulls, &velocities, horizon, &self.manifold) {
                        self.manifold.count = 0;
                    }
                    self.gatherer.add(self.manifold.normal, self.manifold.points());
                    clock.lap(Kernel::Manifold);
                }
                clock.pair(before, found.as_ref(), *cache, &self.manifold);
            }
            self.emit(index, pair, &mut old);
            clock.lap(Kernel::Contacts);
        }
        for (index, body) in world.bodies.iter().enumerate() {
            let margin = self.broad.ground_margin(index, settings.contact_offset);
            if body.is_static() || self.broad.lowest(index) > margin {
                continue;
            }
            self.gatherer.clear();
            for hull in world.hulls_of(index) {
                let out = &mut self.manifold;
                plane_hull(&world.hulls, hull as u32, &self.poses[index], (Vec3::Y, 0.0), margin, out);
                self.gatherer.add(out.normal, out.points());
                clock.ground(hull, out);
            }
            clock.lap(Kernel::Manifold);
            self.emit((world.pairs.len() + index) as u32, [GROUND, index as u32], &mut old);
            clock.lap(Kernel::Contacts);
        }
        if self.contacts.points.len() as u32 > self.capacities.contacts {
            self.grow(Status::CONTACTS, self.contacts.points.len() as u32, world);
        }
    }

    /// A body's velocity if nothing touches it; gravity adds `fall` (m/s) to the upward one.
    fn falling(&self, world: &World, fall: f32, body: usize) -> Velocity {
        let mut velocity = self.velocities[body];
        velocity.linear.y += if world.bodies[body].is_static() { 0.0 } else { fall };
        velocity
    }

    /// Lists overlapping hull pairs, growing the slots when they do not fit. `margin`: one for all pairs, or by speed.
    fn list_pairs(&mut self, world: &World, margin: Option<f32>) {
        loop {
            let by_speed = |pair| margin.unwrap_or_else(|| self.broad.margin(pair));
            let count = self.broad.pairs(world, by_speed, self.capacities.hull_pairs, &mut self.pairs);
            if count <= self.capacities.hull_pairs || !self.grow(Status::HULL_PAIRS, count, world) {
                break;
            }
        }
    }

    /// Makes room for `needed` slots; past the limit the candidate is flagged instead.
    fn grow(&mut self, what: Status, needed: u32, world: &World) -> bool {
        let (slots, first) = match what {
            Status::HULL_PAIRS => (&mut self.capacities.hull_pairs, world.capacities.hull_pairs),
            _ => (&mut self.capacities.contacts, world.capacities.contacts),
        };
        if needed > first.saturating_mul(MAX_CAPACITY_GROWTH) {
            self.status.insert(what);
            return false;
        }
        *slots = needed.next_power_of_two();
        true
    }

    /// Hands the separating axes of the last substep to the same hull pairs. Both lists are in the same order.
    fn carry_caches(&mut self) {
        self.caches.clear();
        let key = |p: &HullPair| (p.pair, p.a, p.b);
        let mut old = 0;
        for pair in &self.pairs {
            while old < self.old_pairs.len() && key(&self.old_pairs[old]) < key(pair) {
                old += 1;
            }
            let known = self.old_pairs.get(old).is_some_and(|o| o == pair);
            self.caches.push(if known { self.old_caches[old] } else { PairCache::default() });
        }
    }

    /// Merges what was gathered for a pair and makes its patches. `old` walks through the last substep's patches.
    fn emit(&mut self, pair: u32, bodies: [u32; 2], old: &mut usize) {
        let patches = &self.old_contacts.patches;
        let first = *old + patches[*old..].iter().take_while(|patch| patch.pair < pair).count();
        *old = first + patches[first..].iter().take_while(|patch| patch.pair == pair).count();
        self.gatherer.merge();
        for patch in self.gatherer.patches() {
            self.contacts.push(pair, bodies, &self.poses, patch, &mut self.old_contacts, first..*old);
        }
    }

    /// Measures the deepest overlap of the parts of each pair of `World::pairs` at the present poses, m.
    pub fn measure_depths(&mut self, world: &World, narrow: &Separator, depths: &mut [f32]) {
        self.broad.update(world, &self.poses, &self.velocities, 0.0, 0.0);
        self.list_pairs(world, Some(0.0));
        depths.fill(0.0);
        for &HullPair { pair, a, b } in &self.pairs {
            let [pose_a, pose_b] = world.pairs[pair as usize].map(|i| self.poses[i as usize]);
            let hulls = narrow_phase::HullPair { tables: &world.hulls, hulls: [a, b], poses: [&pose_a, &pose_b] };
            let deepest = &mut depths[pair as usize];
            *deepest = deepest.max(narrow.depth(&hulls, *deepest));
        }
        // The list holds other margins' pairs now: it must not be taken for the last substep's.
        self.pairs.clear();
        self.caches.clear();
    }
}
