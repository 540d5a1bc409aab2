// Kernel `solve_near`: as `solve`, one workgroup a candidate, all that the sweeps need in workgroup memory. Candidates
// with too much for that are left to `solve_far`. Part of `cpu::solve::Solver::substep`.

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
@group(0) @binding(7) var<storage, read_write> all_frictions: array<Friction>;
@group(0) @binding(8) var<storage, read_write> all_normals: array<Normal>;
@group(0) @binding(9) var<storage, read_write> levers: array<Levers>;
@group(0) @binding(10) var<storage, read_write> gaps: array<Gap>;
@group(0) @binding(11) var<storage, read_write> cursors: array<Cursor>;

#import waves

const NEAR_PATCHES: u32 = 32u;
const NEAR_POINTS: u32 = 128u;

var<workgroup> frictions: array<Friction, NEAR_PATCHES>;
var<workgroup> normals: array<Normal, NEAR_POINTS>;

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
    let slots = candidate * sim.contacts;
    let count = patch_counts[candidate];
    let last = patches[slots + max(count, 1u) - 1u];
    let points = select(last.first + last.count, 0u, count == 0u);
    if (batch.bodies >= WAVE_BODIES || count > min(NEAR_PATCHES, room) || points > NEAR_POINTS) {
        return;
    }
    for (var p = lane; p < count; p += WAVE_LANES) {
        frictions[p] = all_frictions[candidate * room + p];
    }
    for (var j = lane; j < points; j += WAVE_LANES) {
        normals[j] = all_normals[slots + j];
    }
    wave_steps(lane, candidate, 0u, 0u, count);
    for (var p = lane; p < count; p += WAVE_LANES) {
        all_frictions[candidate * room + p] = frictions[p];
    }
    for (var j = lane; j < points; j += WAVE_LANES) {
        all_normals[slots + j] = normals[j];
    }
}
