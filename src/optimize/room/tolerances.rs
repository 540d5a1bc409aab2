//! Every number that placement on walls and ceilings decides by, with its unit and what it is for.

use std::f64::consts::PI;

const DEGREE: f64 = PI / 180.0;

/// Clearance at which something is put against a wall or ceiling, m: what the exact step gives to neighbours.
pub(in crate::optimize) const CONTACT: f64 = 0.5e-3;

/// What is farther than this from its wall or ceiling does not touch it, m.
pub(in crate::optimize) const TOUCHES: f64 = 0.01;

/// What is nearer than this to its place is there, m: above the rounding of a file's decimals, far below what matters.
pub(super) const THERE: f64 = 2e-6;

/// Clearance from everything else, m.
pub(super) const CLEARANCE: f32 = 0.5e-3;

/// A yaw is corrected if a side of the object is within this of its wall, rad (REST3D).
pub(super) const MAX_YAW: f64 = 25.0 * DEGREE;

/// What hangs and leans by less than this was meant to be plumb, rad; what stands has about the same limit, `LEAN`.
pub(super) const MAX_LEAN: f64 = 20.0 * DEGREE;

/// What hangs and leans by less than this is plumb, rad. Far above rounding, far below what can be seen.
pub(super) const PLUMB: f64 = 0.01 * DEGREE;

/// Sides of an outline whose directions differ by less than this are one: reconstructed backs are uneven, rad.
pub(super) const SAME_SIDE: f64 = 3.0 * DEGREE;

/// A side that is shorter than this share of the object's width is no back: one of a circle, uneven ones joined, has
/// 0.05.
pub(super) const FLAT: f64 = 0.12;

/// An axis of a mesh is horizontal if its vertical share is less than this (sine of 11°).
pub(super) const HORIZONTAL: f64 = 0.2;

/// How far along a wall or ceiling it is looked for, m, nearby first.
pub(super) const SLIDES: [f32; 2] = [0.3, 1.5];

/// How far off its wall or ceiling something is put that has no free place there, m.
pub(super) const MAX_OFF: f32 = 0.5;

/// A shift to a wall or ceiling that is longer than this is worth a note, m.
pub(super) const FAR: f64 = 0.5;

/// Something that stands on the ground and against a wall is put there from at most so far, m.
pub(super) const MAX_PULL: f64 = 0.5;

/// What reaches through a wall by more than this is not moved inside: then the wall is not where the scene says, m.
pub(super) const MAX_INSIDE: f64 = 0.3;

/// Of two walls about as far from something that stands it belongs to the one across which it is less deep: so much of
/// its depth counts as distance.
pub(super) const DEPTH_SHARE: f64 = 0.1;

/// Thickness of a wall that bears, m.
pub(super) const THICKNESS: f64 = 0.5;

/// A wall that bears goes so far beyond the scene, m.
pub(super) const BEYOND: f64 = 0.5;

/// A plane with a steeper normal than this (sine) is no wall.
pub(super) const STEEPEST: f64 = 0.7;

/// A ceiling is never fitted lower than this, m (REST3D).
pub(super) const LOWEST_CEILING: f64 = 1.8;

/// What hangs and is so many times as wide as it is deep hangs flat on a wall.
pub(super) const FLAT_ON: f64 = 2.0;

/// An outline that fills more than `BOXY[0]` of its rectangle says something of the room's yaw, and from `BOXY[1]` on
/// all that its size allows. A circle fills 0.79.
pub(super) const BOXY: [f64; 2] = [0.8, 0.95];

/// What the outline of something at a wall counts for, compared with other furniture of its length.
pub(super) const AT_WALL: f64 = 2.0;

/// Outlines whose directions differ by more than this have nothing to do with each other, rad.
pub(super) const AGREEMENT: f64 = 10.0 * DEGREE;

/// What stands on the ground at a wall and leans by more than this is meant to lean on it, rad. Reconstructions tilt
/// upright objects by up to 5°.
pub(in crate::optimize) const LEANING: f64 = 8.0 * DEGREE;

/// What leans on a wall does so by at least this, rad: nearer to upright it falls back off it.
pub(super) const LEAST_LEAN: f64 = 5.0 * DEGREE;

/// What leans by more than this has fallen over and leans on nothing, rad.
pub(super) const MAX_LEAN_ON: f64 = 44.0 * DEGREE;

/// Something leans towards a wall if the directions of its lean and of the wall are nearer than this (cosine of 45°) …
pub(super) const TOWARDS: f64 = 0.7;

/// … and belongs to another wall only if it would be so much nearer, m.
pub(super) const ASTRAY: f64 = 10.0;

/// Ground or ceiling whose normal is nearer to that of an object's own surface than this (cosine) is that surface.
pub(super) const ITS_OWN: f64 = 0.99;

/// A shift runs along a surface if its share of the normal is smaller than this.
pub(super) const LEVEL: f64 = 1e-6;
