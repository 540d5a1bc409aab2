// Kernel `place`: poses of all bodies of all candidates, one invocation a body.
//
// Each unit turns about its pivot and shifts; its bodies go along rigidly. Static bodies keep their start.

#import batch
#import body
#import grid
#import pose

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<storage, read> bodies: array<Body>;
@group(0) @binding(2) var<storage, read> units: array<Unit>;
@group(0) @binding(3) var<storage, read> start: array<Pose>;
@group(0) @binding(4) var<storage, read> deltas: array<f32>;
@group(0) @binding(5) var<storage, read_write> placed: array<Pose>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let index = invocation(id, workgroups);
    if (index >= batch.candidates * batch.bodies) {
        return;
    }
    let candidate = index / batch.bodies;
    let body = index % batch.bodies;
    var pose = start[body];
    let unit = bodies[body].unit;
    if (unit != STATIC) {
        let pivot = units[unit].pivot;
        let d = candidate * batch.dimensions + 6u * unit;
        let shift = vec3(deltas[d], deltas[d + 1u], deltas[d + 2u]);
        let turn = from_scaled_axis(vec3(deltas[d + 3u], deltas[d + 4u], deltas[d + 5u]));
        pose.rotation = unit_rotation(compose(turn, pose.rotation));
        pose.translation = rotate(turn, pose.translation - pivot) + pivot + shift;
    }
    placed[index] = pose;
}
