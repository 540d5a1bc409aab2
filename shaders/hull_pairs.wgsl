// Kernel `hull_pairs`: lists the hulls that may touch, one invocation a candidate and body pair.
//
// Every hull pair goes on with the axis that it had in the last substep's list, which is in the same order. Part of
// `cpu::broad_phase::BroadPhase::pairs`.

#import batch
#import body
#import bounds
#import contact
#import grid
#import sim

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> bodies: array<Body>;
@group(0) @binding(3) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> hull_boxes: array<Bounds>;
@group(0) @binding(5) var<storage, read> body_boxes: array<Bounds>;
@group(0) @binding(6) var<storage, read> pair_starts: array<u32>;
@group(0) @binding(7) var<storage, read> old_starts: array<u32>;
@group(0) @binding(8) var<storage, read> old_pairs: array<HullPair>;
@group(0) @binding(9) var<storage, read_write> hull_pairs: array<HullPair>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let index = invocation(id, workgroups);
    if (index >= batch.candidates * batch.pairs) {
        return;
    }
    let candidate = index / batch.pairs;
    let number = index % batch.pairs;
    // A row of starts is longer by one.
    let at = index + candidate;
    var slot = pair_starts[at];
    let end = min(pair_starts[at + 1u], sim.hull_pairs);
    if (slot >= end) {
        return;
    }
    let slots = candidate * sim.hull_pairs;
    var old = slots + old_starts[at];
    let old_end = slots + min(old_starts[at + 1u], sim.hull_pairs);

    let pair = pairs[number];
    let a = bodies[pair.x];
    let b = bodies[pair.y];
    let box_b = body_boxes[candidate * batch.bodies + pair.y];
    let margin = body_boxes[candidate * batch.bodies + pair.x].margin + box_b.margin;
    let last = bodies[batch.bodies - 1u];
    let row = candidate * (last.first_hull + last.hull_count);
    for (var i = a.first_hull; i < a.first_hull + a.hull_count; i++) {
        let hull = hull_boxes[row + i];
        if (!overlaps(hull, box_b, margin)) {
            continue;
        }
        for (var j = b.first_hull; j < b.first_hull + b.hull_count && slot < end; j++) {
            if (!overlaps(hull, hull_boxes[row + j], margin)) {
                continue;
            }
            var cache = 0u;
            for (var o = old; o < old_end; o++) {
                let known = old_pairs[o];
                cache = select(0u, known.cache, known.a == i && known.b == j);
                if (known.a > i || (known.a == i && known.b >= j)) {
                    break;
                }
                old = o + 1u;
            }
            hull_pairs[slots + slot] = HullPair(number, i, j, cache);
            slot++;
        }
    }
}
