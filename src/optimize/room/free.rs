//! The nearest free place of something on its wall or ceiling, on convex parts: those cover the meshes, are solid, and
//! are what the simulation will push apart.

use super::tolerances::{CLEARANCE, CONTACT, ITS_OWN, LEVEL, MAX_INSIDE, MAX_OFF, SLIDES, TOUCHES};
use super::{Form, Room};
use crate::optimize::directions::directions;
use crate::optimize::rig::Rig;
use crate::optimize::sweep::{first_gap, overlap_interval};
use crate::scene::Pose;
use glam::{DVec3, Vec3};
use parry3d::bounding_volume::{Aabb, BoundingVolume};
use parry3d::math::Pose as Isometry;
use parry3d::shape::Shape;

/// Where objects are, for looking from one at the others.
pub(super) struct Space<'a> {
    room: &'a Room,
    forms: &'a [Form],
    rigs: &'a [Rig],
}

/// Where something that is put on a side has room.
pub(super) enum Place {
    /// Here, after a shift from the surface or along it, m.
    Touching(DVec3),
    /// Only off the surface, after this shift, m.
    Off(DVec3),
    /// Nowhere near.
    None,
}

impl<'a> Space<'a> {
    pub fn new(room: &'a Room, forms: &'a [Form], rigs: &'a [Rig]) -> Self {
        Self { room, forms, rigs }
    }

    /// Looks for room for `moving` (the first is what hangs on the side, the others ride along) among the `others`:
    /// away from the surface as long as that counts as touching, then along it by the least distance, then farther
    /// away.
    pub fn place(&self, side: usize, moving: &[usize], others: &[usize], layout: &[Pose]) -> Place {
        let normal = self.room.sides[side].normal;
        let away = self.first_free(side, moving, others, layout, normal, MAX_OFF);
        if let Some(distance) = away.filter(|distance| distance + CONTACT <= TOUCHES) {
            return Place::Touching(normal * distance);
        }
        let [sideways, up] = self.room.sides[side].along();
        let directions = directions().map(|along| sideways * along.x + up * along.z);
        for reach in SLIDES {
            let slides = directions.clone().filter_map(|direction| {
                let distance = self.first_free(side, moving, others, layout, direction, reach)?;
                Some((distance, direction * distance))
            });
            // Of equals the first.
            if let Some((_, shift)) = slides.reduce(|best, next| if next.0 < best.0 { next } else { best }) {
                return Place::Touching(shift);
            }
        }
        away.map_or(Place::None, |distance| Place::Off(normal * distance))
    }

    /// The least shift along a direction that leads to a free place, m; none within reach.
    fn first_free(
        &self,
        side: usize,
        moving: &[usize],
        others: &[usize],
        layout: &[Pose],
        direction: DVec3,
        reach: f32,
    ) -> Option<f64> {
        let mut blocked = self.bounds(side, moving[0], layout, direction);
        for &part in moving {
            for &other in others {
                self.blocked(part, other, layout, direction.as_vec3(), reach, &mut blocked);
            }
        }
        let free = first_gap(blocked);
        (free <= f64::from(reach)).then_some(free)
    }

    /// The shifts at which one object would be too near to another, m.
    fn blocked(
        &self,
        object: usize,
        other: usize,
        layout: &[Pose],
        direction: Vec3,
        reach: f32,
        found: &mut Vec<[f64; 2]>,
    ) {
        let place = |i: usize| {
            let body = self.rigs[i].body(&layout[i]);
            Isometry::from_parts(body.translation, body.rotation)
        };
        let (at, there) = (place(object), place(other));
        let boxes: Vec<Aabb> = self.rigs[other].solids().iter().map(|part| part.compute_aabb(&there)).collect();
        for part in self.rigs[object].solids() {
            let start = part.compute_aabb(&at).loosened(2.0 * CLEARANCE);
            let end = Aabb::new(start.mins + direction * reach, start.maxs + direction * reach);
            let swept = start.merged(&end);
            for (obstacle, bounds) in self.rigs[other].solids().iter().zip(&boxes) {
                if swept.intersects(bounds)
                    && let Some([low, high]) = overlap_interval((&at, part), (&there, obstacle), direction, CLEARANCE)
                    && high > 0.0
                    && low < reach
                {
                    found.push([low.into(), high.into()]);
                }
            }
        }
    }

    /// The shifts at which an object would reach through the ground, the ceiling or a wall other than its own, m. What
    /// it does not fit between anyway, or what it is far beyond, does not bound it.
    fn bounds(&self, side: usize, object: usize, layout: &[Pose], direction: DVec3) -> Vec<[f64; 2]> {
        let corners = || self.forms[object].mesh(&layout[object]);
        let ground = corners().map(|p| p.y).fold(f64::INFINITY, f64::min);
        let top = corners().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max);
        let ceiling = self.room.ceiling().unwrap_or(f64::INFINITY);
        let fits = top - ground <= ceiling - 2.0 * CONTACT;
        let walls = self.room.walls().filter(|&(wall, _)| wall != side);
        let walls = walls.map(|(_, wall)| (wall.gap(corners()), wall.normal)).filter(|(gap, _)| *gap > -MAX_INSIDE);
        let level = [(ground, DVec3::Y), (ceiling - top, DVec3::NEG_Y)];
        let level = level.into_iter().filter(|(gap, normal)| {
            // The gap to its own surface is none of these.
            fits && gap.is_finite() && self.room.sides[side].normal.dot(*normal).abs() < ITS_OWN
        });
        let bound = |(gap, normal): (f64, DVec3)| {
            let (along, spare) = (direction.dot(normal), gap - CONTACT);
            match along {
                _ if along > LEVEL => [f64::NEG_INFINITY, -spare / along],
                _ if along < -LEVEL => [-spare / along, f64::INFINITY],
                _ if spare < -CONTACT => [f64::NEG_INFINITY, f64::INFINITY],
                _ => [f64::NEG_INFINITY; 2],
            }
        };
        walls.chain(level).map(bound).collect()
    }
}
