// Kernel `aligned_faces`: which face of which hull the contacts of a hull pair are clipped against, one invocation a
// slot of a hull pair. First part of `cpu::narrow_phase::manifold`.

#import batch
#import bounds
#import constants
#import contact
#import facing
#import grid
#import hull
#import pose
#import sim
#import vector

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> hulls: array<Hull>;
@group(0) @binding(3) var<storage, read> faces: array<Face>;
@group(0) @binding(4) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> poses: array<Pose>;
@group(0) @binding(6) var<storage, read> body_boxes: array<Bounds>;
@group(0) @binding(7) var<storage, read> hull_pairs: array<HullPair>;
@group(0) @binding(8) var<storage, read> pair_starts: array<u32>;
@group(0) @binding(9) var<storage, read> separations: array<Separation>;
@group(0) @binding(10) var<storage, read_write> facings: array<Facing>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let index = invocation(id, workgroups);
    if (index >= batch.candidates * sim.hull_pairs) {
        return;
    }
    let candidate = index / sim.hull_pairs;
    let listed = pair_starts[candidate * (batch.pairs + 1u) + batch.pairs];
    if (index % sim.hull_pairs >= listed || separations[index].feature == 0u) {
        facings[index].side = NO_CONTACT;
        return;
    }
    let axis = separations[index].normal;
    let bodies = pairs[hull_pairs[index].pair];
    let pair = vec2(hull_pairs[index].a, hull_pairs[index].b);
    let row = candidate * batch.bodies;
    var best = vec2(0u);
    var cosines = vec2(-2.0);
    var radii = vec2(0.0);
    for (var side = 0u; side < 2u; side++) {
        let outward = select(-axis, axis, side == 0u);
        let direction = rotate(conjugate(poses[row + bodies[side]].rotation), outward);
        let hull = hulls[pair[side]];
        radii[side] = hull.radius;
        var high = -2.0;
        var nearest = 0u;
        for (var i = 0u; i < hull.face_count; i++) {
            let cosine = plane_cosine(direction, faces[hull.first_face + i].plane);
            nearest = select(nearest, i, cosine > high);
            high = max(high, cosine);
        }
        best[side] = nearest;
        cosines[side] = high;
    }
    // The larger hull is preferred, so that a book lies on the table and not the table on the book.
    let larger = select(0u, 1u, radii.y > radii.x);
    let smaller = 1u - larger;
    let reference = select(larger, smaller, cosines[smaller] > cosines[larger] + ALIGNED_BIAS);
    let side = select(reference, NO_FACE, max(cosines.x, cosines.y) < ALIGNED_COSINE);
    let margin = body_boxes[row + bodies.x].margin + body_boxes[row + bodies.y].margin;
    facings[index] = Facing(bodies, pair, vec2(best[reference], best[1u - reference]), side, margin);
}
