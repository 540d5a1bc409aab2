// Kernel `solve_load`: rows of all patches and points at the start of a substep; 32 invocations share a candidate's
// patches. Part of `cpu::solve::Solver::substep`.

#import batch
#import constants
#import contact
#import grid
#import pose
#import sim
#import solver

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> poses: array<Pose>;
@group(0) @binding(3) var<storage, read> moving: array<Moving>;
@group(0) @binding(4) var<storage, read> axes: array<Axes>;
@group(0) @binding(5) var<storage, read> patch_counts: array<u32>;
@group(0) @binding(6) var<storage, read> patches: array<Patch>;
@group(0) @binding(7) var<storage, read> contacts: array<Contact>;
@group(0) @binding(8) var<storage, read_write> frictions: array<Friction>;
@group(0) @binding(9) var<storage, read_write> normals: array<Normal>;
@group(0) @binding(10) var<storage, read_write> levers: array<Levers>;
@group(0) @binding(11) var<storage, read_write> gaps: array<Gap>;
@group(0) @binding(12) var<storage, read_write> cursors: array<Cursor>;

#import aim

// Where the patch carries its load: the mean of its points, weighted by their last impulses; unweighted at first.
fn center_of_pressure(first: u32, count: u32) -> vec3<f32> {
    var total = 0.0;
    var sum = vec3(0.0);
    var weighted = vec3(0.0);
    for (var i = first; i < first + count; i++) {
        let point = contacts[i].point;
        let impulse = contacts[i].impulse;
        total += impulse;
        sum += point;
        weighted += impulse * point;
    }
    return select(sum / f32(count), weighted / total, total > 0.0);
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let index = invocation(id, workgroups);
    let candidate = index / PATCH_LANES;
    if (candidate >= batch.candidates) {
        return;
    }
    if (index % PATCH_LANES == 0u) {
        cursors[candidate] = Cursor();
    }
    let slots = candidate * sim.contacts;
    let rows = patch_rows(sim.contacts);
    let first_body = candidate * batch.bodies;
    let first_moving = candidate * (batch.bodies + 1u);
    for (var i = index % PATCH_LANES; i < min(patch_counts[candidate], rows); i += PATCH_LANES) {
        let at = patches[slots + i];
        let grounded = at.a == GROUND;
        let row_a = first_moving + select(at.a, batch.bodies, grounded);
        let row_b = first_moving + at.b;
        let a = matrix_of(axes[row_a]);
        let b = matrix_of(axes[row_b]);
        let inverse_mass = moving[row_a].inverse_mass + moving[row_b].inverse_mass;
        let origin_a = select(poses[first_body + select(at.a, 0u, grounded)].translation, vec3(0.0), grounded);
        let origin_b = poses[first_body + at.b].translation;
        let first = slots + at.first;
        let center = center_of_pressure(first, at.count);
        var friction = Friction();
        friction.u = tangent(at.normal);
        friction.v = cross(at.normal, friction.u);
        let center_arms = Arms(center - origin_a, center - origin_b);
        levers[candidate * rows + i] = Levers(center_arms, vec3(0.0), vec3(0.0), vec3(0.0));
        aim_friction(&friction, center_arms, a, b, inverse_mass);
        friction.twist_a = times(a, at.normal);
        friction.twist_b = times(b, at.normal);
        friction.mass_twist =
            inverse_of(dot(friction.twist_a, friction.twist_a) + dot(friction.twist_b, friction.twist_b));
        friction.impulse_u = dot(at.friction, friction.u);
        friction.impulse_v = dot(at.friction, friction.v);
        friction.impulse_twist = at.twist;
        for (var k = 0u; k < at.count; k++) {
            let contact = contacts[first + turn_of(k, at.count)];
            let arms = Arms(contact.point - origin_a, contact.point - origin_b);
            let row = row_along(contact.normal, arms, a, b);
            let lever = distance(contact.point, center);
            let separation = contact.separation - sim.rest_offset;
            let met = clamp(separation, -RESTING_DEPTH, -LEAST_RESTING_DEPTH);
            var normal = Normal();
            normal.axis = row.axis;
            normal.mass = mass_of(row, inverse_mass);
            normal.torque_a = row.torque_a;
            normal.torque_b = row.torque_b;
            normal.lever = lever;
            normal.impulse = contact.impulse;
            normal.load = contact.load;
            let gap = Gap(arms, separation, separation, select(met, contact.rest, contact.rest < 0.0));
            aim(&normal, gap.start, gap.rest);
            normals[first + k] = normal;
            gaps[first + k] = gap;
            friction.limit += contact.impulse;
            friction.twist_limit += contact.impulse * lever;
        }
        friction.limit *= sim.friction;
        friction.twist_limit *= sim.friction;
        frictions[candidate * rows + i] = friction;
    }
}
