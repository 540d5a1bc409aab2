// Kernel `pair_counts`: how many hulls of each body pair may touch, one invocation a candidate and pair; none of pairs
// that keep their contacts.
//
// With `pair_starts` and `hull_pairs` the twin of `cpu::broad_phase::BroadPhase::pairs`.

#import batch
#import body
#import bounds
#import grid

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<storage, read> bodies: array<Body>;
@group(0) @binding(2) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> hull_boxes: array<Bounds>;
@group(0) @binding(4) var<storage, read> body_boxes: array<Bounds>;
@group(0) @binding(5) var<storage, read_write> pair_counts: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let index = invocation(id, workgroups);
    if (index >= batch.candidates * batch.pairs) {
        return;
    }
    let candidate = index / batch.pairs;
    let pair = pairs[index % batch.pairs];
    let box_a = body_boxes[candidate * batch.bodies + pair.x];
    let box_b = body_boxes[candidate * batch.bodies + pair.y];
    let margin = box_a.margin + box_b.margin;
    var count = 0u;
    if (!keep(box_a, box_b) && overlaps(box_a, box_b, margin)) {
        let last = bodies[batch.bodies - 1u];
        let row = candidate * (last.first_hull + last.hull_count);
        let a = bodies[pair.x];
        let b = bodies[pair.y];
        for (var i = a.first_hull; i < a.first_hull + a.hull_count; i++) {
            let hull = hull_boxes[row + i];
            if (overlaps(hull, box_b, margin)) {
                for (var j = b.first_hull; j < b.first_hull + b.hull_count; j++) {
                    count += u32(overlaps(hull, hull_boxes[row + j], margin));
                }
            }
        }
    }
    pair_counts[index] = count;
}
