// Kernel `solve`: the small steps of a substep, one invocation a candidate, patch after patch. It is run again until
// all are done: Mesa's software driver ends every loop once those of an invocation have gone round 65,535 times,
// without a word.

#import batch
#import contact
#import grid
#import sim
#import solver

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> patch_counts: array<u32>;
@group(0) @binding(3) var<storage, read> patches: array<Patch>;
@group(0) @binding(4) var<storage, read> axes: array<Axes>;
@group(0) @binding(5) var<storage, read_write> free: array<Free>;
@group(0) @binding(6) var<storage, read_write> moving: array<Moving>;
@group(0) @binding(7) var<storage, read_write> frictions: array<Friction>;
@group(0) @binding(8) var<storage, read_write> normals: array<Normal>;
@group(0) @binding(9) var<storage, read_write> levers: array<Levers>;
@group(0) @binding(10) var<storage, read_write> gaps: array<Gap>;
@group(0) @binding(11) var<storage, read_write> cursors: array<Cursor>;

#import company
#import small_steps

fn link_at(share: Share, p: u32) -> Link {
    return link_of(patches[share.far_slots + p]);
}

fn is_due(share: Share, p: u32, turn: u32, backwards: bool) -> bool {
    return true;
}

fn patch_in_order(share: Share, i: u32, backwards: bool) -> u32 {
    return in_order(i, share.patches, backwards);
}

fn friction_row(share: Share, p: u32) -> u32 {
    return share.far_rows + p;
}

fn point_row(share: Share, p: u32, link: Link) -> u32 {
    return share.far_slots + link.first;
}

fn pause() {}

fn any_lane(yes: bool) -> bool {
    return yes;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let candidate = invocation(id, workgroups);
    let patches = patches_of(candidate, lane);
    if (candidate >= batch.candidates) {
        return;
    }
    let bodies = candidate * (batch.bodies + 1u);
    let slots = candidate * sim.contacts;
    let rows = candidate * patch_rows(sim.contacts);
    let share = Share(0u, 1u, bodies, bodies, slots, rows, patches.x, vec2(1u));
    cursors[candidate] = small_steps(share, cursors[candidate], patches.y);
}
