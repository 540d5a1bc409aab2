// Kernel `solve_far`: as `solve`, one workgroup a candidate, for those that `solve_near` has left. What has too many
// bodies or patches for this, too, is left to `solve`. Part of `cpu::solve::Solver::substep`.

#import batch
#import contact
#import sim
#import solver

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> patch_counts: array<u32>;
@group(0) @binding(3) var<storage, read> patches: array<Patch>;
@group(0) @binding(4) var<storage, read> axes: array<Axes>;
@group(0) @binding(5) var<storage, read_write> free: array<Free>;
@group(0) @binding(6) var<storage, read_write> all_moving: array<Moving>;
@group(0) @binding(7) var<storage, read_write> frictions: array<Friction>;
@group(0) @binding(8) var<storage, read_write> normals: array<Normal>;
@group(0) @binding(9) var<storage, read_write> levers: array<Levers>;
@group(0) @binding(10) var<storage, read_write> gaps: array<Gap>;
@group(0) @binding(11) var<storage, read_write> cursors: array<Cursor>;

#import waves

@compute @workgroup_size(WAVE_LANES)
fn main(
    @builtin(local_invocation_index) lane: u32,
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    let candidate = workgroup.y * workgroups.x + workgroup.x;
    if (candidate >= batch.candidates) {
        return;
    }
    let room = patch_rows(sim.contacts);
    let count = patch_counts[candidate];
    let is_done = cursors[candidate].step >= sim.small_steps;
    if (is_done || batch.bodies >= WAVE_BODIES || count > min(WAVE_PATCHES, room)) {
        return;
    }
    wave_steps(lane, candidate, candidate * sim.contacts, candidate * room, count);
}
