//! Broad phase: which hull pairs may touch, in a fixed order.
//!
//! Body boxes first, then hull boxes of the pairs that remain. Boxes are the rotated local boxes, so no vertex is
//! read. Margins grow with speed, so that a fast body meets its contacts one step ahead.
//!
//! Bodies that hardly moved keep the contacts between them (Box3D calls it recycling), so their hulls are not listed.

use crate::world::constants::{COHERENT_DEPTH, MAX_SPECULATIVE_MARGIN, NO_EXTENT, RECYCLING_DISTANCE, ROOM_SHARE};
use crate::world::{Pose, Velocity, World};
use glam::{Mat3, Quat, Vec3};

/// A hull pair whose boxes overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HullPair {
    /// Index into `World::pairs`.
    pub pair: u32,
    /// Hull of the pair's first body.
    pub a: u32,
    /// Hull of the pair's second body.
    pub b: u32,
}

/// Axis-aligned box, m.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// World.
    pub center: Vec3,
    /// Half extents.
    pub half: Vec3,
}

impl Bounds {
    const EMPTY: Self = Self { center: Vec3::ZERO, half: Vec3::splat(NO_EXTENT) };

    fn overlaps(&self, other: &Self, margin: f32) -> bool {
        ((self.center - other.center).abs()).cmple(self.half + other.half + margin).all()
    }

    fn around(low: Vec3, high: Vec3) -> Self {
        Self { center: 0.5 * (low + high), half: 0.5 * (high - low) }
    }
}

/// Where a body was when its contacts were last found, and its margin then.
#[derive(Clone, Copy, Debug)]
pub struct Mark {
    /// No rotation at all if they never were.
    pub pose: Pose,
    /// m
    pub margin: f32,
}

impl Mark {
    const NONE: Self = Self { pose: Pose::new(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0), Vec3::ZERO), margin: 0.0 };

    /// True if a body of this radius (m) is where it was, and looks no farther.
    fn holds(&self, pose: &Pose, margin: f32, radius: f32) -> bool {
        let (now, then) = (pose.rotation, self.pose.rotation);
        // Half the angle for small ones; large without a rotation.
        let turned = now.xyz().distance(then.xyz()) + (now.w - then.w).abs();
        let moved = pose.translation.distance(self.pose.translation) + 2.0 * radius * turned;
        moved <= RECYCLING_DISTANCE && margin <= self.margin + RECYCLING_DISTANCE
    }
}

/// Scratch of the broad phase of one candidate.
#[derive(Debug, Default)]
pub struct BroadPhase {
    /// A box a hull.
    pub hulls: Vec<Bounds>,
    /// A box a body.
    pub bodies: Vec<Bounds>,
    /// Half the distance to an equal body at which contacts are made, m.
    pub margins: Vec<f32>,
    /// A mark a body.
    pub marks: Vec<Mark>,
    /// For every body, true if its mark held, false if it was made anew.
    pub still: Vec<bool>,
    /// Where every body was when its boxes were made; not a number before that.
    boxed: Vec<Pose>,
}

impl BroadPhase {
    /// Forgets where boxes were made and contacts were found.
    pub fn forget(&mut self) {
        self.boxed.clear();
        self.marks.clear();
    }

    /// Moves all boxes to the bodies' poses. `offset` is the contact offset (m), `dt` the time to the next call (s).
    pub fn update(&mut self, world: &World, poses: &[Pose], velocities: &[Velocity], offset: f32, dt: f32) {
        self.margins.clear();
        self.still.clear();
        self.hulls.resize(world.hulls.hulls.len(), Bounds::EMPTY);
        self.bodies.resize(world.bodies.len(), Bounds::EMPTY);
        self.boxed.resize(world.bodies.len(), Pose::new(Quat::from_xyzw(0.0, 0.0, 0.0, f32::NAN), Vec3::NAN));
        self.marks.resize(world.bodies.len(), Mark::NONE);
        let bodies = world.bodies.iter().zip(poses).zip(velocities).zip(&mut self.marks).enumerate();
        for (index, (((body, pose), velocity), mark)) in bodies {
            // What is where it was keeps its boxes.
            if self.boxed[index] != *pose {
                self.boxed[index] = *pose;
                let turn = Mat3::from_quat(pose.rotation);
                let spread = Mat3::from_cols(turn.x_axis.abs(), turn.y_axis.abs(), turn.z_axis.abs());
                let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
                let own = body.first_hull as usize..(body.first_hull + body.hull_count) as usize;
                for (hull, bounds) in world.hulls.hulls[own.clone()].iter().zip(&mut self.hulls[own]) {
                    let center = turn * hull.center + pose.translation;
                    let half = spread * hull.half_extents;
                    low = low.min(center - half);
                    high = high.max(center + half);
                    *bounds = Bounds { center, half };
                }
                self.bodies[index] = if body.hull_count == 0 { Bounds::EMPTY } else { Bounds::around(low, high) };
            }
            let reach = dt * (velocity.linear.length() + velocity.angular.length() * body.radius);
            let margin = 0.5 * offset + reach.min(0.5 * MAX_SPECULATIVE_MARGIN);
            self.margins.push(margin);
            let is_still = mark.holds(pose, margin, body.radius);
            self.still.push(is_still);
            if !is_still {
                *mark = Mark { pose: *pose, margin };
            }
        }
    }

