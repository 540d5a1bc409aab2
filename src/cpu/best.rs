//! Kernel `best`: keeps the best candidate ever, and lists the rows that the distribution follows.

use crate::world::{Energy, Winner};

/// Replaces `winner` by the first of `order` if that is better, and copies its adjustment to the row of `deltas` after
/// the last candidate's. Fills `elites` with the rows to follow: the first `wanted` of the `usable` ranks; once the
/// iteration brings nothing better, the winner takes the place of the worst of them, as in the released code.
pub fn best(
    energies: &[Energy],
    (order, usable): (&[u32], usize),
    wanted: usize,
    iteration: u32,
    deltas: &mut [f32],
    winner: &mut Winner,
    elites: &mut Vec<u32>,
) {
    let (candidate, row) = (order[0], energies.len());
    let energy = energies[candidate as usize];
    elites.clear();
    if energy.total < winner.energy.total {
        *winner = Winner { energy, iteration, candidate };
        let width = deltas.len() / (row + 1);
        let from = candidate as usize * width;
        deltas.copy_within(from..from + width, row * width);
    } else if winner.is_known() {
        elites.push(row as u32);
    }
    elites.extend_from_slice(&order[..usable.min(wanted - elites.len())]);
}
