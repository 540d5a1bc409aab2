// Kernel `boxes`: boxes of all bodies and their hulls, one invocation a body.
//
// Twin of `cpu::broad_phase::BroadPhase::update`: rotated local boxes, so that no vertex is read. Margins grow with
// speed. Bodies that hardly moved are still; where the others are is noted.

#import constants
#import batch
#import body
#import bounds
#import frame
#import grid
#import hull
#import pose
#import sim

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> bodies: array<Body>;
@group(0) @binding(3) var<storage, read> hulls: array<Hull>;
@group(0) @binding(4) var<storage, read> poses: array<Pose>;
@group(0) @binding(5) var<storage, read> velocities: array<Velocity>;
@group(0) @binding(6) var<storage, read_write> hull_boxes: array<Bounds>;
@group(0) @binding(7) var<storage, read_write> body_boxes: array<Bounds>;
@group(0) @binding(8) var<storage, read_write> marks: array<Mark>;

// True if a body of this radius (m) is where it was, and looks no farther.
fn holds(mark: Mark, pose: Pose, margin: f32, radius: f32) -> bool {
    // Half the angle for small ones; large without a rotation.
    let turned = length(pose.rotation.xyz - mark.rotation.xyz) + abs(pose.rotation.w - mark.rotation.w);
    let moved = length(pose.translation - mark.translation) + 2.0 * radius * turned;
    return moved <= RECYCLING_DISTANCE && margin <= mark.margin + RECYCLING_DISTANCE;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let index = invocation(id, workgroups);
    if (index >= batch.candidates * batch.bodies) {
        return;
    }
    let candidate = index / batch.bodies;
    let body = bodies[index % batch.bodies];
    let last = bodies[batch.bodies - 1u];
    let row = candidate * (last.first_hull + last.hull_count);
    let pose = poses[index];
    let velocity = velocities[index];
    let reach = sim.substep * (length(velocity.linear) + length(velocity.angular) * body.radius);
    let margin = 0.5 * sim.contact_offset + min(reach, 0.5 * MAX_SPECULATIVE_MARGIN);

    let turn = matrix(pose.rotation);
    let spread = mat3x3(abs(turn[0]), abs(turn[1]), abs(turn[2]));
    var low = vec3(-NO_EXTENT);
    var high = vec3(NO_EXTENT);
    for (var i = body.first_hull; i < body.first_hull + body.hull_count; i++) {
        let center = times(turn, hulls[i].center) + pose.translation;
        let extents = times(spread, hulls[i].half_extents);
        low = min(low, center - extents);
        high = max(high, center + extents);
        hull_boxes[row + i] = Bounds(center, margin, extents, 0u);
    }
    let is_still = holds(marks[index], pose, margin, body.radius);
    body_boxes[index] = Bounds(0.5 * (low + high), margin, 0.5 * (high - low), u32(is_still));
    if (!is_still) {
        marks[index] = Mark(pose.rotation, pose.translation, margin);
    }
}
