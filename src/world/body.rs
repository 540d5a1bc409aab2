//! Bodies, units and the table of a group's world.

use super::{
    HullTables, Pose,
    constants::{MIN_INERTIA_RATIO, SLENDER_INERTIA_RATIO},
};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// `Body::unit` of a body that never moves: static objects and the held root of a local group.
pub const STATIC: u32 = u32::MAX;

/// One rigid body as the kernels read it. Its frame is its centre of mass with principal inertia axes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Body {
    /// First of its hulls.
    pub first_hull: u32,
    /// Number of its hulls.
    pub hull_count: u32,
    /// The unit that moves it, or `STATIC`.
    pub unit: u32,
    /// 1 / kg, 0 if static.
    pub inverse_mass: f32,
    /// 1 / (kg m²) about the principal axes, 0 if static.
    pub inverse_inertia: Vec3,
    /// Largest distance of a vertex from the centre of mass, m.
    pub radius: f32,
}

impl Body {
    /// True for a body that no force moves.
    pub fn is_static(&self) -> bool {
        self.unit == STATIC
    }

    /// True if it is much longer than wide.
    pub fn is_slender(&self) -> bool {
        self.inverse_inertia.max_element() > SLENDER_INERTIA_RATIO * self.inverse_inertia.min_element()
    }

    /// One for every principal axis about which it may turn by some degrees and keep about the inertia that it had,
    /// nought for the others: all three, but of what is slender only its length, across which it weighs about the same.
    pub fn round_axes(&self) -> Vec3 {
        let most = if self.is_slender() { self.inverse_inertia.max_element() } else { 0.0 };
        self.inverse_inertia.map(|inverse| if inverse >= most { 1.0 } else { 0.0 })
    }
}

/// What a caller says of a body; `World::new` makes the tables.
#[derive(Clone, Debug)]
pub struct BodyDef {
    /// Convex parts, vertices in the body frame (origin at the centre of mass, principal axes), m.
    pub parts: Vec<Vec<Vec3>>,
    /// kg.
    pub mass: f32,
    /// Principal moments, kg m².
    pub inertia: Vec3,
    /// The unit that moves it, or `STATIC`.
    pub unit: u32,
    /// Where the search starts from.
    pub start: Pose,
    /// Where the layout term wants it.
    pub reference: Pose,
}

/// Bodies that one six-dimensional adjustment moves rigidly.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Unit {
    /// Point about which the adjustment turns: the root body's centre of mass at its start pose.
    pub pivot: Vec3,
    /// The root body.
    pub root: u32,
}

/// Sizes of the fixed slots of one candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capacities {
    /// Hull pairs whose boxes overlap.
    pub hull_pairs: u32,
    /// Contact points after merging.
    pub contacts: u32,
}

/// One group's world, shared by all its candidates.
#[derive(Clone, Debug)]
pub struct World {
    /// Geometry.
    pub hulls: HullTables,
    /// Bodies, in the order of every pose array.
    pub bodies: Vec<Body>,
    /// Pairs of bodies that may touch (at least one of them moves), first < second.
    pub pairs: Vec<[u32; 2]>,
    /// What the search adjusts.
    pub units: Vec<Unit>,
    /// Start pose of every body: adjustment zero.
    pub start: Vec<Pose>,
    /// Pose of every body that the layout term compares with.
    pub reference: Vec<Pose>,
    /// First guess of the slot sizes; a backend grows them and reruns what overflowed.
    pub capacities: Capacities,
}

