// Philox4x32-10 (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011) and normals from it.

#import trigonometry

// 2⁻²⁴: random words are used with 24 bits, which f32 holds exactly.
const PHILOX_UNIT: f32 = 1.0 / 16777216.0;

// High word of a 64-bit product, from 16-bit halves.
fn multiply_high(a: u32, b: u32) -> u32 {
    let low = (a & 0xffffu) * (b & 0xffffu);
    let middle = (a >> 16u) * (b & 0xffffu) + (low >> 16u);
    let other = (a & 0xffffu) * (b >> 16u) + (middle & 0xffffu);
    return (a >> 16u) * (b >> 16u) + (middle >> 16u) + (other >> 16u);
}

// Four random words for a counter and a key.
fn philox(counter: vec4<u32>, key: vec2<u32>) -> vec4<u32> {
    const MULTIPLIERS = vec2<u32>(0xd2511f53u, 0xcd9e8d57u);
    const WEYL = vec2<u32>(0x9e3779b9u, 0xbb67ae85u);
    var x = counter;
    var k = key;
    for (var round = 0u; round < 10u; round++) {
        x = vec4(
            multiply_high(MULTIPLIERS.y, x.z) ^ x.y ^ k.x,
            MULTIPLIERS.y * x.z,
            multiply_high(MULTIPLIERS.x, x.x) ^ x.w ^ k.y,
            MULTIPLIERS.x * x.x,
        );
        k += WEYL;
    }
    return x;
}

// Natural logarithm of positive normal numbers. Shaders promise theirs near 1 to 2⁻²¹ only, and the root of that would
// be an error of 10⁻³ in a radius. x = m · 2ᵏ with m in [√½, √2), and ln m = 2 artanh((m − 1) / (m + 1)).
fn logarithm(x: vec2<f32>) -> vec2<f32> {
    const LN_2: f32 = 0.6931472;
    const ROOT_HALF_BITS = 0x3f3504f3u;
    let bits = bitcast<vec2<u32>>(x);
    let k = bitcast<vec2<i32>>(bits - ROOT_HALF_BITS) >> vec2(23u);
    let m = bitcast<vec2<f32>>(bits - (bitcast<vec2<u32>>(k) << vec2(23u)));
    let s = (m - 1.0) / (m + 1.0);
    let t = s * s;
    let series = 1.0 + t * (1.0 / 3.0 + t * (1.0 / 5.0 + t * (1.0 / 7.0 + t * (1.0 / 9.0))));
    return vec2<f32>(k) * LN_2 + 2.0 * s * series;
}

// Four standard normals from four random words (Box and Muller). Radii come from 24 bits in (0, 1], so the logarithm is
// finite.
fn normals(words: vec4<u32>) -> vec4<f32> {
    let radius = sqrt(-2.0 * logarithm(vec2<f32>((words.xz >> vec2(8u)) + vec2(1u)) * PHILOX_UNIT));
    let turn = sin_cos_quarters((vec2<f32>(words.yw >> vec2(8u)) * PHILOX_UNIT - 0.5) * 4.0);
    let x = radius * turn[1];
    let y = radius * turn[0];
    return vec4(x.x, y.x, x.y, y.y);
}
