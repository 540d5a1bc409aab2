// Kernel `solve_bodies`: bodies at the start of a substep, one invocation a body; the last of a candidate is the
// ground. Part of `cpu::solve::Solver::substep`.

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
@group(0) @binding(5) var<storage, read_write> axes: array<Axes>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let index = invocation(id, workgroups);
    let row = batch.bodies + 1u;
    if (index >= batch.candidates * row) {
        return;
    }
    let body = index % row;
    var state = Moving();
    var frame = Axes();
    if (body < batch.bodies) {
        let i = index / row * batch.bodies + body;
        let back = transpose(matrix(poses[i].rotation));
        let inverse_inertia = bodies[body].inverse_inertia;
        let root = sqrt(inverse_inertia);
        state.linear = velocities[i].linear;
        state.inverse_mass = bodies[body].inverse_mass;
        let round = round_axes(inverse_inertia);
        frame = Axes(root * back[0], round.x, root * back[1], round.y, root * back[2], round.z);
        if (state.inverse_mass > 0.0) {
            state.spin = times(matrix_of(frame), velocities[i].angular) / inverse_inertia;
        }
    }
    moving[index] = state;
    axes[index] = frame;
}
