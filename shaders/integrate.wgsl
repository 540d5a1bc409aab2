// Kernel `integrate`: writes a substep's motion into poses and velocities, and its impulses into the contacts; 32
// invocations share a candidate's bodies and patches.
// End of `cpu::solve::Solver::substep`; as `cpu::solve::integrate`.

#import constants
#import batch
#import body
#import contact
#import energy
#import excess
#import grid
#import pose
#import sim
#import solver
#import status

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> bodies: array<Body>;
@group(0) @binding(3) var<storage, read> moving: array<Moving>;
@group(0) @binding(4) var<storage, read> axes: array<Axes>;
@group(0) @binding(5) var<storage, read> patch_counts: array<u32>;
@group(0) @binding(6) var<storage, read> frictions: array<Friction>;
@group(0) @binding(7) var<storage, read> normals: array<Normal>;
@group(0) @binding(8) var<storage, read> gaps: array<Gap>;
@group(0) @binding(9) var<storage, read> cursors: array<Cursor>;
@group(0) @binding(10) var<storage, read_write> patches: array<Patch>;
@group(0) @binding(11) var<storage, read_write> contacts: array<Contact>;
@group(0) @binding(12) var<storage, read_write> poses: array<Pose>;
@group(0) @binding(13) var<storage, read_write> velocities: array<Velocity>;
@group(0) @binding(14) var<storage, read_write> statuses: array<atomic<u32>>;

fn turned(rotation: vec4<f32>, turn: vec3<f32>) -> vec4<f32> {
    return unit_rotation(compose(from_scaled_axis(turn), rotation));
}

// Angular velocity of a body with this angular momentum.
fn spin_at(rotation: vec4<f32>, momentum: vec3<f32>, inverse_inertia: vec3<f32>) -> vec3<f32> {
    return rotate(rotation, rotate(conjugate(rotation), momentum) * inverse_inertia);
}

// How fast a spin changes without torque, in the body's frame (Euler's equations).
fn free_change(spin: vec3<f32>, inertia: vec3<f32>, inverse_inertia: vec3<f32>) -> vec3<f32> {
    return cross(inertia * spin, spin) * inverse_inertia;
}

// Spin of a body after a substep without torque, in its own frame, with the energy that it had.
fn free_spin(spin: vec3<f32>, inverse_inertia: vec3<f32>) -> vec3<f32> {
    let dt = sim.substep;
    let inertia = 1.0 / inverse_inertia;
    let first = free_change(spin, inertia, inverse_inertia);
    let second = free_change(spin + 0.5 * dt * first, inertia, inverse_inertia);
    let third = free_change(spin + 0.5 * dt * second, inertia, inverse_inertia);
    let fourth = free_change(spin + dt * third, inertia, inverse_inertia);
    let next = spin + dt / 6.0 * (first + 2.0 * (second + third) + fourth);
    let found = dot(next, inertia * next);
    let usable = found > 0.0 && is_finite(bitcast<u32>(found));
    return select(spin, next * sqrt(dot(spin, inertia * spin) / found), usable);
}

// The smallest turn that brings `start` to the direction of `end`, for directions near each other.
fn aligning(start: vec3<f32>, end: vec3<f32>) -> vec4<f32> {
    let size = length(start) * length(end);
    let cosine = dot(start, end);
    let turn = unit_rotation(vec4(cross(start, end), size + cosine));
    return select(vec4(0.0, 0.0, 0.0, 1.0), turn, cosine > 0.5 * size);
}

// Orientation and angular velocity at the end.
struct End {
    rotation: vec4<f32>,
    spin: vec3<f32>,
}

fn end_of_compact(spin: vec3<f32>, turn: vec3<f32>, old: vec4<f32>, inverse_inertia: vec3<f32>) -> End {
    let momentum = rotate(old, rotate(conjugate(old), spin) / inverse_inertia);
    let ahead = spin_at(turned(old, turn), momentum, inverse_inertia);
    let next = turned(old, turn + 0.5 * sim.substep * (ahead - spin));
    return End(next, spin_at(next, momentum, inverse_inertia));
}

