// Kernel `solve_bodies`: bodies at the start of a substep, one invocation a body; the last of a candidate is the ground.
// Part of `cpu::solve::Solver::substep`.

#import batch
#import body
#import frame
#import grid
#import pose
#import solver

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<storage, read> bodies: array<Body>;
@group(0) @binding(2) var<storage, read> poses: array<Pose>;
@group(0) @binding(3) var<storage, read> velocities: array<Velocity>;
@group(0) @binding(4) var<storage, read_write> moving: array<Moving>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let index = invocation(id, workgroups);
    let row = batch.bodies + 1u;
    if (index >= batch.candidates * row) {
        return;
    }
    let body = index % row;
    var state = Moving();
    if (body < batch.bodies) {
        let i = index / row * batch.bodies + body;
        let turn = matrix(poses[i].rotation);
        let d = bodies[body].inverse_inertia;
        let scaled = mat3x3(turn[0] * d.x, turn[1] * d.y, turn[2] * d.z);
        let back = transpose(turn);
        state.linear = velocities[i].linear;
        state.angular = velocities[i].angular;
        state.inverse_mass = bodies[body].inverse_mass;
        state.inertia_x = times(scaled, back[0]);
        state.inertia_y = times(scaled, back[1]);
        state.inertia_z = times(scaled, back[2]);
    }
    moving[index] = state;
}
