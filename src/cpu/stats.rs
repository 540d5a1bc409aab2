//! Kernels `flags` and `stats`: what an iteration reports.

use crate::world::{Energy, Status, Winner};

/// How many candidates have each bit of `Status::FAULTS` set.
pub fn flags(statuses: &[Status]) -> [u32; Status::FAULTS.len()] {
    Status::FAULTS.map(|fault| statuses.iter().filter(|status| status.intersects(fault.bit)).count() as u32)
}

/// Mean total of the elites, rows of candidates or of the winner; +∞ if there is none.
pub fn elite_mean(energies: &[Energy], elites: &[u32], winner: &Winner) -> f32 {
    let total = |&row: &u32| energies.get(row as usize).unwrap_or(&winner.energy).total;
    match elites.len() {
        0 => f32::INFINITY,
        n => elites.iter().map(total).sum::<f32>() / n as f32,
    }
}