    /// True if this body pair keeps its contacts.
    pub fn keeps(&self, pair: [u32; 2]) -> bool {
        pair.iter().all(|&body| self.still[body as usize])
    }

    /// Distance within which contacts of this body pair are made, m.
    pub fn margin(&self, pair: [u32; 2]) -> f32 {
        self.margins[pair[0] as usize] + self.margins[pair[1] as usize]
    }

    /// Distance within which contacts of a body with an unmoving plane are made, m.
    pub fn ground_margin(&self, body: usize, offset: f32) -> f32 {
        self.margins[body] + 0.5 * offset
    }

    /// Lowest y of a body's box, m.
    pub fn lowest(&self, body: usize) -> f32 {
        self.bodies[body].center.y - self.bodies[body].half.y
    }

    /// How far the bodies of a hull pair can be pushed down, m: not so far that they would stand in the ground with
    /// `ROOM_SHARE` of their height. Only what a fixed hull could swallow is kept out of it; all else may be pushed
    /// anywhere.
    pub fn room(&self, world: &World, HullPair { pair, a, b }: HullPair) -> [f32; 2] {
        let bodies = world.pairs[pair as usize];
        let below = |side: usize, other: u32| {
            let (body, hull) = (&self.bodies[bodies[side] as usize], &self.hulls[other as usize]);
            let narrower = body.half.x <= hull.half.x || body.half.z <= hull.half.z;
            match narrower && world.bodies[bodies[1 - side] as usize].is_static() {
                true => (body.center.y - body.half.y).max(0.0) + ROOM_SHARE * 2.0 * body.half.y + COHERENT_DEPTH,
                false => f32::MAX,
            }
        };
        [below(0, b), below(1, a)]
    }

    /// Lists overlapping hull pairs in the order of `World::pairs`. Those count that are within `margin` of each other,
    /// m. Counts on past `capacity` without storing, so that the caller can grow and call again.
    pub fn pairs(
        &self,
        world: &World,
        margin: impl Fn([u32; 2]) -> f32,
        capacity: u32,
        out: &mut Vec<HullPair>,
    ) -> u32 {
        out.clear();
        let mut count = 0;
        for (index, &pair) in world.pairs.iter().enumerate() {
            let [a, b] = pair.map(|i| i as usize);
            let margin = margin(pair);
            if self.keeps(pair) || !self.bodies[a].overlaps(&self.bodies[b], margin) {
                continue;
            }
            for hull_a in world.hulls_of(a) {
                if !self.hulls[hull_a].overlaps(&self.bodies[b], margin) {
                    continue;
                }
                for hull_b in world.hulls_of(b) {
                    if self.hulls[hull_a].overlaps(&self.hulls[hull_b], margin) {
                        if count < capacity {
                            out.push(HullPair { pair: index as u32, a: hull_a as u32, b: hull_b as u32 });
                        }
                        count += 1;
                    }
                }
            }
        }
        count
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::BodyDef;

    #[test]
    fn boxes_are_where_the_bodies_are() {
        let corner = |i: usize| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
        let shifted = |by: f32| (0..8).map(|i| corner(i) + by).collect::<Vec<Vec3>>();
        let start = Pose::new(Quat::IDENTITY, Vec3::Y);
        let parts = vec![shifted(0.0), shifted(2.0)];
        let def = BodyDef { parts, mass: 1.0, inertia: Vec3::ONE, unit: 0, start, reference: start };
        let world = World::new(&[def.clone(), def.clone(), def.clone()], &[0]);
        let boxes = |phase: &mut BroadPhase, poses: &[Pose]| {
            phase.update(&world, poses, &[Velocity::default(); 3], 0.01, 0.01);
            phase.hulls.iter().chain(&phase.bodies).map(|bounds| [bounds.center, bounds.half]).collect::<Vec<_>>()
        };
        let turned = Pose::new(Quat::from_rotation_z(0.3), Vec3::new(3.0, 1.0, 0.0));
        let mut used = BroadPhase::default();
        let mut before = Vec::new();
        for poses in [[start; 3], [start, turned, start], [turned, turned, start]] {
            let now = boxes(&mut used, &poses);
            assert_eq!(now, boxes(&mut BroadPhase::default(), &poses));
            assert_ne!(now, before);
            before = now;
        }
        // Forgetting, it may go on in another world.
        used.forget();
        let wide = World::new(&[0, 1, 2].map(|_| BodyDef { parts: vec![shifted(3.0); 2], ..def.clone() }), &[0]);
        let poses = [turned, turned, start];
        let resting = [Velocity::default(); 3];
        used.update(&wide, &poses, &resting, 0.01, 0.01);
        let mut fresh = BroadPhase::default();
        fresh.update(&wide, &poses, &resting, 0.01, 0.01);
        assert!(used.hulls.iter().zip(&fresh.hulls).all(|(used, fresh)| used.center == fresh.center));
    }
}
