// Kernel `scatter`: what came of the candidates that `gather` handed to the simulation goes back to their own rows, one
// invocation a candidate. Its twin is the end of a round in `cpu::search`.

#import batch
#import grid
#import portion
#import pose

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> portion: Portion;
@group(0) @binding(2) var<storage, read> order: array<u32>;
@group(0) @binding(3) var<storage, read> poses: array<Pose>;
@group(0) @binding(4) var<storage, read> snapshot: array<Velocity>;
@group(0) @binding(5) var<storage, read> depths_placed: array<f32>;
@group(0) @binding(6) var<storage, read> depths_settled: array<f32>;
@group(0) @binding(7) var<storage, read> statuses: array<u32>;
@group(0) @binding(8) var<storage, read_write> all_poses: array<Pose>;
@group(0) @binding(9) var<storage, read_write> all_snapshots: array<Velocity>;
@group(0) @binding(10) var<storage, read_write> all_depths_placed: array<f32>;
@group(0) @binding(11) var<storage, read_write> all_depths_settled: array<f32>;
@group(0) @binding(12) var<storage, read_write> all_statuses: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let slot = invocation(id, workgroups);
    if (slot >= portion.count) {
        return;
    }
    let candidate = order[portion.first + slot];
    for (var body = 0u; body < batch.bodies; body++) {
        all_poses[candidate * batch.bodies + body] = poses[slot * batch.bodies + body];
        all_snapshots[candidate * batch.bodies + body] = snapshot[slot * batch.bodies + body];
    }
    for (var pair = 0u; pair < batch.pairs; pair++) {
        all_depths_placed[candidate * batch.pairs + pair] = depths_placed[slot * batch.pairs + pair];
        all_depths_settled[candidate * batch.pairs + pair] = depths_settled[slot * batch.pairs + pair];
    }
    all_statuses[candidate] = statuses[slot];
}
