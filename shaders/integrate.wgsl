// Kernel `integrate`: writes a substep's motion into poses and velocities, and its impulses into the contacts, one
// invocation a candidate.
//
// Angular momentum, not angular velocity, is carried over to the new orientation; the turn is corrected to the mean of
// both velocities (Heun), or a tumbling body would gain energy. End of `cpu::solve::Solver::substep`.

#import constants
#import batch
#import body
#import contact
#import energy
#import grid
#import pose
#import sim
#import solver
#import status

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> bodies: array<Body>;
@group(0) @binding(3) var<storage, read> moving: array<Moving>;
@group(0) @binding(4) var<storage, read> patch_counts: array<u32>;
@group(0) @binding(5) var<storage, read> frictions: array<Friction>;
@group(0) @binding(6) var<storage, read> normals: array<Normal>;
@group(0) @binding(7) var<storage, read_write> patches: array<Patch>;
@group(0) @binding(8) var<storage, read_write> contacts: array<Contact>;
@group(0) @binding(9) var<storage, read_write> poses: array<Pose>;
@group(0) @binding(10) var<storage, read_write> velocities: array<Velocity>;
@group(0) @binding(11) var<storage, read_write> statuses: array<u32>;

fn turned(rotation: vec4<f32>, turn: vec3<f32>) -> vec4<f32> {
    return normalize(compose(from_scaled_axis(turn), rotation));
}

// Angular velocity of a body with this angular momentum.
fn spin_at(rotation: vec4<f32>, momentum: vec3<f32>, inverse_inertia: vec3<f32>) -> vec3<f32> {
    return rotate(rotation, rotate(conjugate(rotation), momentum) * inverse_inertia);
}

fn all_finite(v: vec3<f32>) -> bool {
    return is_finite(bitcast<u32>(v.x)) && is_finite(bitcast<u32>(v.y)) && is_finite(bitcast<u32>(v.z));
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let candidate = invocation(id, workgroups);
    if (candidate >= batch.candidates) {
        return;
    }
    var finite = true;
    for (var body = 0u; body < batch.bodies; body++) {
        if (bodies[body].unit == STATIC) {
            continue;
        }
        let i = candidate * batch.bodies + body;
        let state = moving[candidate * (batch.bodies + 1u) + body];
        let inverse_inertia = bodies[body].inverse_inertia;
        let old = poses[i].rotation;
        let momentum = rotate(old, rotate(conjugate(old), state.angular) / inverse_inertia);
        let ahead = spin_at(turned(old, state.turn), momentum, inverse_inertia);
        let next = turned(old, state.turn + 0.5 * sim.substep * (ahead - state.angular));
        let at = poses[i].translation + state.shift;
        let angular = spin_at(next, momentum, inverse_inertia);
        poses[i] = Pose(next, at);
        velocities[i] = Velocity(state.linear, angular);
        // A number that is not finite in the rotation is in the angular velocity, too.
        finite = finite && all_finite(at) && all_finite(state.linear) && all_finite(angular);
    }
    statuses[candidate] |= select(STATUS_NOT_FINITE, 0u, finite);
    let slots = candidate * sim.contacts;
    let patch_share = min(PATCH_LOAD_RATE * sim.substep, 1.0);
    let point_share = min(POINT_LOAD_RATE * sim.substep, 1.0);
    for (var i = slots; i < slots + min(patch_counts[candidate], sim.contacts); i++) {
        let impulse = frictions[i].impulse;
        let u = tangent(patches[i].normal);
        patches[i].friction = impulse.x * u + impulse.y * cross(patches[i].normal, u);
        patches[i].twist = impulse.z;
        let first = slots + patches[i].first;
        let end = first + patches[i].count;
        var mean = 0.0;
        for (var j = first; j < end; j++) {
            mean += normals[j].impulse - normals[j].load;
        }
        mean /= f32(patches[i].count);
        for (var j = first; j < end; j++) {
            contacts[j].impulse = normals[j].impulse;
            let own = normals[j].impulse - normals[j].load - mean;
            contacts[j].load = normals[j].load + patch_share * mean + point_share * own;
        }
    }
}
