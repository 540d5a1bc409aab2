// Kernel `sample`: draws the candidates' adjustments from the search's Gaussian.
//
// One invocation draws four dimensions of one candidate from counter (stage, iteration, candidate, dimension / 4). A
// candidate's numbers depend on nothing else; antithetic ones share those of a pair.

#import batch
#import draw
#import grid
#import philox

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> draw: Draw;
@group(0) @binding(2) var<storage, read> mean: array<f32>;
@group(0) @binding(3) var<storage, read> std_: array<f32>;
@group(0) @binding(4) var<storage, read_write> deltas: array<f32>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let blocks = (batch.dimensions + 3u) / 4u;
    let index = invocation(id, workgroups);
    if (index >= batch.candidates * blocks) {
        return;
    }
    let candidate = index / blocks;
    let block = index % blocks;
    let drawn = select(candidate, candidate & ~1u, draw.antithetic == 1u);
    let words = philox(vec4(draw.stage, draw.iteration, drawn, block), vec2(draw.key_low, draw.key_high));
    let spread = select(select(-1.0, 1.0, candidate == drawn), 0.0, draw.sample_mean == 1u && candidate == 0u);
    let z = normals(words) * spread;
    for (var lane = 0u; lane < min(4u, batch.dimensions - 4u * block); lane++) {
        let dimension = 4u * block + lane;
        deltas[candidate * batch.dimensions + dimension] = mean[dimension] + std_[dimension] * z[lane];
    }
}