fn end_of_slender(
    before: vec3<f32>,
    world_spin: vec3<f32>,
    turn: vec3<f32>,
    old: vec4<f32>,
    inverse_inertia: vec3<f32>,
    touched: u32,
) -> End {
    let spin = rotate(conjugate(old), world_spin);
    let next = free_spin(spin, inverse_inertia);
    let ahead = rotate(turned(old, turn), next);
    let turned_on = turned(old, turn + 0.5 * sim.substep * (ahead - world_spin));
    let correction = aligning(rotate(turned_on, next / inverse_inertia), rotate(old, spin / inverse_inertia));
    let aligned = unit_rotation(compose(correction, turned_on));
    let is_fast = max(dot(world_spin, world_spin), dot(before, before)) > HIT_SPIN * HIT_SPIN;
    let rotation = select(turned_on, aligned, touched == 0u || (touched == 1u && is_fast));
    return End(rotation, rotate(rotation, next));
}

fn all_finite(v: vec3<f32>) -> bool {
    return is_finite(bitcast<u32>(v.x)) && is_finite(bitcast<u32>(v.y)) && is_finite(bitcast<u32>(v.z));
}

// Where a contact is at rest after a substep: deeper if it was pressed hard, and ever deeper if it is one of the
// `points` of a face.
fn yielded(gap: Gap, points: u32) -> f32 {
    let pressed = min(gap.rest, gap.found + RESTING_DEPTH);
    let sunk = select(pressed, pressed - RESTING_RATE * sim.substep, points > MAX_EDGE_POINTS);
    return max(sunk, -RESTING_DEPTH);
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let index = invocation(id, workgroups);
    let candidate = index / PATCH_LANES;
    if (candidate >= batch.candidates) {
        return;
    }
    let lane = index % PATCH_LANES;
    var finite = true;
    for (var body = lane; body < batch.bodies; body += PATCH_LANES) {
        if (bodies[body].unit == STATIC) {
            continue;
        }
        let i = candidate * batch.bodies + body;
        let row = candidate * (batch.bodies + 1u) + body;
        let state = moving[row];
        let frame = axes[row];
        let inverse_inertia = bodies[body].inverse_inertia;
        let old = poses[i].rotation;
        let at = poses[i].translation + state.shift;
        let spin = from_frame(frame, state.spin);
        let turn = from_frame(frame, state.turn);
        var end: End;
        if (is_slender(inverse_inertia)) {
            end = end_of_slender(velocities[i].angular, spin, turn, old, inverse_inertia, state.touched);
        } else {
            end = end_of_compact(spin, turn, old, inverse_inertia);
        }
        poses[i] = Pose(end.rotation, at);
        velocities[i] = Velocity(state.linear, end.spin);
        // A number that is not finite in the rotation is in the angular velocity, too.
        finite = finite && all_finite(at) && all_finite(state.linear) && all_finite(end.spin);
    }
    // More patches than the solver has room for, or was run for.
    let room = patch_rows(sim.contacts);
    let is_solved = cursors[candidate].step == sim.small_steps && patch_counts[candidate] <= room;
    let faults = select(STATUS_NOT_FINITE, 0u, finite) | select(STATUS_CONTACTS, 0u, is_solved);
    if (faults != 0u) {
        atomicOr(&statuses[candidate], faults);
    }
    let slots = candidate * sim.contacts;
    let patch_share = min(PATCH_LOAD_RATE * sim.substep, 1.0);
    let point_share = min(POINT_LOAD_RATE * sim.substep, 1.0);
    for (var p = lane; p < min(patch_counts[candidate], room); p += PATCH_LANES) {
        let i = slots + p;
        let friction = frictions[candidate * room + p];
        patches[i].friction = friction.impulse_u * friction.u + friction.impulse_v * friction.v;
        patches[i].twist = friction.impulse_twist;
        let first = slots + patches[i].first;
        let count = patches[i].count;
        let end = first + count;
        for (var k = 0u; k < count; k++) {
            let i = first + turn_of(k, count);
            contacts[i].impulse = normals[first + k].impulse;
            contacts[i].rest = yielded(gaps[first + k], count);
        }
        var mean = 0.0;
        for (var j = first; j < end; j++) {
            mean += excess(contacts[j]);
        }
        mean /= f32(count);
        for (var j = first; j < end; j++) {
            let own = excess(contacts[j]) - mean;
            contacts[j].load = contacts[j].load + patch_share * mean + point_share * own;
        }
    }
}
