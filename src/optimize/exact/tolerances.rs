//! Every number that the exact step decides by, with its unit and what it is for.

/// Clearance that resting surfaces get, m: no two triangles meet in any engine's arithmetic, and falling so far gives
/// 0.03 m/s.
pub(super) const REST: f64 = 0.05e-3;

/// What stands no farther than this above `REST` is lowered to it, m: parts reach so far beyond the meshes, where soles
/// are flat or round things are covered, and may reach as far into each other. Engines allow more.
pub(super) const SINK: f64 = 0.15e-3;

/// Meshes nearer than this count as touching and are parted, m. Far above the rounding of a file's decimals.
pub(super) const TOUCHING: f64 = 0.02e-3;

/// Clearance that surfaces get which stand beside each other, m.
pub(super) const ASIDE: f64 = 0.5e-3;

/// Surfaces beside each other that are nearer than this are moved to `ASIDE`, m.
pub(super) const TOO_NEAR: f64 = 0.4e-3;

/// The shortest way between two surfaces is sideways if its vertical share is less than this (sine of 17°).
pub(super) const SIDEWAYS: f64 = 0.3;

/// A free place is first looked for within these distances, m.
pub(super) const REACHES: [f64; 2] = [2e-3, 8e-3];

/// Nothing is moved farther at once than this, m: what needs more is no contact but a wrong place.
pub(super) const MAX_MOVE: f64 = 0.03;

/// The same for what no simulation parts before: things on walls and ceilings, m.
pub(super) const MAX_MOVE_HUNG: f64 = 0.1;

/// What hangs on an object and is no farther from it than this is taken to it, m: what is farther may hang on something
/// else.
pub(super) const HOLDS: f64 = 0.05;

/// Upwards is preferred to a move sideways that is not shorter than this share of it.
pub(super) const UP: f64 = 0.7;

/// What a move costs more for each object that moves along.
pub(super) const LOAD: f64 = 0.1;

/// How many margins a move goes beyond the place where two meshes no longer meet, the first that suffices.
pub(super) const SPARES: [f64; 4] = [0.0, 1.0, 3.0, 7.0];

/// Rounds of looking for meshes that touch and parting them.
pub(super) const ROUNDS: usize = 8;

/// How far down one looks for what an object rests on, m.
pub(super) const DROP: f64 = 0.05;

/// Most pairs of triangles that are looked at, once for parting and once for the report: some ten seconds. Then things
/// are left as they are, and the report says so.
pub(super) const MAX_PAIRS: u64 = 50_000_000;

/// Boxes of triangles are widened by this against the rounding of f32, m.
pub(super) const ROUNDING: f64 = 1e-5;
