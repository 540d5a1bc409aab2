// Kernel `elites`: ranks the candidates by total energy, ties to the lower index.
//
// One invocation a candidate counts the candidates before it, which is its rank: K² comparisons, but all threads read the
// same entry at the same time and never wait for each other; faster than a sort with barriers for any K in use.

#import batch
#import energy
#import grid
#import update

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> update: Update;
@group(0) @binding(2) var<storage, read> energies: array<Energy>;
@group(0) @binding(3) var<storage, read_write> order: array<u32>;
@group(0) @binding(4) var<storage, read_write> usable: u32;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let candidate = invocation(id, workgroups);
    if (candidate >= batch.candidates) {
        return;
    }
    let own = orderable(bitcast<u32>(energies[candidate].total));
    var rank = 0u;
    var finite = 0u;
    for (var other = 0u; other < batch.candidates; other++) {
        let bits = bitcast<u32>(energies[other].total);
        let key = orderable(bits);
        rank += select(0u, 1u, key < own || (key == own && other < candidate));
        finite += select(0u, 1u, is_finite(bits));
    }
    order[rank] = candidate;
    if (candidate == 0u) {
        usable = min(finite, update.wanted);
    }
}
