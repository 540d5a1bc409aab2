// What is left of the contact points of an entry: a body pair, or past the pairs a body and the ground.

struct Merged {
    // Points of each patch, four bits a patch, the first lowest.
    sizes: u32,
    // Where the numbers of its points begin; `KEPT` if it keeps its contacts.
    first: u32,
}

const KEPT: u32 = 0xffffffffu;

fn patch_size(sizes: u32, k: u32) -> u32 {
    return extractBits(sizes, 4u * k, 4u);
}

// Patches and points.
fn contact_count(sizes: u32) -> vec2<u32> {
    let low = (vec4(sizes) >> vec4(0u, 4u, 8u, 12u)) & vec4(15u);
    let high = (vec4(sizes) >> vec4(16u, 20u, 24u, 28u)) & vec4(15u);
    return vec2(dot(min(low, vec4(1u)) + min(high, vec4(1u)), vec4(1u)), dot(low + high, vec4(1u)));
}
