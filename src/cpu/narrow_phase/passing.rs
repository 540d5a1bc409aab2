//! Hulls that pass each other: contacts are made a substep ahead, and one between things that only fall past each other
//! would stop them in the air; or what slides over the seam of two parts, at the end of the next.
//!
//! The idea of a conservative advance: where a plane on which one hull lies keeps all of the other on its outer side
//! for as long as contacts act, they do not meet, whatever their nearest corners are about to do. The planes that are
//! asked are all those through an edge of either hull, from the one of its faces to the other. Along a straight way
//! there are no others: what a hull sweeps is a hull, and two hulls apart are parted by a face of one of them or by a
//! plane along an edge of each. What spins goes along arcs, which are taken for parabolas. Only a contact that would
//! act is asked, so that a thing at rest never loses what bears it.

use super::{HullPair, Manifold, ManifoldPoint};
use crate::world::constants::{GLIDING_COSINE, GLIDING_DEPTH, MAX_HULL_FACES};
use crate::world::{Pose, Velocity, compose, from_scaled_axis};
use glam::{Mat3, Vec3, Vec4};

/// True if a contact of the pair would act within `dt` (s), and yet the hulls only pass each other, or one glides over
/// the other. `falls`: what gravity adds to the upward velocities of the two bodies if nothing touches them, m/s.
pub fn passes(pair: &HullPair, velocities: &[Velocity; 2], falls: [f32; 2], dt: f32, manifold: &Manifold) -> bool {
    let mut falling = *velocities;
    falling.iter_mut().zip(falls).for_each(|(velocity, fall)| velocity.linear.y += fall);
    flies_past(pair, &falling, dt, manifold) || glides_over(pair, velocities, dt, manifold)
}

/// The first contact farther apart than `least` (m) that acts at these velocities.
fn acting<'m>(
    pair: &HullPair,
    velocities: &[Velocity; 2],
    dt: f32,
    manifold: &'m Manifold,
    least: f32,
) -> Option<&'m ManifoldPoint> {
    let acts = |point: &&ManifoldPoint| {
        let moved = |side: usize, at: Vec3| {
            let Velocity { linear, angular, .. } = velocities[side];
            dt * (linear + angular.cross(at - pair.poses[side].translation))
        };
        let closer = manifold.normal.dot(moved(0, point.on_a) - moved(1, point.on_b));
        point.separation > least && closer > point.separation
    };
    manifold.points().iter().find(acts)
}

/// True if the hulls only pass each other, at the velocities that they have if nothing touches them.
fn flies_past(pair: &HullPair, falling: &[Velocity; 2], dt: f32, manifold: &Manifold) -> bool {
    acting(pair, falling, dt, manifold, 0.0).is_some_and(|point| {
        let after = |time: f32| [0, 1].map(|side: usize| end(pair.poses[side], &falling[side], time));
        let (halfway, later) = (after(0.5 * dt), after(dt));
        (0..2).any(|side| {
            let to_side = |poses: &[Pose; 2]| HullPair { poses: [&poses[0], &poses[1]], ..*pair }.other_to(side);
            let nearest = pair.poses[1 - side].inverse_point([point.on_b, point.on_a][side]);
            Way([pair.other_to(side), to_side(&halfway), to_side(&later)]).stays_beside(pair, side, nearest)
        })
    })
}

