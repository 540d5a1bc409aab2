// Kernel `axis_faces`: the face along whose normal two hulls are farthest apart, one invocation a hull pair.
//
// Twin of `cpu::narrow_phase::Twin`, its `best_face`: faces in the same order, all in A's frame.

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
@group(0) @binding(9) var<storage, read> poses: array<Pose>;
@group(0) @binding(10) var<storage, read> hull_boxes: array<Bounds>;
@group(0) @binding(11) var<storage, read> body_boxes: array<Bounds>;
@group(0) @binding(12) var<storage, read> pair_starts: array<u32>;
@group(0) @binding(13) var<storage, read_write> hull_pairs: array<HullPair>;
@group(0) @binding(14) var<storage, read_write> separations: array<Separation>;

#import lowest

// A plane of A's, or one of B's carried into A's frame.
fn plane_in_a(plane: vec4<f32>, to_a: Frame, on_b: bool) -> vec4<f32> {
    let normal = times(to_a.rotation, plane.xyz);
    return select(plane, vec4(normal, plane.w + dot(normal, to_a.shift)), on_b);
}

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
    let known = separations[index];
    if ((known.feature & UNSETTLED) == 0u) {
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
    let larger = u32(hulls[pair.b].radius > hulls[pair.a].radius);

    var best = Separation(vec3(0.0), 0.0, 0u);
    var worth = least_worth(preference, room, known);
    for (var turn = 0u; turn < 2u && best.distance <= margin; turn++) {
        let on_b = (larger ^ turn) == 1u;
        let hull = hulls[select(pair.a, pair.b, on_b)];
        let other = hulls[select(pair.b, pair.a, on_b)];
        let ball = balls[select(pair.b, pair.a, on_b)];
        let center = select(carried(to_a, ball.center), ball.center, on_b);
        var least = worth + select(preferred(preference, worth), 0.0, best.feature == 0u);
        // The plane farthest from the centre first: it is often the best one and rules out the others. Then by their
        // numbers.
        var peak = -FAR;
        var start = 0u;
        for (var i = 0u; i < hull.face_count; i++) {
            let plane = plane_in_a(faces[hull.first_face + i].plane, to_a, on_b);
            let height = dot(plane.xyz, center) - plane.w;
            start = select(start, i, height > peak);
            peak = max(peak, height);
        }
        for (var i = 0u; i < hull.face_count && best.distance <= margin; i++) {
            let number = select(i - u32(i <= start), start, i == 0u);
            let plane = plane_in_a(faces[hull.first_face + number].plane, to_a, on_b);
            // The separation is at most that from the ball inside the other hull.
            if (dot(plane.xyz, center) - plane.w - ball.radius <= least) {
                continue;
            }
            let direction = select(plane.xyz * to_a.rotation, plane.xyz, on_b);
            let distance = lowest(other, direction) + select(dot(plane.xyz, to_a.shift), 0.0, on_b) - plane.w;
            let normal = rotate(poses[at.x].rotation, select(plane.xyz, -plane.xyz, on_b));
            let found = worth_of(preference, room, normal, distance);
            if (found > least) {
                least = found;
                worth = found;
                best = Separation(normal, distance, number | select(FACE_A, FACE_B, on_b));
            }
        }
    }

    if (best.distance > margin) {
        hull_pairs[index].cache = best.feature;
        separations[index] = Separation();
    } else if (best.feature != 0u) {
        best.feature |= UNSETTLED;
        separations[index] = best;
    }
}
