//! The least move that satisfies a list of half-spaces.
//!
//! min Σ wᵢ |xᵢ|² subject to dₖ · (xᵢ − xⱼ) ≥ cₖ is a convex quadratic programme whose dual has one non-negative
//! multiplier a half-space; Hildreth's method (1957), also known as projected Gauss–Seidel, raises or lowers one after
//! the other until each half-space is satisfied or its multiplier is 0.

use super::tolerances::{SATISFIED, SWEEPS};
use glam::DVec3;

/// `along · (x[first] − x[second]) ≥ least`, m; without a second it is `x[first]` alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HalfSpace {
    pub first: usize,
    pub second: Option<usize>,
    /// Unit vector.
    pub along: DVec3,
    pub least: f64,
}

/// The moves, m. `mobility[i]` is 1 / wᵢ, 0 for what stays. What cannot be satisfied is satisfied as far as the sweeps
/// get.
pub(super) fn least_move(half_spaces: &[HalfSpace], mobility: &[f64]) -> Vec<DVec3> {
    let mut moves = vec![DVec3::ZERO; mobility.len()];
    let mut multipliers = vec![0.0; half_spaces.len()];
    for _ in 0..SWEEPS {
        let mut worst = 0.0f64;
        for (space, multiplier) in half_spaces.iter().zip(&mut multipliers) {
            let second = space.second.map_or((DVec3::ZERO, 0.0), |i| (moves[i], mobility[i]));
            let give = mobility[space.first] + second.1;
            if give == 0.0 {
                continue;
            }
            let missed = space.least - space.along.dot(moves[space.first] - second.0);
            let raise = (missed / give).max(-*multiplier);
            *multiplier += raise;
            moves[space.first] += raise * mobility[space.first] * space.along;
            if let Some(i) = space.second {
                moves[i] -= raise * mobility[i] * space.along;
            }
            worst = worst.max((raise * give).abs());
        }
        if worst < SATISFIED {
            break;
        }
    }
    moves
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apart(first: usize, second: usize, along: DVec3, least: f64) -> HalfSpace {
        HalfSpace { first, second: Some(second), along, least }
    }

    #[test]
    fn two_share_the_way_by_their_weights() {
        let moves = least_move(&[apart(0, 1, DVec3::X, 0.4)], &[1.0, 1.0 / 3.0]);
        assert!(moves[0].distance(DVec3::X * 0.3) < 1e-5 && moves[1].distance(DVec3::NEG_X * 0.1) < 1e-5, "{moves:?}");
        assert_eq!(least_move(&[apart(0, 1, DVec3::X, -0.1)], &[1.0, 1.0]), [DVec3::ZERO; 2]);
        assert_eq!(least_move(&[apart(0, 1, DVec3::X, 0.4)], &[0.0, 0.0]), [DVec3::ZERO; 2]);
    }

    /// Without the multipliers, the first half-space would push the second unit away although the third does not need
    /// it.
    #[test]
    fn a_half_space_that_others_satisfy_does_not_push() {
        let wall = HalfSpace { first: 0, second: None, along: DVec3::X, least: 1.0 };
        let moves = least_move(&[apart(0, 1, DVec3::X, 0.5), wall], &[1.0, 1.0]);
        assert!(moves[0].distance(DVec3::X) < 1e-5 && moves[1].length() < 1e-5, "{moves:?}");
    }

    #[test]
    fn a_row_is_spread_about_its_middle() {
        let moves = least_move(&[apart(0, 1, DVec3::X, 0.2), apart(1, 2, DVec3::X, 0.2)], &[1.0; 3]);
        for (found, wanted) in moves.iter().zip([0.2, 0.0, -0.2]) {
            assert!(found.distance(DVec3::X * wanted) < 1e-4, "{moves:?}");
        }
    }
}
