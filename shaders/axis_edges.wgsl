// Kernel `axis_edges`: the edges along whose common normal two hulls are farthest apart, one invocation a hull pair.
//
// Twin of `Frame::best_edges` in `src/cpu/narrow_phase/twin.rs`. The end of the search: what it finds, or what `axis_faces`
// or the last substep left, becomes the pair's axis.

#import constants
#import axis
#import batch
#import bounds
#import contact
#import frame
#import grid
#import hull
#import pose
#import sim

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<uniform> preference: Preference;
@group(0) @binding(3) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> hulls: array<Hull>;
@group(0) @binding(5) var<storage, read> balls: array<Ball>;
@group(0) @binding(6) var<storage, read> vertices: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read> faces: array<Face>;
@group(0) @binding(8) var<storage, read> edges: array<Edge>;
@group(0) @binding(9) var<storage, read> poses: array<Pose>;
@group(0) @binding(10) var<storage, read> body_boxes: array<Bounds>;
@group(0) @binding(11) var<storage, read> pair_starts: array<u32>;
@group(0) @binding(12) var<storage, read_write> hull_pairs: array<HullPair>;
@group(0) @binding(13) var<storage, read_write> separations: array<Separation>;

#import lowest

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
    let bodies = pairs[pair.pair] + candidate * batch.bodies;
    let margin = body_boxes[bodies.x].margin + body_boxes[bodies.y].margin;
    let to_a = between(poses[bodies.x], poses[bodies.y]);
    let a = hulls[pair.a];
    let b = hulls[pair.b];
    var least = best.distance + preferred(preference, best.distance);
    if ((best.feature & REMEMBERED) != 0u) {
        least = least_distance(preference, best);
    }

    // Edges of each hull that can carry an axis on which the other hull's ball reaches far enough.
    var list: array<u32, 2u * MAX_HULL_EDGES>;
    var counts = vec2(0u);
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
        var count = 0u;
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
            list[side * MAX_HULL_EDGES + count] = i;
            count += u32(max(left, right) > limit || peak);
        }
        counts[side] = count;
    }

    var normal = vec3(0.0);
    var found = 0u;
    for (var n = 0u; n < counts.y && least <= margin; n++) {
        let j = list[MAX_HULL_EDGES + n];
        let edge_b = edges[b.first_edge + j];
        let left_b = to_a.rotation * faces[b.first_face + edge_b.faces.x].plane.xyz;
        let right_b = to_a.rotation * faces[b.first_face + edge_b.faces.y].plane.xyz;
        let start_b = carried(to_a, vertices[b.first_vertex + edge_b.vertices.x].xyz);
        let along_b = normalize(carried(to_a, vertices[b.first_vertex + edge_b.vertices.y].xyz) - start_b);
        for (var m = 0u; m < counts.x && least <= margin; m++) {
            let i = list[m];
            let edge_a = edges[a.first_edge + i];
            let start_a = vertices[a.first_vertex + edge_a.vertices.x].xyz;
            let along_a = normalize(vertices[a.first_vertex + edge_a.vertices.y].xyz - start_a);
            let left_a = faces[a.first_face + edge_a.faces.x].plane.xyz;
            let right_a = faces[a.first_face + edge_a.faces.y].plane.xyz;
            // The arcs left–right of A and of B, the latter turned round, must cross on the Gauss map.
            let left_side = dot(left_b, along_a);
            let right_side = dot(right_b, along_a);
            let near_side = dot(along_b, left_a);
            let far_side = dot(along_b, right_a);
            let across = cross(along_a, along_b);
            let square = dot(across, across);
            let outward = select(1.0, -1.0, dot(across, left_a + right_a) < 0.0);
            let size = sqrt(square);
            let crossing = left_side * right_side < 0.0 && near_side * far_side < 0.0 && left_side * far_side < 0.0;
            let usable = square >= PARALLEL_SINE * PARALLEL_SINE
                && outward * dot(across, start_b - start_a) > least * size;
            if (!(crossing && usable)) {
                continue;
            }
            let axis = across * (outward / size);
            // Nearly parallel edges leave the axis uncertain: only the vertices tell what it separates.
            let distance = lowest(b, axis * to_a.rotation) + dot(axis, to_a.shift) + lowest(a, -axis);
            if (distance > least) {
                least = distance;
                normal = axis;
                found = EDGES | i << 12u | j;
            }
        }
    }

    best.feature &= ~(UNSETTLED | REMEMBERED);
    if (found != 0u) {
        best = Separation(rotate(poses[bodies.x].rotation, normal), least, found);
    }
    hull_pairs[index].cache = best.feature;
    if (best.distance > margin) {
        best = Separation();
    }
    separations[index] = best;
}
