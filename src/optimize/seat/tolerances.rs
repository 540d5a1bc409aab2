//! What decides how objects are set onto their supports: in metres, radians and seconds.

/// An object is not shifted farther than this onto another, m: what is farther off is not a wrong height but a wrong
/// parent. But what its parent has swallowed has nowhere else to go.
pub(super) const MAX_SHIFT: f32 = 0.2;

/// The footprint that looks for support is so much narrower than the object: a book that leans into a wall of the shelf
/// still stands on the board.
pub(super) const FOOTPRINT: f32 = 0.8;

/// An object inside another that has to be raised by more than this is looked for a place beside, m …
pub(super) const SUNK: f32 = 0.01;

/// … and so is one on another, from this on: reconstructions sink what stands on a table by centimetres, and a tray's rim
/// is higher.
pub(super) const SUNK_ON: f32 = 0.03;

/// So much longer a way counts up or down than sideways: reconstructions err less in heights.
pub(super) const STEEP: f64 = 2.0;

/// Longest time that an object alone is given to come to rest, s.
pub(super) const REST_SECONDS: f32 = 2.0;

/// An object that turns farther than this when left alone (about 11°) falls rather than rests, rad: it keeps its pose.
pub(super) const MAX_TURN: f32 = 0.2;

/// An object that slides farther than this when left alone keeps its pose, m.
pub(super) const MAX_SLIDE: f32 = 0.05;

/// What comes down by more than this where it shall stand does not stand there, m: a bottle that hangs over an edge by its
/// waist.
pub(super) const MAX_SINK: f32 = 0.02;

/// Distances at which a better place is looked for, one after the other, m. What is farther off its support than the
/// last is not at an edge: it has a wrong parent.
pub(super) const DISTANCES: [f64; 8] = [0.01, 0.02, 0.03, 0.05, 0.075, 0.1, 0.15, 0.2];

/// An object that stays shall also stay when it is put so much farther to any side, m: it is not to stand on the very
/// edge.
pub(super) const MARGIN: f64 = 0.01;

/// Where there is room, that margin is this share of an object's width: other decompositions have the centre of mass of
/// a microwave oven 3 cm farther to one side.
pub(super) const WIDE_SHARE: f64 = 0.1;

/// Widest of these margins, m.
pub(super) const WIDEST: f64 = 0.03;

/// Shares of a margin that are tried outwards, to see how far an object is from falling.
pub(super) const STEPS: [f64; 3] = [0.25, 0.5, 0.75];

/// So many things at most are let go with what bears them, to see whether it stands at an edge with them: a pile of
/// hundreds would take minutes.
pub(super) const MOST_LOAD: usize = 32;

/// Something bears an object, too, if it is at most so much higher or lower than where that stands on its parent, m.
pub(super) const STEP: f32 = 0.05;

/// So much narrower than the object is its middle, which must be over another one of the same parent for a pile, and over
/// what bears it where it is put aside.
pub(super) const NARROW: f32 = 0.1;

/// What is over another one of the same parent lies on that if it is no higher than this, m: a card on a tray. What is
/// higher bears it only if the object is nearer to its top than to the parent.
pub(super) const THIN: f32 = 0.03;

/// An object leans on what is within this of its box, m …
pub(super) const BESIDE: f64 = 0.1;

/// … if it turns by less than this until it rests there, rad: what leans by chance is to be set upright …
pub(super) const STEADY: f32 = 0.05;

/// … or if it is thinner than this share of its length: a broom, a picture. It hardly stands upright, so it is meant to lean,
/// however far it is from what it leans on.
pub(super) const SLENDER: f64 = 0.12;

/// What stands at a wall and is thinner than this share of its height leans on it, however upright it was reconstructed:
/// a slope of 1.1° throws it over at 0.038.
pub(super) const FLIMSY: f64 = 0.045;

/// What has righted itself and come to rest farther aside than this is put back, m.
pub(super) const ASIDE: f32 = 2e-3;

/// What turns by more than this when put back rolls, rad.
pub(super) const ROLLS: f32 = 0.01;

/// How far what rolls is tilted to all sides before it is let go, rad.
pub(super) const TILTS: [f64; 5] = [0.05, 0.1, 0.2, 0.3, 0.45];

/// How far what rolls is tilted, to sixteen sides, where a place is looked for among others, rad …
pub(super) const PLACE_TILTS: [f64; 2] = [0.15, 0.3];

/// … and shifted to as many, m: a fruit comes to lean on a plate that is a hand away.
pub(super) const PLACE_SHIFTS: [f64; 5] = [0.0, 0.02, 0.04, 0.07, 0.1];

/// It does not start deeper than this in any of them, m.
pub(super) const OVERLAP: f32 = 5e-3;

/// A pose of rest is not farther aside than this, m.
pub(super) const ROLL_WITHIN: f64 = 0.12;

/// What has turned, gone aside or come down by more than this multiple of what a pose of rest may is given up.
pub(super) const ASTRAY: f64 = 1.5;

/// Poses of rest are one if they are nearer to each other than this, rad …
pub(super) const APART: f64 = 0.04;

/// … and than this, m.
pub(super) const PLACES_APART: f64 = 0.03;

/// How many of the nearest poses of rest are looked at.
pub(super) const NEAREST: usize = 36;

/// The tilt, to four sides, from which an object shall come back to its pose of rest, rad (1.1°): other engines and
/// other decompositions have such errors.
pub(super) const NUDGE: f64 = 0.02;

/// What a radian costs that it ends away from there, on average over all decompositions, in radians from the
/// reconstruction.
pub(super) const UNSTEADY: f64 = 3.0;
