// Kernel `axis_remembered`: tries the axis that a hull pair had in the last substep, one invocation a hull pair.
//
// Twin of `cpu::narrow_phase::Twin`, its `evaluate` and `certified`. A pair that this axis parts, or that
// barely touches along it, is settled; `axis_faces` and `axis_edges` see to the others.

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
@group(0) @binding(2) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> hulls: array<Hull>;
@group(0) @binding(4) var<storage, read> balls: array<Ball>;
@group(0) @binding(5) var<storage, read> vertices: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> faces: array<Face>;
@group(0) @binding(7) var<storage, read> face_vertices: array<u32>;
@group(0) @binding(8) var<storage, read> edges: array<Edge>;
@group(0) @binding(9) var<storage, read> poses: array<Pose>;
@group(0) @binding(10) var<storage, read> body_boxes: array<Bounds>;
@group(0) @binding(11) var<storage, read> pair_starts: array<u32>;
@group(0) @binding(12) var<storage, read> hull_pairs: array<HullPair>;
@group(0) @binding(13) var<storage, read_write> separations: array<Separation>;

#import lowest

// Start, unit direction and length of an edge in its body's frame.
struct Line {
    start: vec3<f32>,
    direction: vec3<f32>,
    length: f32,
}

fn line(hull: Hull, number: u32) -> Line {
    let ends = edges[hull.first_edge + number].vertices;
    let start = vertices[hull.first_vertex + ends.x].xyz;
    let along = vertices[hull.first_vertex + ends.y].xyz - start;
    let size = length(along);
    return Line(start, along * (1.0 / max(size, 1.0 / FAR)), size);
}

// True if a vertex of `other` no farther than `distance` over the face lies over its polygon.
fn faces_vertex(hull: Hull, face: Face, other: Hull, to_hull: Frame, distance: f32) -> bool {
    let direction = face.plane.xyz;
    let along = direction * to_hull.rotation;
    let deepest = face.plane.w + distance - dot(direction, to_hull.shift) + CLIP_TOLERANCE;
    var found = false;
    for (var i = 0u; i < other.vertex_count && !found; i++) {
        let vertex = vertices[other.first_vertex + i].xyz;
        if (dot(along, vertex) > deepest) {
            continue;
        }
        let point = carried(to_hull, vertex);
        found = true;
        var start = vertices[hull.first_vertex + face_vertices[face.first_corner + face.corner_count - 1u]].xyz;
        for (var k = 0u; k < face.corner_count && found; k++) {
            let end = vertices[hull.first_vertex + face_vertices[face.first_corner + k]].xyz;
            found = dot(cross(end - start, direction), point - start) <= 0.0;
            start = end;
        }
    }
    return found;
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
    let pair = hull_pairs[index];
    let bodies = pairs[pair.pair] + candidate * batch.bodies;
    let margin = body_boxes[bodies.x].margin + body_boxes[bodies.y].margin;
    let to_a = between(poses[bodies.x], poses[bodies.y]);
    let a = hulls[pair.a];
    let b = hulls[pair.b];
    let apart = carried(to_a, b.center) - a.center;
    let reach = a.radius + b.radius + margin;
    if (dot(apart, apart) > reach * reach) {
        separations[index] = Separation();
        return;
    }
    let kind = pair.cache & KIND;
    if (kind == 0u) {
        separations[index] = Separation(vec3(0.0), 0.0, UNSETTLED);
        return;
    }

    // The axis at the present poses, in A's frame.
    let first = select(0u, pair.cache >> 12u & 0xfffu, kind == EDGES);
    let second = pair.cache & 0xfffu;
    let line_a = line(a, first);
    var line_b = line(b, select(0u, second, kind == EDGES));
    line_b.start = carried(to_a, line_b.start);
    line_b.direction = times(to_a.rotation, line_b.direction);
    let across = cross(line_a.direction, line_b.direction);
    var axis = across * (1.0 / max(length(across), 1.0 / FAR));
    axis = select(axis, -axis, dot(axis, line_a.start - balls[pair.a].center) < 0.0);
    let number = select(a.first_face, b.first_face, kind == FACE_B) + select(second, 0u, kind == EDGES);
    let face = faces[number];
    axis = select(axis, face.plane.xyz, kind == FACE_A);
    axis = select(axis, -times(to_a.rotation, face.plane.xyz), kind == FACE_B);
    let distance = lowest(b, axis * to_a.rotation) + dot(axis, to_a.shift) + lowest(a, -axis);

    let offset = line_b.start - line_a.start;
    let unsupported = dot(axis, offset) - distance > LINEAR_SLOP || dot(across, across) <= PARALLEL_SINE * PARALLEL_SINE;
    if (kind == EDGES && unsupported) {
        separations[index] = Separation(vec3(0.0), 0.0, UNSETTLED);
        return;
    }
    if (distance > margin) {
        separations[index] = Separation();
        return;
    }

    // Two points that face each other along the axis at its distance prove it.
    var certified = false;
    if (kind != EDGES && distance >= -COHERENT_DEPTH) {
        var hull = a;
        var other = b;
        var frame = to_a;
        if (kind == FACE_B) {
            hull = b;
            other = a;
            frame = between(poses[bodies.y], poses[bodies.x]);
        }
        certified = faces_vertex(hull, face, other, frame, distance);
    }
    let turn = dot(line_a.direction, line_b.direction);
    let on_a = dot(line_a.direction, offset);
    let on_b = dot(line_b.direction, offset);
    let determinant = 1.0 - turn * turn;
    let s = on_a - turn * on_b;
    let t = turn * on_a - on_b;
    let cross_inside = s >= 0.0 && t >= 0.0 && s <= line_a.length * determinant && t <= line_b.length * determinant;
    certified = certified || (kind == EDGES && distance >= -COHERENT_DEPTH && cross_inside);
    let state = select(UNSETTLED | REMEMBERED, 0u, certified);
    separations[index] = Separation(rotate(poses[bodies.x].rotation, axis), distance, pair.cache | state);
}
