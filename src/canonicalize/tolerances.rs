//! Every number that canonicalization decides by, with its unit and what it is for.

use glam::DVec2;
use std::f64::consts::PI;

const DEGREE: f64 = PI / 180.0;

/// A reconstruction is tilted by less than this (35° occur); what would need more is no vertical, rad.
pub(super) const MAX_TILT: f64 = 45.0 * DEGREE;

/// A tilt below this is within the error of its estimate: the scene is not turned, its objects are, rad.
pub(super) const MIN_TILT: f64 = 1.0 * DEGREE;

/// An object that leans by more than this has no good reason to be set upright, rad.
pub(super) const MAX_LEAN: f64 = 25.0 * DEGREE;

/// An object that leans by less than this stands upright, rad. Far above rounding, far below what can be seen.
pub(super) const LEVEL: f64 = 0.02 * DEGREE;

/// How far the up axes of single objects usually are from the scene's, rad.
pub(super) const SPREAD: f64 = 3.0 * DEGREE;

/// Two up axes farther apart than this hardly support each other, rad: the scale of the Cauchy weights.
pub(super) const AGREEMENT: f64 = 4.0 * DEGREE;

/// Iterations of the reweighted mean; it has converged after ten.
pub(super) const ITERATIONS: usize = 30;

/// How uneven a reconstructed base is, m: over its length it makes the error of the base's direction.
pub(super) const UNEVENNESS: f64 = 0.01;

/// What an object's up axis counts for if the object does not stand on the ground; 1 if it does.
pub(super) const BORNE_WEIGHT: f64 = 0.5;

/// What the mesh's own axis counts for, in place of a base of known direction.
pub(super) const AXIS_WEIGHT: f64 = 0.8;

/// A mesh's own +Y is upside down if it is nearer than this to straight down, rad.
pub(super) const UPSIDE_DOWN: f64 = 30.0 * DEGREE;

/// An upside-down object is turned over if what it would stand on is so much larger than what it stands on now.
pub(super) const TURN_OVER: f64 = 4.0;

/// Vertices nearer to the plane of a base than this share of the object's diagonal belong to the base.
pub(super) const BASE_BAND: f64 = 0.01;

/// The same for what a base would widen to if it were the pole of something round.
pub(super) const ROUND_BAND: f64 = 0.05;

/// A base is flat if its area is at least this share of the area that it widens to: round fruit has up to 0.43, plates
/// 0.49.
pub(super) const FLAT: f64 = 0.46;

/// The centre of mass lies at least this far within the edge of a base, m.
pub(super) const MIN_MARGIN: f64 = 2e-3;

/// Bases whose directions differ by less than this are one, rad.
pub(super) const SAME_BASE: f64 = 2.0 * DEGREE;

/// The largest so many faces of the hull are looked at as bases; those of something round are none.
pub(super) const MAX_BASES: usize = 256;

/// Columns along the longer side of a footprint.
pub(super) const COLUMNS: usize = 40;

/// Where the first column is in its cell, along x and z as shares of its sides: not in the middle, because meshes have
/// many edges on round fractions of their size.
pub(super) const FIRST_COLUMN: DVec2 = DVec2::new(0.473, 0.519);

/// The underside of an object within this height above its lowest point is its footprint, m …
pub(super) const FOOT_BAND: f64 = 0.01;

/// … or this share of the object's height, if that is more.
pub(super) const FOOT_SHARE: f64 = 0.03;

/// Share of a footprint that may reach into the bearer: a box pushed a little into the wall of its shelf still stands
/// on the board.
pub(super) const TOLERATED: f64 = 0.15;

/// Of those columns, the ones that reach in by less than this are cleared, m.
pub(super) const CLEARED: f64 = 0.01;

/// Farther than this, a shift onto a support is worth a look, m.
pub(super) const FAR: f64 = 0.2;

/// Surfaces without a back are taken for this thick, m.
pub(super) const SHEET: f64 = 1e-3;

/// A tilt above this is worth a warning where a scene is used as it is, degrees.
pub(super) const VISIBLE_TILT: f64 = 2.0;

/// A ground farther off than this is worth one, m.
pub(super) const VISIBLE_SHIFT: f64 = 0.1;

/// A summary names an object whose height changed by more than this, m.
pub(super) const NOTEWORTHY: f64 = 0.1;
