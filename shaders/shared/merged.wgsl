// What is left of the contact points of an entry: a body pair, or past the pairs a body and the ground.

struct Merged {
    // Points of each patch, eight bits a patch, the first lowest.
    sizes: u32,
    // Where the numbers of its points begin.
    first: u32,
}

fn patch_size(sizes: u32, k: u32) -> u32 {
    return extractBits(sizes, 8u * k, 8u);
}

// Patches and points.
fn contact_count(sizes: u32) -> vec2<u32> {
    let bytes = (vec4(sizes) >> vec4(0u, 8u, 16u, 24u)) & vec4(255u);
    return vec2(dot(min(bytes, vec4(1u)), vec4(1u)), dot(bytes, vec4(1u)));
}
