// Kernel `flags`: how many candidates have each bit of `world::Status` set; one workgroup. Twin of
// `cpu::stats::flags`.

#import batch
#import grid

struct Flags {
    // By bit.
    counts: array<u32, 3>,
}

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<storage, read> statuses: array<u32>;
@group(0) @binding(2) var<storage, read_write> flags: Flags;

var<workgroup> shares: array<vec3<u32>, WORKGROUP>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_index) lane: u32) {
    var share = vec3(0u);
    for (var i = lane; i < batch.candidates; i += WORKGROUP) {
        share += (vec3(statuses[i]) >> vec3(0u, 1u, 2u)) & vec3(1u);
    }
    shares[lane] = share;
    workgroupBarrier();
    if (lane == 0u) {
        for (var i = 1u; i < WORKGROUP; i++) {
            share += shares[i];
        }
        flags.counts[0] = share.x;
        flags.counts[1] = share.y;
        flags.counts[2] = share.z;
    }
}