/// True if a face that looks another way than the contact has all of the other hull above it, now and later, or hardly
/// below: what slides over the parts of a slope touches the end of the next part, too, whose top it is about to slide
/// on. Without gravity: what rests falls nowhere.
fn glides_over(pair: &HullPair, velocities: &[Velocity; 2], dt: f32, manifold: &Manifold) -> bool {
    acting(pair, velocities, dt, manifold, -GLIDING_DEPTH).is_some_and(|point| {
        (0..2).any(|side| {
            let nearest = pair.poses[side].inverse_point([point.on_b, point.on_a][side]);
            let outward = pair.poses[side].rotation.conjugate() * ([1.0, -1.0][side] * manifold.normal);
            let height = |plane: Vec4, p: Vec3| plane.truncate().dot(p) - plane.w;
            let others = pair.tables.vertices_of(pair.hull(1 - side));
            let over = |plane: Vec4, pair: &HullPair| {
                let (turn, shift) = pair.other_to(side);
                others.iter().all(|v| height(plane, turn * v.truncate() + shift) > -GLIDING_DEPTH)
            };
            let over_later = |plane: Vec4| {
                let [a, b] = [0, 1].map(|side: usize| end(pair.poses[side], &velocities[side], dt));
                over(plane, &HullPair { poses: [&a, &b], ..*pair })
            };
            pair.tables.faces_of(pair.hull(side)).iter().map(|face| face.plane).any(|plane| {
                plane.truncate().dot(outward) < GLIDING_COSINE
                    && height(plane, nearest) > -GLIDING_DEPTH
                    && over(plane, pair)
                    && over_later(plane)
            })
        })
    })
}

/// Where a body will be after `dt` seconds.
fn end(pose: &Pose, velocity: &Velocity, dt: f32) -> Pose {
    let turn = from_scaled_axis(dt * velocity.angular);
    Pose::new(compose(turn, pose.rotation), pose.translation + dt * velocity.linear)
}

/// From the other body's frame to that of a side: now, half-way and at the end.
struct Way([(Mat3, Vec3); 3]);

impl Way {
    /// True if a plane through an edge of the hull of `side`, on which that hull lies, has all of the other hull on its
    /// outer side all the way. `nearest`, a point of the other hull that is about to touch (its body's frame), is asked
    /// first: it rules out most edges.
    fn stays_beside(&self, pair: &HullPair, side: usize, nearest: Vec3) -> bool {
        let hull = pair.hull(side);
        let (faces, others) = (pair.tables.faces_of(hull), pair.tables.vertices_of(pair.hull(1 - side)));
        let nearest = self.places(nearest);
        let mut nearest_over = [[0.0; 2]; MAX_HULL_FACES];
        nearest_over.iter_mut().zip(faces).for_each(|(over, face)| *over = heights(face.plane, nearest));
        pair.tables.edges_of(hull).iter().any(|edge| {
            let planes = edge.faces.map(|face| faces[face as usize].plane);
            let mut shares = Shares { low: 0.0, high: 1.0 };
            shares.keep_outside(edge.faces.map(|face| nearest_over[face as usize]))
                && others.iter().all(|vertex| {
                    let places = self.places(vertex.truncate());
                    shares.keep_outside(planes.map(|plane| heights(plane, places)))
                })
        })
    }

    /// Where a point of the other body is on its way, in the frame of the side.
    fn places(&self, point: Vec3) -> [Vec3; 3] {
        self.0.map(|(turn, shift)| turn * point + shift)
    }
}

/// The planes through an edge by the share of the left face's plane, the rest being the right one's: what lies between
/// the two has all that was seen so far on its outer side.
struct Shares {
    low: f32,
    high: f32,
}

impl Shares {
    /// Leaves those that have a point on their outer side, too, that is so high over the left and the right plane at
    /// both ends of its way. True if any are left.
    #[inline(always)]
    fn keep_outside(&mut self, [left, right]: [[f32; 2]; 2]) -> bool {
        // What is below both is below every plane between them; most edges end here.
        let outside = left[0].max(right[0]) > 0.0 && left[1].max(right[1]) > 0.0;
        if !outside {
            return false;
        }
        for (left, right) in left.into_iter().zip(right) {
            let level = right / (right - left);
            self.low = if left > right { self.low.max(level) } else { self.low };
            self.high = if left < right { self.high.min(level) } else { self.high };
        }
        self.low < self.high
    }
}

/// Heights over a plane at both ends of a way, lowered by as much as the way sags below the line between them.
#[inline(always)]
fn heights(plane: Vec4, places: [Vec3; 3]) -> [f32; 2] {
    let [now, halfway, later] = places.map(|place| plane.truncate().dot(place) - plane.w);
    let sag = (halfway - 0.5 * (now + later)).min(0.0);
    [now + sag, later + sag]
}
