// Kernel `pass_over`: marks all candidates as not chosen; `scatter` takes that from those which are. Its twin is what
// `cpu::search` does to all energies at the end of a round.

#import batch
#import grid
#import status

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<storage, read_write> statuses: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let candidate = invocation(id, workgroups);
    if (candidate < batch.candidates) {
        statuses[candidate] |= STATUS_PASSED_OVER;
    }
}
