//! What decides in the stages around the search: in metres, radians and seconds. Rooms with many such numbers (`seat`,
//! `opinion`, `projection`, `exact`, `room`) have their own.

use std::f64::consts::FRAC_PI_6;
use std::ops::Range;

/// An object turned by more than this from its input has fallen, rad (30°).
pub const FALLEN: f64 = FRAC_PI_6;

/// What is set down or searched once more is to be turned by less than this, rad (27°): who compares two layouts fits them
/// onto each other first, and that turns them, too.
pub(super) const NEARLY_FALLEN: f64 = 0.9 * FALLEN;

/// An object that leans by less (1°) or by more (20°) than this is not taken for an upright one that leans, rad.
pub(super) const LEAN: Range<f64> = 0.017..0.35;

/// How many horizontal directions are tried where none is better than another.
pub(super) const DIRECTIONS: u32 = 16;

/// An improvement of the elites below this share counts as none (see `CemSettings::patience`). The best candidate is no
/// guide: a lucky first one stands while the distribution still moves.
pub(super) const IMPROVEMENT: f32 = 0.01;

/// How long everything must be slow before it counts as at rest, s.
pub(super) const REST_SECONDS: f32 = 0.5;

/// What is deeper than this in another at rest is jammed, m: parts of meshes that only touch overlap by less, and an engine
/// throws such things apart.
pub(super) const JAMMED: f32 = 2e-3;

/// Largest gap between an object and what bears it, m.
pub(super) const BEARS_WITHIN: f32 = 0.005;

/// Meshes whose parts rest on one another and that are farther apart than this float for the eye, m.
pub(super) const FLOATS: f64 = 0.005;

/// What is moved farther than this was seen elsewhere, m: the user is to look at it.
pub(super) const MOVED_FAR: f64 = 0.2;

/// So many of these are named.
pub(super) const MOST_TOLD: usize = 8;

/// Smallest upward share of the direction in which what bears an object pushes it (about 15° above the horizontal).
pub(super) const BEARS_UPWARD: f32 = 0.25;

/// How far from where it was set onto its support a free place is looked for, m …
pub(super) const FREE_WITHIN: f64 = 0.1;

/// … and how far such places are from each other along a direction, m.
pub(super) const FREE_STEP: f64 = 0.01;

/// What stands farther than this from where it was set onto its support was thrown there, m.
pub(super) const FAR: f64 = 0.25;

/// What is farther is out of reach, m.
pub(super) const MOST_FAR: f64 = 10.0;

/// It is brought back if there is a place with at most this share of the way.
pub(super) const NEARER: f64 = 0.8;

/// A body whose drift is longer by this moves farther, m.
pub(super) const FARTHER: f64 = 1e-3;

/// So does one whose turn is wider by this, rad.
pub(super) const TURNED: f64 = 5e-3;

/// So often are other parts looked at before those of the search are written.
pub(super) const FOOTINGS: usize = 6;

/// Parts bear if they are nearer to each other, or to the ground, than this, m.
pub(super) const FOOT_WITHIN: f32 = 1e-3;

/// What bears does so in a direction with at least this vertical share (45°).
pub(super) const FOOT_UPWARD: f64 = 0.7;

/// Directions nearer to each other than this are one (cosine, 1°).
pub(super) const SAME: f32 = 0.9998;

/// Density of what has no mass stated, kg/m³: that of MuJoCo and PhysX.
pub(super) const EVEN_DENSITY: f32 = 1000.0;
