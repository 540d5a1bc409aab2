//! One candidate: its state, and its collision detection.

use super::{
    broad_phase::{BroadPhase, HullPair},
    clock::{Clock, Kernel},
    contacts::{ContactSet, GROUND, Gatherer},
    narrow_phase::{self, Manifold, PairCache, Separator, manifold, passes, plane_hull},
};
use crate::world::{Capacities, Pose, SimSettings, Status, Velocity, World, constants::MAX_CAPACITY_GROWTH};
use glam::Vec3;
use std::ops::Range;

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
    caches: Vec<PairCache>,
    /// Contacts of the last substep.
    pub(super) contacts: ContactSet,
    /// No contacts have been found since `start`.
    pub(super) begins: bool,
}

/// What collision detection needs while it looks at one candidate. A group's candidates share it, because what is not
/// touched stays in the processor's cache.
#[derive(Debug, Default)]
pub struct Scratch {
    /// What the candidate had in the last substep.
    pairs: Vec<HullPair>,
    caches: Vec<PairCache>,
    contacts: ContactSet,
    gatherer: Gatherer,
    manifold: Manifold,
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
            caches: Vec::with_capacity(hull_pairs as usize),
            contacts: ContactSet::default(),
            begins: true,
        }
    }

    /// Forgets the last candidate: the bodies are at rest at `placed`, nothing touches yet.
    pub fn start(&mut self, placed: &[Pose]) {
        self.poses.copy_from_slice(placed);
        self.velocities.fill(Velocity::default());
        self.status = Status::default();
        self.broad.forget();
        self.pairs.clear();
        self.caches.clear();
        self.contacts.clear();
        self.begins = true;
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

    /// Finds the contacts of the next substep, and tells `clock` of every part and of what it found.
    pub fn collide(
        &mut self,
        world: &World,
        settings: &SimSettings,
        narrow: &Separator,
        scratch: &mut Scratch,
        clock: &mut impl Clock,
    ) {
        let dt = settings.substep();
        // Contacts act up to a small step beyond the end.
        let horizon = dt + settings.small_step();
        self.broad.update(world, &self.poses, &self.velocities, settings.contact_offset, dt);
        std::mem::swap(&mut self.pairs, &mut scratch.pairs);
        std::mem::swap(&mut self.caches, &mut scratch.caches);
        std::mem::swap(&mut self.contacts, &mut scratch.contacts);
        self.list_pairs(world, None);
        self.carry_caches(scratch);
        self.contacts.clear();
        clock.lap(Kernel::BroadPhase);
        let mut old = 0;
        let mut next = 0;
        for (index, &pair) in (0..).zip(&world.pairs) {
            if self.broad.keeps(pair) {
                self.keep(index, pair, &scratch.contacts, &mut old);
                continue;
            }
            if self.pairs.get(next).is_none_or(|listed| listed.pair != index) {
                continue;
            }
            let margin = self.broad.margin(pair);
            let [pose_a, pose_b] = pair.map(|i| self.poses[i as usize]);
            let velocities = pair.map(|i| self.velocities[i as usize]);
            let falls =
                pair.map(|i| if world.bodies[i as usize].is_static() { 0.0 } else { horizon * settings.gravity });
            scratch.gatherer.clear();
            while next < self.pairs.len() && self.pairs[next].pair == index {
                let HullPair { a, b, .. } = self.pairs[next];
                let room = self.broad.room(world, self.pairs[next]);
                let before = self.caches[next];
                let cache = &mut self.caches[next];
                next += 1;
                let poses = [&pose_a, &pose_b];
                let hulls = narrow_phase::HullPair { tables: &world.hulls, hulls: [a, b], poses, room };
                let found = narrow.separation(&hulls, margin, cache);
                clock.lap(Kernel::NarrowPhase);
                if let Some(found) = found {
                    manifold(&hulls, &found, margin, &mut scratch.manifold);
                    if passes(&hulls, &velocities, falls, horizon, &scratch.manifold) {
                        scratch.manifold.count = 0;
                    }
                    scratch.gatherer.add(scratch.manifold.normal, scratch.manifold.points());
                    clock.lap(Kernel::Manifold);
                }
                clock.pair(before, found.as_ref(), *cache, &scratch.manifold);
            }
            self.emit(index, pair, scratch, &mut old);
            clock.lap(Kernel::Contacts);
        }
        for (index, body) in world.bodies.iter().enumerate() {
            let margin = self.broad.ground_margin(index, settings.contact_offset);
            let entry = (world.pairs.len() + index) as u32;
            if self.broad.still[index] {
                self.keep(entry, [GROUND, index as u32], &scratch.contacts, &mut old);
                continue;
            }
            if body.is_static() || self.broad.lowest(index) > margin {
                continue;
            }
            scratch.gatherer.clear();
            for hull in world.hulls_of(index) {
                let out = &mut scratch.manifold;
                plane_hull(&world.hulls, hull as u32, &self.poses[index], (Vec3::Y, 0.0), margin, out);
                scratch.gatherer.add(out.normal, out.points());
                clock.ground(hull, out);
            }
            clock.lap(Kernel::Manifold);
            self.emit(entry, [GROUND, index as u32], scratch, &mut old);
            clock.lap(Kernel::Contacts);
        }
        if self.contacts.points.len() as u32 > self.capacities.contacts {
            self.grow(Status::CONTACTS, self.contacts.points.len() as u32, world);
        }
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
    fn carry_caches(&mut self, last: &Scratch) {
        self.caches.clear();
        let key = |p: &HullPair| (p.pair, p.a, p.b);
        let mut old = 0;
        for pair in &self.pairs {
            while old < last.pairs.len() && key(&last.pairs[old]) < key(pair) {
                old += 1;
            }
            let known = last.pairs.get(old).is_some_and(|o| o == pair);
            self.caches.push(if known { last.caches[old] } else { PairCache::default() });
        }
    }

    /// Merges what was gathered for a pair and makes its patches. `old` walks through the last substep's patches.
    fn emit(&mut self, pair: u32, bodies: [u32; 2], scratch: &mut Scratch, old: &mut usize) {
        let before = patches_of(pair, &scratch.contacts, old);
        scratch.gatherer.merge();
        for patch in scratch.gatherer.patches() {
            self.contacts.push(pair, bodies, &self.poses, patch, &mut scratch.contacts, before.clone());
        }
    }

    /// Takes over the last substep's patches of a pair.
    fn keep(&mut self, pair: u32, bodies: [u32; 2], last: &ContactSet, old: &mut usize) {
        let before = patches_of(pair, last, old);
        self.contacts.keep(bodies, &self.poses, last, before);
    }

    /// Measures the deepest overlap of the parts of each pair of `World::pairs` at the present poses, m.
    pub fn measure_depths(&mut self, world: &World, narrow: &Separator, depths: &mut [f32]) {
        self.broad.forget();
        self.broad.update(world, &self.poses, &self.velocities, 0.0, 0.0);
        self.list_pairs(world, Some(0.0));
        depths.fill(0.0);
        for &HullPair { pair, a, b } in &self.pairs {
            let [pose_a, pose_b] = world.pairs[pair as usize].map(|i| self.poses[i as usize]);
            let (poses, room) = ([&pose_a, &pose_b], narrow_phase::HullPair::ANY_ROOM);
            let hulls = narrow_phase::HullPair { tables: &world.hulls, hulls: [a, b], poses, room };
            let deepest = &mut depths[pair as usize];
            *deepest = deepest.max(narrow.depth(&hulls, *deepest));
        }
        // The list holds other margins' pairs now: it must not be taken for the last substep's.
        self.broad.forget();
        self.pairs.clear();
        self.caches.clear();
    }
}

/// The last substep's patches of a pair. `old` is where they end; all that begin before it are of earlier pairs.
fn patches_of(pair: u32, last: &ContactSet, old: &mut usize) -> Range<usize> {
    let patches = &last.patches;
    let first = *old + patches[*old..].iter().take_while(|patch| patch.pair < pair).count();
    *old = first + patches[first..].iter().take_while(|patch| patch.pair == pair).count();
    first..*old
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::{Group, contacts::Contact};
    use crate::shape::box_corners;
    use crate::world::{BodyDef, NarrowPhase, constants::RECYCLING_DISTANCE};
    use glam::Quat;

    /// A flat brick with a cube on it, at rest after a second and a half.
    fn at_rest() -> (World, SimSettings, Separator, Group) {
        let brick = |half: Vec3, y: f32| {
            let start = Pose::new(Quat::from_rotation_y(y), Vec3::Y * y);
            let inertia = Vec3::splat(0.7 * half.max_element() * half.max_element());
            BodyDef { parts: vec![box_corners(half)], mass: 1.0, inertia, unit: 0, start, reference: start }
        };
        let world = World::new(&[brick(Vec3::new(0.2, 0.05, 0.2), 0.051), brick(Vec3::splat(0.1), 0.202)], &[0]);
        let settings = SimSettings::default();
        let narrow = Separator::new(NarrowPhase::Twin, &world.hulls);
        let mut group = Group::new(&world, 1);
        group.start(&world.start);
        (0..90).for_each(|_| group.step(&world, &settings, &narrow));
        (world, settings, narrow, group)
    }

    #[test]
    fn what_rests_keeps_its_contacts_as_they_would_be_found() {
        let (world, settings, narrow, mut group) = at_rest();
        let workspace = &mut group.candidates_mut()[0];
        // The one that rests is pressed in by a hundredth of a millimetre, which is no more than counts as still.
        workspace.poses[1].translation.y -= 0.2 * RECYCLING_DISTANCE;
        let mut fresh = Group::new(&world, 1);
        fresh.start(&workspace.poses);
        [&mut group, &mut fresh].into_iter().for_each(|group| group.collide(&world, &settings, &narrow));
        let (workspace, fresh) = (&group.candidates()[0], &fresh.candidates()[0]);
        assert_eq!((workspace.pairs().len(), fresh.pairs().len()), (0, 1), "hulls looked at");
        let (kept, found) = (workspace.contacts(), fresh.contacts());
        assert_eq!((kept.points.len(), kept.patches.len()), (found.points.len(), found.patches.len()));
        assert!(kept.points.len() >= 8, "four points below each: {}", kept.points.len());
        for contact in &kept.points {
            let near = |other: &&Contact| other.point.distance(contact.point) < 1e-4;
            let same = found.points.iter().find(near).unwrap_or_else(|| panic!("{contact:?} is not found"));
            assert!((same.separation - contact.separation).abs() < 1e-6, "{contact:?}, {same:?}");
        }
        // What they carry is also known before the first substep.
        let load = |set: &ContactSet, patch: usize| -> f32 {
            set.points_of(&set.patches[patch]).iter().map(|contact| contact.impulse).sum()
        };
        for (patch, weight) in [(0, 1.0), (1, 2.0)] {
            let expected = -weight * settings.gravity * settings.small_step();
            for set in [kept, found] {
                assert!((load(set, patch) / expected - 1.0).abs() < 0.01, "{} for {expected} N s", load(set, patch));
            }
        }
    }

    #[test]
    fn contacts_are_found_anew_where_something_moved_or_was_measured() {
        let (world, settings, narrow, mut group) = at_rest();
        let mut listed = |change: &dyn Fn(&mut Workspace)| {
            change(&mut group.candidates_mut()[0]);
            group.collide(&world, &settings, &narrow);
            group.candidates()[0].pairs().len()
        };
        assert_eq!(listed(&|_| ()), 0, "at rest");
        assert_eq!(listed(&|at_rest| at_rest.poses[1].translation.x += 2.0 * RECYCLING_DISTANCE), 1, "shifted");
        assert_eq!(listed(&|_| ()), 0, "and again at rest");
        let turn = Quat::from_rotation_y(2.0 * RECYCLING_DISTANCE / world.bodies[0].radius);
        assert_eq!(listed(&|at_rest| at_rest.poses[0].rotation = turn * at_rest.poses[0].rotation), 1, "turned");
        assert_eq!(listed(&|at_rest| at_rest.velocities[1].linear.x = 0.1), 1, "faster, and so with a larger margin");
        assert_eq!(listed(&|at_rest| at_rest.measure_depths(&world, &narrow, &mut [0.0])), 1, "measured");
    }
}
