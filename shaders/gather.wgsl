// Kernel `gather`: hands some candidates to the simulation by their rank, one invocation a body. Its twin is the list
// of chosen candidates in `cpu::search`.

#import batch
#import grid
#import portion
#import pose

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> portion: Portion;
@group(0) @binding(2) var<storage, read> order: array<u32>;
@group(0) @binding(3) var<storage, read> placed: array<Pose>;
@group(0) @binding(4) var<storage, read_write> poses: array<Pose>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let index = invocation(id, workgroups);
    let slot = index / batch.bodies;
    if (slot < portion.count) {
        poses[index] = placed[order[portion.first + slot] * batch.bodies + index % batch.bodies];
    }
}