impl World {
    /// Builds the tables. `roots[u]` is the body about whose centre of mass unit `u` turns.
    ///
    /// # Panics
    /// If a root or unit index is out of range: a bug of the caller, never of the user's data.
    pub fn new(defs: &[BodyDef], roots: &[u32]) -> Self {
        let mut hulls = HullTables::default();
        let bodies: Vec<Body> = defs
            .iter()
            .map(|def| {
                assert!(
                    def.unit == STATIC || (def.unit as usize) < roots.len(),
                    "unit {} of {}",
                    def.unit,
                    roots.len()
                );
                let first_hull = hulls.hulls.len() as u32;
                for part in &def.parts {
                    hulls.push(part);
                }
                let moves = def.unit != STATIC;
                let inertia = def.inertia.max(Vec3::splat(def.inertia.max_element() * MIN_INERTIA_RATIO));
                Body {
                    first_hull,
                    hull_count: hulls.hulls.len() as u32 - first_hull,
                    unit: def.unit,
                    inverse_mass: if moves { 1.0 / def.mass } else { 0.0 },
                    inverse_inertia: if moves { inertia.recip() } else { Vec3::ZERO },
                    radius: def.parts.iter().flatten().map(|v| v.length()).fold(0.0, f32::max),
                }
            })
            .collect();
        let mut pairs = Vec::new();
        for a in 0..bodies.len() as u32 {
            for b in a + 1..bodies.len() as u32 {
                if !(bodies[a as usize].is_static() && bodies[b as usize].is_static()) {
                    pairs.push([a, b]);
                }
            }
        }
        let units = roots.iter().map(|&root| Unit { pivot: defs[root as usize].start.translation, root }).collect();
        let capacities = Capacities {
            hull_pairs: (hulls.hulls.len() as u32 * 8).max(64),
            contacts: (bodies.len() as u32 * 32).max(128),
        };
        Self {
            hulls,
            bodies,
            pairs,
            units,
            start: defs.iter().map(|d| d.start).collect(),
            reference: defs.iter().map(|d| d.reference).collect(),
            capacities,
        }
    }

    /// The same world in which some of the bodies that move do not, to be simulated, not searched: the units stay, also
    /// those that nothing belongs to any more, and so do the poses.
    pub fn holding(&self, held: impl Fn(usize) -> bool) -> Self {
        let mut world = self.clone();
        for (_, body) in world.bodies.iter_mut().enumerate().filter(|(index, _)| held(*index)) {
            *body = Body { unit: STATIC, inverse_mass: 0.0, inverse_inertia: Vec3::ZERO, ..*body };
        }
        let bodies = &world.bodies;
        world.pairs.retain(|pair| pair.iter().any(|&body| !bodies[body as usize].is_static()));
        world
    }

    /// Search dimensions: six per unit.
    pub fn dimensions(&self) -> usize {
        6 * self.units.len()
    }

    /// About how many bytes the fixed slots of one candidate take on a device: state, boxes, pairs, contacts.
    pub fn slot_bytes(&self) -> u64 {
        const BODY: u64 = 160;
        const HULL: u64 = 32;
        const PAIR: u64 = 16;
        const HULL_PAIR: u64 = 48;
        const CONTACT: u64 = 256;
        BODY * self.bodies.len() as u64
            + HULL * self.hulls.hulls.len() as u64
            + PAIR * self.pairs.len() as u64
            + HULL_PAIR * u64::from(self.capacities.hull_pairs)
            + CONTACT * u64::from(self.capacities.contacts)
    }

    /// The hulls of a body, as indices into `hulls.hulls`.
    pub fn hulls_of(&self, body: usize) -> std::ops::Range<usize> {
        let b = &self.bodies[body];
        b.first_hull as usize..(b.first_hull + b.hull_count) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::box_corners;

    #[test]
    fn what_is_held_is_simulated_as_if_it_had_never_moved() {
        let def = |unit: u32| BodyDef {
            parts: vec![box_corners(Vec3::splat(0.5)); 1 + unit.min(3) as usize],
            mass: 2.0,
            inertia: Vec3::new(0.1, 0.2, 0.3),
            unit,
            start: Pose::IDENTITY,
            reference: Pose::IDENTITY,
        };
        let moving = [def(0), def(1), def(2), def(STATIC)];
        let held = moving.clone().map(|def| BodyDef { unit: if def.unit == 1 { 1 } else { STATIC }, ..def });
        let (world, wanted) = (World::new(&moving, &[0, 1, 2]).holding(|body| body != 1), World::new(&held, &[0, 1]));
        assert_eq!((world.bodies, world.pairs), (wanted.bodies, wanted.pairs));
        assert!(!world.hulls.hulls.is_empty() && world.hulls.hulls == wanted.hulls.hulls);
        assert_eq!(world.capacities, wanted.capacities);
    }
}
