// Kernel `depth`: the deepest overlap of the hulls of each body pair, one invocation a candidate and pair.
// Twin of `cpu::narrow_phase::Separator::depth` over the lists of `cpu::broad_phase`.

#import batch
#import contact
#import grid
#import sim

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> pair_starts: array<u32>;
@group(0) @binding(3) var<storage, read> separations: array<Separation>;
@group(0) @binding(4) var<storage, read_write> depths: array<f32>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let index = invocation(id, workgroups);
    if (index >= batch.candidates * batch.pairs) {
        return;
    }
    let candidate = index / batch.pairs;
    // A row of starts is longer by one.
    let at = index + candidate;
    let end = min(pair_starts[at + 1u], sim.hull_pairs);
    var deepest = 0.0;
    for (var slot = pair_starts[at]; slot < end; slot++) {
        let found = separations[candidate * sim.hull_pairs + slot];
        deepest = max(deepest, select(-found.distance, 0.0, found.feature == 0u));
    }
    depths[index] = deepest;
}
