//! Kernel `elites`: the candidates of lowest energy, in rank order.

use crate::world::Energy;

/// Maps an energy to an integer of the same order (that of `f32::total_cmp`: +∞ last but for NaN), as a sorting kernel
/// needs it.
pub fn orderable(energy: f32) -> u32 {
    let bits = energy.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 0x8000_0000 }
}

/// Fills `order` (one entry a candidate) with the candidates by rising total energy, ties to the lower index, and
/// returns how many of the first `wanted` are usable: fewer only if too few simulations succeeded.
pub fn elites(energies: &[Energy], wanted: usize, order: &mut [u32]) -> usize {
    for (index, slot) in order.iter_mut().enumerate() {
        *slot = index as u32;
    }
    order.sort_unstable_by_key(|&i| (orderable(energies[i as usize].total), i));
    order.iter().take(wanted).filter(|&&i| energies[i as usize].total.is_finite()).count()
}
