// Kernel `axis_edges`: the edges along whose common normal two hulls are farthest apart, one invocation a hull pair.
//
// Twin of `cpu::narrow_phase::Twin`, its `best_edges`. The end of the search: what it finds, or what `axis_faces`
// or the last substep left, becomes the pair's axis.

#import constants
#import axis
#import batch
#import body
#import bounds
#import contact
#import frame
#import grid
#import hull
#import pose
#import preference
#import sim

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<uniform> preference: Preference;
@group(0) @binding(3) var<storage, read> bodies: array<Body>;
@group(0) @binding(4) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> hulls: array<Hull>;
@group(0) @binding(6) var<storage, read> balls: array<Ball>;
@group(0) @binding(7) var<storage, read> vertices: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> faces: array<Face>;
@group(0) @binding(9) var<storage, read> edges: array<Edge>;
@group(0) @binding(10) var<storage, read> poses: array<Pose>;
@group(0) @binding(11) var<storage, read> hull_boxes: array<Bounds>;
@group(0) @binding(12) var<storage, read> body_boxes: array<Bounds>;
@group(0) @binding(13) var<storage, read> pair_starts: array<u32>;
@group(0) @binding(14) var<storage, read_write> hull_pairs: array<HullPair>;
@group(0) @binding(15) var<storage, read_write> separations: array<Separation>;

#import lowest

// One bit an edge: a list of numbers would be too large for registers, and slow to compile.
const MASK_WORDS: u32 = (MAX_HULL_EDGES + 31u) / 32u;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let index = invocation(id, workgroups);
    if (index >= batch.candidates * sim.hull_pairs) {
        return;
    }
    let candidate = index / sim.hull_pairs;
    if (index % sim.hull_pairs >= pair_starts[(candidate + 1u) * (batch.pairs + 1u) - 1u]) {
        return;
    }
    var best = separations[index];
    if ((best.feature & UNSETTLED) == 0u) {
        return;
    }
    let pair = hull_pairs[index];
    let numbers = pairs[pair.pair];
    let at = numbers + candidate * batch.bodies;
    let boxes = array(body_boxes[at.x], body_boxes[at.y]);
    let margin = boxes[0].margin + boxes[1].margin;
    let last = bodies[batch.bodies - 1u];
    let row = candidate * (last.first_hull + last.hull_count);
    let room = vec2(
        room_under(boxes[0], hull_boxes[row + pair.b], bodies[numbers.y]),
        room_under(boxes[1], hull_boxes[row + pair.a], bodies[numbers.x]),
    );
    let to_a = between(poses[at.x], poses[at.y]);
    let a = hulls[pair.a];
    let b = hulls[pair.b];
    var least = worth_of(preference, room, best.normal, best.distance);
    least += preferred(preference, least);
    if ((best.feature & REMEMBERED) != 0u) {
        least = least_worth(preference, room, best);
    }

    // Edges of each hull that can carry an axis on which the other hull's ball reaches far enough.
    var masks: array<u32, 2u * MASK_WORDS>;
    for (var side = 0u; side < 2u; side++) {
        let on_b = side == 1u;
        let number = select(pair.a, pair.b, on_b);
        let hull = hulls[number];
        let ball = balls[select(pair.b, pair.a, on_b)];
        var frame = to_a;
        if (on_b) {
            frame = inverse(to_a);
        }
        let center = carried(frame, ball.center);
        let limit = ball.radius + least - balls[number].slack;
        for (var i = 0u; i < hull.edge_count; i++) {
            let sides = edges[hull.first_edge + i].faces;
            let plane_left = faces[hull.first_face + sides.x].plane;
            let plane_right = faces[hull.first_face + sides.y].plane;
            let left = dot(plane_left.xyz, center) - plane_left.w;
            let right = dot(plane_right.xyz, center) - plane_right.w;
            let cosine = dot(plane_left.xyz, plane_right.xyz);
            // The height over the arc between the two normals peaks inside the arc, or at one of its ends.
            let toward_left = left - cosine * right;
            let toward_right = right - cosine * left;
            let peak = toward_left > 0.0 && toward_right > 0.0
                && left * toward_left + right * toward_right > limit * limit * (1.0 - cosine * cosine);
            masks[side * MASK_WORDS + i / 32u] |= u32(max(left, right) > limit || peak) << (i % 32u);
        }
    }

    var found = Separation();
    // The face left over may be so near the margin that edges must beat more than it: only what is found ends the
    // search.
    var apart = false;
    for (var word_b = 0u; word_b < MASK_WORDS; word_b++) {
        for (var open_b = masks[MASK_WORDS + word_b]; open_b != 0u && !apart; open_b &= open_b - 1u) {
            let j = 32u * word_b + firstTrailingBit(open_b);
            let edge_b = edges[b.first_edge + j];
            let left_b = times(to_a.rotation, faces[b.first_face + edge_b.faces.x].plane.xyz);
            let right_b = times(to_a.rotation, faces[b.first_face + edge_b.faces.y].plane.xyz);
            let start_b = carried(to_a, vertices[b.first_vertex + edge_b.vertices.x].xyz);
            let along_b = unit(carried(to_a, vertices[b.first_vertex + edge_b.vertices.y].xyz) - start_b);
            for (var word_a = 0u; word_a < MASK_WORDS; word_a++) {
                for (var open_a = masks[word_a]; open_a != 0u && !apart; open_a &= open_a - 1u) {
                    let i = 32u * word_a + firstTrailingBit(open_a);
                    // The arcs left–right of A and of B, the latter turned round, must cross on the Gauss map.
                    let edge_a = edges[a.first_edge + i];
                    let start_a = vertices[a.first_vertex + edge_a.vertices.x].xyz;
                    // Of unit length as the twin's: where edges lie in faces, rounding decides on which side they are.
                    let along_a = unit(vertices[a.first_vertex + edge_a.vertices.y].xyz - start_a);
                    let left_side = dot(left_b, along_a);
                    if (left_side * dot(right_b, along_a) >= 0.0) {
                        continue;
                    }
                    let left_a = faces[a.first_face + edge_a.faces.x].plane.xyz;
                    let right_a = faces[a.first_face + edge_a.faces.y].plane.xyz;
                    let far_side = dot(along_b, right_a);
                    let across = cross(along_a, along_b);
                    let square = dot(across, across);
                    let size = sqrt(square);
                    let outward = select(1.0, -1.0, dot(across, left_a + right_a) < 0.0);
                    let usable = dot(along_b, left_a) * far_side < 0.0
                        && left_side * far_side < 0.0
                        && square >= PARALLEL_SINE * PARALLEL_SINE
                        && outward * dot(across, start_b - start_a) > least * size;
                    if (!usable) {
                        continue;
                    }
                    let axis = across * (outward / size);
                    // Nearly parallel edges leave the axis uncertain: only the vertices tell what it separates.
                    let distance = lowest(b, axis * to_a.rotation) + dot(axis, to_a.shift) + lowest(a, -axis);
                    let normal = rotate(poses[at.x].rotation, axis);
                    let worth = worth_of(preference, room, normal, distance);
                    if (worth > least) {
                        least = worth;
                        apart = distance > margin;
                        found = Separation(normal, distance, EDGES | i << 12u | j);
                    }
                }
            }
        }
    }

    best.feature &= ~(UNSETTLED | REMEMBERED);
    if (found.feature != 0u) {
        best = found;
    }
    hull_pairs[index].cache = best.feature;
    if (best.distance > margin) {
        best = Separation();
    }
    separations[index] = best;
}
