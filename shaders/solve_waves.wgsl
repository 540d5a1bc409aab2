// Kernel `solve_waves`: as `solve`, a workgroup a candidate, in which patches that share no free body are solved at the
// same time. A patch waits for those before it that touch one of its bodies, and for no others, so that every body meets
// its patches in the same order as in `solve`, and the bits are the same. Candidates that are too large are left to
// `solve`. Part of `cpu::solve::Solver::substep`.

#import batch
#import constants
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

#import small_steps

// Invocations of a workgroup: what cards run in step.
const WAVE_LANES: u32 = 32u;

// What a candidate may have at most: bodies, the ground among them, and patches, `LANE_PATCHES` an invocation.
const WAVE_BODIES: u32 = 32u;
const WAVE_PATCHES: u32 = 64u;
const LANE_PATCHES: u32 = 2u;

// Workgroup memory has what all invocations need and nothing else: it decides how many candidates are in flight.
var<workgroup> moving: array<Moving, WAVE_BODIES>;
var<workgroup> links: array<Link, WAVE_PATCHES>;

// Constraints of the invocation's own patches.
var<private> frictions: array<Friction, LANE_PATCHES>;
var<private> normals: array<Normal, LANE_PATCHES * MAX_MANIFOLD_POINTS>;

// Their turns: the first one's there and back, and the second one's.
var<private> own_turns: vec4<u32>;

// The turns that a body's patches take up to now.
var<workgroup> taken: array<u32, WAVE_BODIES>;

// How many turns there are, there and back.
var<workgroup> turns: vec2<u32>;

var<workgroup> answer: atomic<u32>;

fn link_at(share: Share, p: u32) -> Link {
    return links[p];
}

// Which of its invocation's patches this is.
fn own(p: u32) -> u32 {
    return p / WAVE_LANES;
}

fn friction_row(share: Share, p: u32) -> u32 {
    return own(p);
}

fn point_row(share: Share, p: u32, link: Link) -> u32 {
    return own(p) * MAX_MANIFOLD_POINTS;
}

fn is_due(share: Share, p: u32, turn: u32, backwards: bool) -> bool {
    let its = select(own_turns.xy, own_turns.zw, own(p) == 1u);
    return turn == select(its.x, its.y, backwards);
}

fn patch_in_order(share: Share, i: u32, backwards: bool) -> u32 {
    return i;
}

fn pause() {
    workgroupBarrier();
}

// True in all lanes if it is in one.
fn any_lane(yes: bool) -> bool {
    if (yes) {
        atomicStore(&answer, 1u);
    }
    workgroupBarrier();
    let any = atomicLoad(&answer) != 0u;
    workgroupBarrier();
    atomicStore(&answer, 0u);
    return any;
}

// The turn after those of these bodies.
fn take_turn(bodies: vec2<u32>) -> u32 {
    let is_free = vec2(moving[bodies.x].inverse_mass > 0.0, moving[bodies.y].inverse_mass > 0.0);
    let before = select(vec2(0u), vec2(taken[bodies.x], taken[bodies.y]), is_free);
    let turn = max(before.x, before.y);
    taken[bodies.x] = turn + 1u;
    taken[bodies.y] = turn + 1u;
    return turn;
}

// Gives so many patches their turns; there are as many as this says, there and back.
fn arrange(count: u32) -> vec2<u32> {
    var most = vec2(0u);
    for (var p = 0u; p < count; p++) {
        links[p].turns.x = take_turn(links[p].bodies);
        most.x = max(most.x, links[p].turns.x + 1u);
    }
    for (var body = 0u; body <= batch.bodies; body++) {
        taken[body] = 0u;
    }
    for (var i = 0u; i < count; i++) {
        let p = count - 1u - i;
        links[p].turns.y = take_turn(links[p].bodies);
        most.y = max(most.y, links[p].turns.y + 1u);
    }
    return most;
}

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
    let count = patch_counts[candidate];
    if (batch.bodies >= WAVE_BODIES || count > min(WAVE_PATCHES, patch_rows(sim.contacts))) {
        return;
    }
    let start = cursors[candidate];
    let row = candidate * (batch.bodies + 1u);
    let slots = candidate * sim.contacts;
    let rows = candidate * patch_rows(sim.contacts);
    for (var body = lane; body <= batch.bodies; body += WAVE_LANES) {
        moving[body] = all_moving[row + body];
        taken[body] = 0u;
    }
    for (var p = lane; p < count; p += WAVE_LANES) {
        let link = link_of(patches[slots + p]);
        links[p] = link;
        frictions[own(p)] = all_frictions[rows + p];
        for (var k = 0u; k < link.count; k++) {
            normals[own(p) * MAX_MANIFOLD_POINTS + k] = all_normals[slots + link.first + k];
        }
    }
    workgroupBarrier();
    if (lane == 0u) {
        atomicStore(&answer, 0u);
        turns = arrange(count);
    }
    workgroupBarrier();
    own_turns = vec4(links[lane].turns, links[lane + WAVE_LANES].turns);
    let end = small_steps(Share(lane, WAVE_LANES, 0u, row, slots, rows, count, turns), start, count);
    workgroupBarrier();
    for (var body = lane; body <= batch.bodies; body += WAVE_LANES) {
        all_moving[row + body] = moving[body];
    }
    for (var p = lane; p < count; p += WAVE_LANES) {
        all_frictions[rows + p] = frictions[own(p)];
        let link = links[p];
        for (var k = 0u; k < link.count; k++) {
            all_normals[slots + link.first + k] = normals[own(p) * MAX_MANIFOLD_POINTS + k];
        }
    }
    if (lane == 0u) {
        cursors[candidate] = end;
    }
}
