// Kernel `contact_starts`: where the patches and points of each entry begin in the candidate's table, one workgroup a
// candidate: the order of `cpu::contacts::ContactSet`. Entries whose points do not all fit are left out, and all behind
// them.

#import batch
#import merged
#import sim
#import status

const STARTS_WORKGROUP: u32 = 32u;

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> merged: array<Merged>;
@group(0) @binding(3) var<storage, read_write> starts: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read_write> patch_counts: array<u32>;
@group(0) @binding(5) var<storage, read_write> point_counts: array<u32>;
@group(0) @binding(6) var<storage, read_write> statuses: array<u32>;

var<workgroup> sums: array<vec2<u32>, STARTS_WORKGROUP>;

@compute @workgroup_size(STARTS_WORKGROUP)
fn main(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    let candidate = workgroup.y * workgroups.x + workgroup.x;
    if (candidate >= batch.candidates) {
        return;
    }
    let entries = batch.pairs + batch.bodies;
    let portion = (entries + STARTS_WORKGROUP - 1u) / STARTS_WORKGROUP;
    let first = candidate * entries + min(lane * portion, entries);
    let end = candidate * entries + min((lane + 1u) * portion, entries);
    var sum = vec2(0u);
    for (var i = first; i < end; i++) {
        sum += contact_count(merged[i].sizes);
    }
    sums[lane] = sum;
    workgroupBarrier();
    var start = vec2(0u);
    for (var i = 0u; i < lane; i++) {
        start += sums[i];
    }
    for (var i = first; i < end; i++) {
        starts[i] = start;
        let next = start + contact_count(merged[i].sizes);
        // One entry alone is the first that does not fit.
        if (start.y <= sim.contacts && next.y > sim.contacts) {
            patch_counts[candidate] = start.x;
            statuses[candidate] |= STATUS_CONTACTS;
        }
        start = next;
    }
    if (lane == STARTS_WORKGROUP - 1u) {
        point_counts[candidate] = start.y;
        if (start.y <= sim.contacts) {
            patch_counts[candidate] = start.x;
        }
    }
}
