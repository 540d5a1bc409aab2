// The energy of a candidate; the total of one that failed is +∞.

const INFINITY_BITS: u32 = 0x7f800000u;

struct Energy {
    total: f32,
    stability: f32,
    velocity: f32,
    penetration: f32,
    layout_: f32,
}

// Shaders may assume that no number is infinite or NaN, so finiteness is asked of the bits.
fn is_finite(bits: u32) -> bool {
    return (bits & INFINITY_BITS) != INFINITY_BITS;
}

// Maps the bits of an energy to an integer of the same order.
fn orderable(bits: u32) -> u32 {
    return select(bits | 0x80000000u, ~bits, (bits >> 31u) == 1u);
}
