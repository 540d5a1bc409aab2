// A workgroup a candidate: patches that share no free body are solved at the same time. A patch waits for those before
// it that touch one of its bodies, and for no others, so that every body meets its patches in the same order as in
// `solve`, and the bits are the same. Import it below the bindings.

#import small_steps

const WAVE_LANES: u32 = 32u;

// What a candidate may have at most: bodies, the ground among them, and patches. Others are left to `solve`.
const WAVE_BODIES: u32 = 32u;
const WAVE_PATCHES: u32 = 64u;

// Card memory is ten times as far away, and every point waits for the one before.
var<workgroup> moving: array<Moving, WAVE_BODIES>;
var<workgroup> links: array<Link, WAVE_PATCHES>;

// The turns that a body's patches take up to now.
var<workgroup> taken: array<u32, WAVE_BODIES>;

// How many turns there are, there and back.
var<workgroup> turns: vec2<u32>;

var<workgroup> answer: atomic<u32>;

fn link_at(share: Share, p: u32) -> Link {
    return links[p];
}

fn is_due(share: Share, p: u32, turn: u32, backwards: bool) -> bool {
    return turn == select(links[p].turns.x, links[p].turns.y, backwards);
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

// The small steps of a candidate whose normals and friction begin at these rows, and everything else at `far`'s.
fn wave_steps(lane: u32, candidate: u32, slots: u32, rows: u32, count: u32) {
    let row = candidate * (batch.bodies + 1u);
    let far_slots = candidate * sim.contacts;
    let start = cursors[candidate];
    for (var body = lane; body <= batch.bodies; body += WAVE_LANES) {
        moving[body] = all_moving[row + body];
        taken[body] = 0u;
    }
    for (var p = lane; p < count; p += WAVE_LANES) {
        links[p] = link_of(patches[far_slots + p]);
    }
    workgroupBarrier();
    if (lane == 0u) {
        atomicStore(&answer, 0u);
        turns = arrange(count);
    }
    workgroupBarrier();
    let far_rows = candidate * patch_rows(sim.contacts);
    let end = small_steps(
        Share(lane, WAVE_LANES, 0u, slots, rows, row, far_slots, far_rows, count, turns),
        start,
        count,
    );
    workgroupBarrier();
    for (var body = lane; body <= batch.bodies; body += WAVE_LANES) {
        all_moving[row + body] = moving[body];
    }
    if (lane == 0u) {
        cursors[candidate] = end;
    }
}
