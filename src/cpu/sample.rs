//! Kernel `sample`: draws one candidate's adjustment from the search's Gaussian.
//!
//! Random numbers come from Philox4x32-10 (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011): key
//! = seed, counter = (stage, iteration, candidate, dimension / 4). A candidate's numbers depend on nothing else, so K,
//! threads and neighbours cannot change them.

use crate::world::{CemSettings, Distribution, Stream, sin_cos_quarters};
use std::f32::consts::LN_2;

/// Philox4x32-10: four random words for a counter and a key.
pub fn philox(counter: [u32; 4], key: [u32; 2]) -> [u32; 4] {
    const MULTIPLIERS: [u32; 2] = [0xD251_1F53, 0xCD9E_8D57];
    const WEYL: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];
    let [mut x0, mut x1, mut x2, mut x3] = counter;
    let [mut k0, mut k1] = key;
    for _ in 0..10 {
        let a = u64::from(MULTIPLIERS[0]) * u64::from(x0);
        let b = u64::from(MULTIPLIERS[1]) * u64::from(x2);
        [x0, x1, x2, x3] = [(b >> 32) as u32 ^ x1 ^ k0, b as u32, (a >> 32) as u32 ^ x3 ^ k1, a as u32];
        k0 = k0.wrapping_add(WEYL[0]);
        k1 = k1.wrapping_add(WEYL[1]);
    }
    [x0, x1, x2, x3]
}

/// Natural logarithm of a positive normal number, in the shader's operations: x = m · 2ᵏ with m in [√½, √2), and
/// ln m = 2 artanh((m − 1) / (m + 1)).
fn logarithm(x: f32) -> f32 {
    const ROOT_HALF_BITS: u32 = 0x3f35_04f3;
    let bits = x.to_bits();
    let k = (bits.wrapping_sub(ROOT_HALF_BITS) as i32) >> 23;
    let m = f32::from_bits(bits.wrapping_sub((k as u32) << 23));
    let s = (m - 1.0) / (m + 1.0);
    let t = s * s;
    let series = 1.0 + t * (1.0 / 3.0 + t * (1.0 / 5.0 + t * (1.0 / 7.0 + t * (1.0 / 9.0))));
    k as f32 * LN_2 + 2.0 * s * series
}

/// Four standard normals from four random words (Box and Muller). Radii come from 24 bits in (0, 1], so the logarithm
/// is finite and no normal exceeds 5.8.
pub fn normals(words: [u32; 4]) -> [f32; 4] {
    const UNIT: f32 = 1.0 / 16_777_216.0;
    let pair = |a: u32, b: u32| {
        let radius = (-2.0 * logarithm(((a >> 8) + 1) as f32 * UNIT)).sqrt();
        let (sin, cos) = sin_cos_quarters(((b >> 8) as f32 * UNIT - 0.5) * 4.0);
        [radius * cos, radius * sin]
    };
    let ([a, b], [c, d]) = (pair(words[0], words[1]), pair(words[2], words[3]));
    [a, b, c, d]
}

/// Fills `delta` (6 · units: shift x y z in m, axis-angle x y z in rad, for each unit) with `mean + std · normal`.
pub fn sample(mean: &[f32], std: &[f32], stream: Stream, iteration: u32, candidate: u32, delta: &mut [f32]) {
    scaled(mean, std, (stream, iteration, candidate), 1.0, delta);
}

/// The same for a candidate of a search, of which one may be the mean and others each other's mirror image.
pub fn sample_candidate(
    cem: &CemSettings,
    distribution: &Distribution,
    (stream, iteration): (Stream, u32),
    candidate: u32,
    delta: &mut [f32],
) {
    let drawn = if cem.antithetic { candidate & !1 } else { candidate };
    let spread = match candidate {
        0 if cem.sample_mean => 0.0,
        _ if candidate == drawn => 1.0,
        _ => -1.0,
    };
    scaled(&distribution.mean, &distribution.std, (stream, iteration, drawn), spread, delta);
}

/// `mean + std · spread · normal`
fn scaled(
    mean: &[f32],
    std: &[f32],
    (stream, iteration, candidate): (Stream, u32, u32),
    spread: f32,
    delta: &mut [f32],
) {
    let key = [stream.seed as u32, (stream.seed >> 32) as u32];
    for (block, out) in delta.chunks_mut(4).enumerate() {
        let z = normals(philox([stream.stage, iteration, candidate, block as u32], key));
        for (lane, value) in out.iter_mut().enumerate() {
            let dimension = 4 * block + lane;
            *value = mean[dimension] + std[dimension] * (spread * z[lane]);
        }
    }
}
