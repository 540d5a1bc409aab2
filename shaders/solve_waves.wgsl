// Kernel `solve_waves`: as `solve`, one workgroup a candidate, for cards: patches that share no free body are solved at the
// same time. A patch waits for those before it that touch one of its bodies, and for no others, so that every body meets its
// patches in the same order as in `solve`, and the bits are the same.

#import batch
#import contact
#import sim
#import solver

const WAVE_LANES: u32 = 32u;

// More bodies of a candidate, the ground among them, are for `solve`.
const MOST_BODIES: u32 = 48u;

// With more patches than these all take their turns one by one.
const MOST_PATCHES: u32 = 128u;

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> patch_counts: array<u32>;
@group(0) @binding(3) var<storage, read> patches: array<Patch>;
@group(0) @binding(4) var<storage, read> axes: array<Axes>;
@group(0) @binding(5) var<storage, read_write> free: array<Free>;
@group(0) @binding(6) var<storage, read_write> bodies: array<Moving>;
@group(0) @binding(7) var<storage, read_write> frictions: array<Friction>;
@group(0) @binding(8) var<storage, read_write> normals: array<Normal>;
@group(0) @binding(9) var<storage, read_write> cursors: array<Cursor>;

var<workgroup> moving: array<Moving, MOST_BODIES>;

// What a patch waits for: others of its bodies.
struct Link {
    bodies: vec2<u32>,
    // Its turn in a sweep there, and in one back.
    there: u32,
    back: u32,
}

var<workgroup> links: array<Link, MOST_PATCHES>;

// The turns that a body's patches take up to now.
var<workgroup> taken: array<u32, MOST_BODIES>;

// How many turns there are, there and back.
var<workgroup> turns: vec2<u32>;

var<workgroup> answer: atomic<u32>;

#import small_steps

fn is_due(share: Share, p: u32, turn: u32, backwards: bool) -> bool {
    let link = links[min(p, MOST_PATCHES - 1u)];
    let wave = select(vec2(link.there, link.back), vec2(p, share.patches - 1u - p), share.patches > MOST_PATCHES);
    return turn == select(wave.x, wave.y, backwards);
}

fn in_order(i: u32, count: u32, backwards: bool) -> u32 {
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

// Gives all patches their turns.
fn arrange(lane: u32, slots: u32, count: u32) {
    for (var p = lane; p < count; p += WAVE_LANES) {
        links[p].bodies = bodies_of(patches[slots + p]);
    }
    for (var body = lane; body <= batch.bodies; body += WAVE_LANES) {
        taken[body] = 0u;
    }
    workgroupBarrier();
    if (lane == 0u) {
        var most = vec2(0u);
        for (var p = 0u; p < count; p++) {
            links[p].there = take_turn(links[p].bodies);
            most.x = max(most.x, links[p].there + 1u);
        }
        for (var body = 0u; body <= batch.bodies; body++) {
            taken[body] = 0u;
        }
        for (var i = 0u; i < count; i++) {
            let p = count - 1u - i;
            links[p].back = take_turn(links[p].bodies);
            most.y = max(most.y, links[p].back + 1u);
        }
        turns = most;
    }
    workgroupBarrier();
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
    let row = candidate * (batch.bodies + 1u);
    let slots = candidate * sim.contacts;
    let room = patch_rows(sim.contacts);
    let count = min(patch_counts[candidate], room);
    let start = cursors[candidate];
    for (var body = lane; body <= batch.bodies; body += WAVE_LANES) {
        moving[body] = bodies[row + body];
    }
    if (lane == 0u) {
        atomicStore(&answer, 0u);
        turns = vec2(count);
    }
    workgroupBarrier();
    if (count <= MOST_PATCHES) {
        arrange(lane, slots, count);
    }
    let share = Share(lane, WAVE_LANES, 0u, row, slots, candidate * room, count, turns);
    let end = small_steps(share, start, count);
    workgroupBarrier();
    for (var body = lane; body <= batch.bodies; body += WAVE_LANES) {
        bodies[row + body] = moving[body];
    }
    if (lane == 0u) {
        cursors[candidate] = end;
    }
}
