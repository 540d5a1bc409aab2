//! What the second opinion looks at, and what a layout costs it: a radian is 1, and so are 17 cm by the default
//! weight of the layout term.

/// Most rounds.
pub(super) const ROUNDS: u32 = 20;

/// So many rounds in a row that find nothing better are the last …
pub(super) const PATIENCE: u32 = 2;

/// … and so many while something has lost its support, has fallen over or is on another level.
pub(super) const PATIENCE_WHILE_MISPLACED: u32 = 4;

/// Copies that a round looks at.
pub(super) const COPIES: u32 = 64;

/// Standard deviation of the shift of an object that fails: m, horizontal and vertical; and of its turn about each
/// axis, rad. The last copies have all of it, the first ones next to nothing.
pub(super) const SPREAD: [f32; 6] = [0.01, 0.0, 0.01, 0.3, 0.3, 0.3];

/// So many of the cheapest copies and mixtures of a round are looked at as a whole.
pub(super) const FINALISTS: usize = 8;

/// So often at most what rolls or has fallen is set down anew before the rounds.
pub(super) const TIMES_ANEW: usize = 5;

/// In so many poses, at most, an object is set down anew …
pub(super) const POSES: usize = 8;

/// … and so many of the cheapest of these are looked at as a whole.
pub(super) const FINALISTS_OF_ONE: usize = 2;

/// What has gone aside by more than this from where it was set onto its support is set down anew there, m: nearer places
/// are among those around it.
pub(super) const ANOTHER_PLACE: f64 = 0.06;

/// What rolls and stands farther than this from how it was set onto its support is set down anew once the rounds are over:
/// 8 cm, or 29°.
pub(super) const FAR_OFF: f64 = 0.5;

/// In a race so many of the cheapest trials lead …
pub(super) const LEADERS: usize = 8;

/// … and so many of those in which an object that fails costs least.
pub(super) const LEADERS_OF_ONE: usize = 2;

/// Less than this is no gain.
pub(super) const WORTH: f64 = 0.05;

/// How steep the slopes are, rad (1.1°): other engines push what touches apart by tenths of a millimetre, and what
/// stands on less than that falls there.
pub(super) const SLOPE: f32 = 0.02;

/// Share of the friction that is left on them: what leans with all of it creeps in engines whose friction gives way.
pub(super) const SLIPPERY: f32 = 0.7;

/// How long things are let go on slopes, at most, s: what rolls does so at once, and time is what these runs cost.
pub(super) const ON_SLOPE_SECONDS: f32 = 2.0;

/// Share of that time that V-HACD's runs take in a round: with so many copies they take longest of all, and what a round
/// finds is looked at once more for the whole time.
pub(super) const HASTE: f32 = 0.5;

/// What is deeper than this in another decomposition of what bears it is in a hollow that this fills, m: it finds rest
/// nowhere there, and stacked plates overlap in hundreds of pairs of parts.
pub(super) const FILLED: f32 = 0.004;

/// What moves by more than this share of what the check allows counts as moving: other engines differ by as much.
pub(super) const CALM: f64 = 0.5;

/// What it costs that an object moves with the parts of the search …
pub(super) const MOVES: f64 = 3.0;

/// … with others, which may be at fault themselves …
pub(super) const MOVES_OTHERWISE: f64 = 2.0;

/// … and with others on one of the slopes: all eight of these runs count as much as one of those.
pub(super) const MOVES_OTHERWISE_ON_SLOPE: f64 = 0.25;

/// What it costs that an object has lost its support.
pub(super) const LOST: f64 = 10.0;

/// What it costs that one has fallen over.
pub(super) const FELL: f64 = 5.0;

/// What it costs that one has come to another level.
pub(super) const ON_ANOTHER_LEVEL: f64 = 8.0;

/// What is so much higher or lower than it was set onto its support is on another level, m: what other parts push off
/// the board of a shelf finds rest on the next one.
pub(super) const LEVELS_APART: f64 = 0.1;

/// What it costs that one is jammed.
pub(super) const JAMS: f64 = 3.0;

/// An object turned by more than this from how it was set onto its support leans on something, or has fallen, rad
/// (15°).
pub(super) const LEANING: f64 = 0.26;
