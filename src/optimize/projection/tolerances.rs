//! Every number that the projection decides by, with its unit and what it is for.

use crate::world::constants::TOUCHING_DEPTH;

/// Overlap of two parts that is left alone, m: what the energy counts as touching. The result has none that is deeper.
pub(super) const TOUCHING: f32 = TOUCHING_DEPTH;

/// Room that two things get when they are parted, m: rounding never makes a parted pair overlap again.
pub(super) const MARGIN: f32 = 0.1e-3;

/// Room that things beside each other are given at the end, each as a share of its size and at most so many m: other
/// engines' convex parts reach beyond a mesh by so much, and what begins inside another is thrown.
pub(super) const ROOM: f32 = 0.005;
pub(super) const MAX_ROOM: f32 = 0.01;

/// Nothing goes farther for that, m.
pub(super) const MAX_SPREAD: f64 = 0.05;

/// Sideways directions that are tried.
pub(super) const SIDES: usize = 16;

/// What a metre costs sideways where an object overlaps what bears it: it belongs above.
pub(super) const OFF_THE_BEARER: f32 = 2.0;

/// What a metre costs upwards where two things overlap that one bearer carries: they stand side by side, unless one of
/// them lies on the other and has sunk in.
pub(super) const ONTO_THE_OTHER: f32 = 3.0;

/// A pair that overlaps again prefers the direction that it has by this share of its length: without it pairs change
/// sides for ever.
pub(super) const LOYALTY: f32 = 0.5;

/// A pair that has changed its direction so many times keeps the one that it has.
pub(super) const CHANGES: u32 = 4;

/// Rounds of looking for overlaps and solving for the least move. What converges does so within ten or so.
pub(super) const ROUNDS: u32 = 60;

/// Sweeps over the half-spaces of a round.
pub(super) const SWEEPS: u32 = 400;

/// A half-space is satisfied when it is missed by less than this, m.
pub(super) const SATISFIED: f64 = 1e-6;

/// Nothing is moved farther than this, m: constraints that ask for more contradict each other.
pub(super) const MAX_MOVE: f64 = 2.0;

/// Halvings of the way back to the reconstruction that are tried at the end.
pub(super) const HALVINGS: u32 = 6;
