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

// So many patches are near at hand. With more all take their turns one by one.
const NEAR_PATCHES: u32 = 32u;

// So many contact points are.
const NEAR_POINTS: u32 = 96u;

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

// The first patches and points: card memory is ten times as far away, and every point waits for the one before.
var<workgroup> links: array<Link, NEAR_PATCHES>;
var<workgroup> near_frictions: array<Friction, NEAR_PATCHES>;
var<workgroup> near_normals: array<Normal, NEAR_POINTS>;

// The turns that a body's patches take up to now.
var<workgroup> taken: array<u32, MOST_BODIES>;

// How many turns there are, there and back.
var<workgroup> turns: vec2<u32>;

var<workgroup> answer: atomic<u32>;

#import small_steps

fn link_at(share: Share, p: u32) -> Link {
    if (p < NEAR_PATCHES) {
        return links[p];
    }
    return link_of(patches[share.slots + p]);
}

fn friction_at(share: Share, p: u32) -> Friction {
    if (p < NEAR_PATCHES) {
        return near_frictions[p];
    }
    return frictions[share.rows + p];
}

fn set_friction(share: Share, p: u32, friction: Friction) {
    if (p < NEAR_PATCHES) {
        near_frictions[p] = friction;
    } else {
        frictions[share.rows + p] = friction;
    }
}

fn set_friction_impulse(share: Share, p: u32, impulse: vec3<f32>) {
    if (p < NEAR_PATCHES) {
        near_frictions[p].impulse = impulse;
    } else {
        frictions[share.rows + p].impulse = impulse;
    }
}

fn set_limits(share: Share, p: u32, limits: vec2<f32>) {
    if (p < NEAR_PATCHES) {
        near_frictions[p].limit = limits.x;
        near_frictions[p].twist_limit = limits.y;
    } else {
        frictions[share.rows + p].limit = limits.x;
        frictions[share.rows + p].twist_limit = limits.y;
    }
}

fn normal_at(share: Share, j: u32) -> Normal {
    if (j < NEAR_POINTS) {
        return near_normals[j];
    }
    return normals[share.slots + j];
}

fn set_normal(share: Share, j: u32, normal: Normal) {
    if (j < NEAR_POINTS) {
        near_normals[j] = normal;
    } else {
        normals[share.slots + j] = normal;
    }
}

fn set_impulse(share: Share, j: u32, impulse: f32) {
    if (j < NEAR_POINTS) {
        near_normals[j].impulse = impulse;
    } else {
        normals[share.slots + j].impulse = impulse;
    }
}

fn is_due(share: Share, p: u32, turn: u32, backwards: bool) -> bool {
    let link = links[min(p, NEAR_PATCHES - 1u)];
    let turns = select(link.turns, vec2(p, share.patches - 1u - p), share.patches > NEAR_PATCHES);
    return turn == select(turns.x, turns.y, backwards);
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

// Gives all patches their turns, if they are near; there and back there are as many as this says.
fn arrange(count: u32) -> vec2<u32> {
    if (count > NEAR_PATCHES) {
        return vec2(count);
    }
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
    let row = candidate * (batch.bodies + 1u);
    let slots = candidate * sim.contacts;
    let room = patch_rows(sim.contacts);
    let count = min(patch_counts[candidate], room);
    let near = min(count, NEAR_PATCHES);
    let last = patches[slots + max(count, 1u) - 1u];
    let points = min(select(last.first + last.count, 0u, count == 0u), NEAR_POINTS);
    let start = cursors[candidate];
    for (var body = lane; body <= batch.bodies; body += WAVE_LANES) {
        moving[body] = bodies[row + body];
        taken[body] = 0u;
    }
    for (var p = lane; p < near; p += WAVE_LANES) {
        links[p] = link_of(patches[slots + p]);
        near_frictions[p] = frictions[candidate * room + p];
    }
    for (var j = lane; j < points; j += WAVE_LANES) {
        near_normals[j] = normals[slots + j];
    }
    workgroupBarrier();
    if (lane == 0u) {
        atomicStore(&answer, 0u);
        turns = arrange(count);
    }
    workgroupBarrier();
    let share = Share(lane, WAVE_LANES, 0u, row, slots, candidate * room, count, turns);
    let end = small_steps(share, start, count);
    workgroupBarrier();
    for (var body = lane; body <= batch.bodies; body += WAVE_LANES) {
        bodies[row + body] = moving[body];
    }
    for (var p = lane; p < near; p += WAVE_LANES) {
        frictions[candidate * room + p] = near_frictions[p];
    }
    for (var j = lane; j < points; j += WAVE_LANES) {
        normals[slots + j] = near_normals[j];
    }
    if (lane == 0u) {
        cursors[candidate] = end;
    }
}
