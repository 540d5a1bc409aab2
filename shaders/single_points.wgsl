// Kernel `single_points`: the one contact of two hulls where clipping finds none, one invocation a slot of a hull pair.
// Last part of `cpu::narrow_phase::manifold`.
//
// It lies between the two edges of the axis, in the world's frame, or between the outlines of the two faces where those
// are nearest, in the frame of the reference hull's body.

#import batch
#import constants
#import contact
#import facing
#import frame
#import grid
#import hull
#import pose
#import sim

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> hulls: array<Hull>;
@group(0) @binding(3) var<storage, read> vertices: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> faces: array<Face>;
@group(0) @binding(5) var<storage, read> face_vertices: array<u32>;
@group(0) @binding(6) var<storage, read> edges: array<Edge>;
@group(0) @binding(7) var<storage, read> poses: array<Pose>;
@group(0) @binding(8) var<storage, read> separations: array<Separation>;
@group(0) @binding(9) var<storage, read> facings: array<Facing>;
@group(0) @binding(10) var<storage, read_write> manifolds: array<Manifold>;
@group(0) @binding(11) var<storage, read_write> manifold_points: array<ManifoldPoint>;

const EDGE_KIND: u32 = 3u;
const EPSILON: f32 = 1.1920929e-7;

// The nearest points of the segments p + [0, 1] u and q + [0, 1] v, as shares (Ericson, "Real-Time Collision
// Detection", 5.1.9).
fn nearest_on_segments(p: vec3<f32>, u: vec3<f32>, q: vec3<f32>, v: vec3<f32>) -> vec2<f32> {
    let w = p - q;
    let a = dot(u, u);
    let e = dot(v, v);
    let b = dot(u, v);
    let c = dot(u, w);
    let f = dot(v, w);
    let determinant = a * e - b * b;
    // Parallel segments: any point will do, take the start.
    let crossing = determinant > EPSILON * a * e;
    let first = select(0.0, clamp((b * f - c * e) / select(1.0, determinant, crossing), 0.0, 1.0), crossing);
    let t = clamp((b * first + f) / e, 0.0, 1.0);
    return vec2(clamp((b * t - c) / a, 0.0, 1.0), t);
}

fn placed(pose: Pose, point: vec3<f32>) -> vec3<f32> {
    return rotate(pose.rotation, point) + pose.translation;
}

// Corners of a face (number within the hull, the first of those in its plane) and of all in its plane: as
// `HullTables::ring_of`.
fn ring_of(hull: Hull, number: u32) -> u32 {
    let plane = faces[hull.first_face + number].plane;
    var corners = 0u;
    for (var k = number; k < hull.face_count; k++) {
        if (any(faces[hull.first_face + k].plane != plane)) {
            break;
        }
        corners += faces[hull.first_face + k].corner_count;
    }
    return corners;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let index = invocation(id, workgroups);
    if (index >= batch.candidates * sim.hull_pairs) {
        return;
    }
    let candidate = index / sim.hull_pairs;
    let slot = candidate * (arrayLength(&manifolds) / batch.candidates) + index % sim.hull_pairs;
    let facing = facings[index];
    let axis = separations[index].normal;
    let distance = separations[index].distance;
    let feature = separations[index].feature;
    let is_edges = feature >> 24u == EDGE_KIND;
    if (facing.side == NO_CONTACT || manifolds[slot].count > 0u || (facing.side == NO_FACE && !is_edges)) {
        return;
    }
    // The hull that the outer loop runs round: the one of the reference face.
    let side = select(facing.side, 0u, is_edges);
    let row = candidate * batch.bodies;
    let pose = poses[row + facing.bodies[side]];
    let other_pose = poses[row + facing.bodies[1u - side]];
    let hull = hulls[facing.hulls[side]];
    let other = hulls[facing.hulls[1u - side]];
    let edge = edges[hull.first_edge + select(0u, extractBits(feature, 12u, 12u), is_edges)].vertices;
    let other_edge = edges[other.first_edge + select(0u, extractBits(feature, 0u, 12u), is_edges)].vertices;
    let first_corner = faces[hull.first_face + facing.faces.x].first_corner;
    let other_first_corner = faces[other.first_face + facing.faces.y].first_corner;
    let ring = ring_of(hull, facing.faces.x);
    let other_ring = ring_of(other, facing.faces.y);
    let to_reference = between(pose, other_pose);
    var least = 3.4e38;
    var on_reference = vec3(0.0);
    var on_other = vec3(0.0);
    let count = select(ring, 1u, is_edges);
    let other_count = select(other_ring, 1u, is_edges);
    for (var i = 0u; i < count; i++) {
        let corner = face_vertices[first_corner + i];
        let next_corner = face_vertices[first_corner + select(i + 1u, 0u, i + 1u >= ring)];
        let ends = select(vec2(corner, next_corner), edge, is_edges);
        let start = vertices[hull.first_vertex + ends.x].xyz;
        let end = vertices[hull.first_vertex + ends.y].xyz;
        let p = select(start, placed(pose, start), is_edges);
        let u = select(end, placed(pose, end), is_edges) - p;
        for (var k = 0u; k < other_count; k++) {
            let other_corner = face_vertices[other_first_corner + k];
            let other_next =
                face_vertices[other_first_corner + select(k + 1u, 0u, k + 1u >= other_ring)];
            let other_ends = select(vec2(other_corner, other_next), other_edge, is_edges);
            let other_start = vertices[other.first_vertex + other_ends.x].xyz;
            let other_end = vertices[other.first_vertex + other_ends.y].xyz;
            let q = select(carried(to_reference, other_start), placed(other_pose, other_start), is_edges);
            let v = select(carried(to_reference, other_end), placed(other_pose, other_end), is_edges) - q;
            let shares = nearest_on_segments(p, u, q, v);
            let apart = (p + shares.x * u) - (q + shares.y * v);
            let nearer = dot(apart, apart) < least;
            least = select(least, dot(apart, apart), nearer);
            on_reference = select(on_reference, p + shares.x * u, nearer);
            on_other = select(on_other, q + shares.y * v, nearer);
        }
    }
    on_reference = select(placed(pose, on_reference), on_reference, is_edges);
    on_other = select(placed(pose, on_other), on_other, is_edges);
    var on_a = select(on_other, on_reference, side == 0u);
    var on_b = select(on_reference, on_other, side == 0u);
    if (!is_edges && distance <= 0.0) {
        // An edge pair lost by little against this face: the contact lies between the outlines.
        let middle = 0.5 * (on_a + on_b);
        on_a = middle - 0.5 * distance * axis;
        on_b = middle + 0.5 * distance * axis;
    }
    // Points apart are joined by their own line: it is the exact normal of two corners.
    let between = on_b - on_a;
    let along = dot(axis, between);
    let apart = along > LINEAR_SLOP;
    let separation = select(along, length(between), apart);
    if (separation <= facing.margin) {
        manifolds[slot] = Manifold(select(axis, between / max(separation, LINEAR_SLOP), apart), 1u);
        manifold_points[slot * MAX_MANIFOLD_POINTS] = ManifoldPoint(on_a, separation, on_b);
    }
}
