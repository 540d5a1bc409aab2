// Kernel `pair_starts`: sums the counts up in pair order, one workgroup a candidate.
//
// Each invocation sums a share of consecutive pairs. The last start is the candidate's total; it goes on past the
// slots. Part of `cpu::broad_phase::BroadPhase::pairs`.

#import batch
#import grid
#import sim
#import status

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> pair_counts: array<u32>;
@group(0) @binding(3) var<storage, read_write> pair_starts: array<u32>;
@group(0) @binding(4) var<storage, read_write> most_hull_pairs: array<u32>;
@group(0) @binding(5) var<storage, read_write> statuses: array<u32>;

var<workgroup> sums: array<u32, WORKGROUP>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let number = invocation(id, workgroups);
    let candidate = number / WORKGROUP;
    let lane = number % WORKGROUP;
    if (candidate >= batch.candidates) {
        return;
    }
    let share = (batch.pairs + WORKGROUP - 1u) / WORKGROUP;
    let first = min(lane * share, batch.pairs);
    let end = min(first + share, batch.pairs);
    let row = candidate * batch.pairs;
    var sum = 0u;
    for (var pair = first; pair < end; pair++) {
        sum += pair_counts[row + pair];
    }
    sums[lane] = sum;
    workgroupBarrier();
    var start = 0u;
    for (var i = 0u; i < lane; i++) {
        start += sums[i];
    }
    // A row of starts is longer by one.
    for (var pair = first; pair < end; pair++) {
        pair_starts[row + candidate + pair] = start;
        start += pair_counts[row + pair];
    }
    if (lane == WORKGROUP - 1u) {
        pair_starts[row + candidate + batch.pairs] = start;
        most_hull_pairs[candidate] = max(most_hull_pairs[candidate], start);
        statuses[candidate] |= select(0u, STATUS_HULL_PAIRS, start > sim.hull_pairs);
    }
}
