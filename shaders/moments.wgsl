// Kernel `moments`: the Gaussian of the elites, one invocation a dimension.
//
// Two passes over the elites in rank order. No elites: nothing changes.

#import batch
#import grid
#import update

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> update: Update;
@group(0) @binding(2) var<storage, read> deltas: array<f32>;
@group(0) @binding(3) var<storage, read> elites: array<u32>;
@group(0) @binding(4) var<storage, read> count: u32;
@group(0) @binding(5) var<storage, read> floors: array<f32>;
@group(0) @binding(6) var<storage, read_write> mean: array<f32>;
@group(0) @binding(7) var<storage, read_write> std_: array<f32>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let d = invocation(id, workgroups);
    let rows = min(count, update.wanted);
    if (d >= batch.dimensions || rows == 0u) {
        return;
    }
    var sum = 0.0;
    for (var i = 0u; i < rows; i++) {
        sum += deltas[elites[i] * batch.dimensions + d];
    }
    let average = sum / f32(rows);
    var squares = 0.0;
    for (var i = 0u; i < rows; i++) {
        let x = deltas[elites[i] * batch.dimensions + d] - average;
        squares += x * x;
    }
    mean[d] = average;
    std_[d] = max(sqrt(squares / f32(rows)) + update.epsilon, floors[d]);
}
