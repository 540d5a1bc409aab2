// Kernel `clip_faces`: contact points of two hulls from their reference face, one invocation a slot of a hull pair. The
// part of `cpu::narrow_phase::manifold` that is `Clip`.
//
// All faces of the other hull that are turned against the reference face are clipped to its outline; what is within the
// margin is thinned to a few points. Works in the frame of the reference hull's body.

#import batch
#import constants
#import contact
#import facing
#import frame
#import grid
#import hull
#import pose
#import reduce
#import sim

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> hulls: array<Hull>;
@group(0) @binding(3) var<storage, read> vertices: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> faces: array<Face>;
@group(0) @binding(5) var<storage, read> face_vertices: array<u32>;
@group(0) @binding(6) var<storage, read> outlines: array<Outline>;
@group(0) @binding(7) var<storage, read> lines: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> poses: array<Pose>;
@group(0) @binding(9) var<storage, read> facings: array<Facing>;
@group(0) @binding(10) var<storage, read_write> manifolds: array<Manifold>;
@group(0) @binding(11) var<storage, read_write> manifold_points: array<ManifoldPoint>;

// Points found so far; w is the separation, m.
alias Points = array<vec4<f32>, MAX_COLLECTED>;

// The polygon that is being cut, and a place for what is written and not kept.
alias Corners = array<vec3<f32>, MAX_CLIPPED + 1u>;

// Keeps `MAX_MANIFOLD_POINTS` of the points. `deepest`: their least separation, m.
fn thin(points: ptr<function, Points>, count: u32, normal: vec3<f32>, deepest: ptr<function, f32>) -> u32 {
    let u = tangent(normal);
    let v = cross(normal, u);
    var extremes = no_extremes();
    for (var i = 0u; i < count; i++) {
        let p = (*points)[i];
        offer(&extremes, vec2(dot(u, p.xyz), dot(v, p.xyz)), p.w - *deepest, i);
    }
    var kept: array<vec4<f32>, MAX_MANIFOLD_POINTS>;
    var support = SupportPolygon();
    var missing = Missing(-LOWEST, 0u, 0u);
    var taken = 0u;
    for (var k = 0u; k < TRIES && taken < MAX_MANIFOLD_POINTS; k++) {
        let looks = completes(k) && missing.reach > 0.0;
        if (looks) {
            missing = Missing();
        }
        for (var i = 0u; i < select(0u, count, looks); i++) {
            let p = (*points)[i];
            if (bears(p.w - *deepest)) {
                offer_missing(&missing, &support, vec2(dot(u, p.xyz), dot(v, p.xyz)), i);
            }
        }
        let p = (*points)[select(extreme(extremes, k), missing.number, completes(k))];
        if ((missing.reach > 0.0 || !completes(k)) && is_new(&kept, taken, p.xyz, k)) {
            extend(&support, k, missing, vec2(dot(u, p.xyz), dot(v, p.xyz)));
            kept[taken] = p;
            taken++;
        }
    }
    *deepest = -LOWEST;
    for (var k = 0u; k < taken; k++) {
        (*points)[k] = kept[k];
        *deepest = min(*deepest, kept[k].w);
    }
    return taken;
}

// How far the polygon of `count` corners reaches beyond a line, m.
fn reach(corners: ptr<function, Corners>, count: u32, line: vec4<f32>) -> f32 {
    var farthest = LOWEST;
    for (var i = 0u; i < count; i++) {
        farthest = max(farthest, dot(line.xyz, (*corners)[i]) - line.w);
    }
    return farthest;
}

// Cuts the polygon of `count` ≥ 1 corners by a line (Sutherland–Hodgman), in place: a convex polygon gains one corner
// at most, so writing is never more than one ahead, and the next corner is read before. Every corner is written and
// then counted or not: branches, `&&` and `||` too, are what compiles slowly.
fn cut(corners: ptr<function, Corners>, count: u32, line: vec4<f32>) -> u32 {
    var kept = 0u;
    var last = (*corners)[count - 1u];
    var last_beyond = dot(line.xyz, last) - line.w;
    var next = (*corners)[0];
    for (var i = 0u; i < count; i++) {
        let following = (*corners)[i + 1u];
        let beyond = dot(line.xyz, next) - line.w;
        let inside = beyond <= CLIP_TOLERANCE;
        let crosses = inside != (last_beyond <= CLIP_TOLERANCE);
        let share = clamp(last_beyond / select(1.0, last_beyond - beyond, crosses), 0.0, 1.0);
        (*corners)[select(MAX_CLIPPED, kept, crosses)] = last + share * (next - last);
        kept = min(kept + select(0u, 1u, crosses), MAX_CLIPPED);
        (*corners)[select(MAX_CLIPPED, kept, inside)] = next;
        kept = min(kept + select(0u, 1u, inside), MAX_CLIPPED);
        last = next;
        last_beyond = beyond;
        next = following;
    }
    return kept;
}

// In a function of its own, because its arrays are set to zero first: for most slots there is nothing to clip, and that
// would be all the work.
fn clip(candidate: u32, slot: u32, facing: Facing) {
    var points: Points;
    var corners: Corners;
    var deepest = -LOWEST;
    let is_a = facing.side == 0u;
    let other = hulls[facing.hulls[1u - facing.side]];
    let row = candidate * batch.bodies;
    let pose = poses[row + facing.bodies[facing.side]];
    let other_pose = poses[row + facing.bodies[1u - facing.side]];
    let to_reference = between(pose, other_pose);
    let reference = hulls[facing.hulls[facing.side]].first_face + facing.faces.x;
    let plane = faces[reference].plane;
    let outline = outlines[reference];
    let against = -(plane.xyz * to_reference.rotation);
    let incident = faces[other.first_face + facing.faces.y].plane;
    var count = 0u;
    var i = 0u;
    for (var face_number = 0u; face_number <= other.face_count; face_number++) {
        // The next face that is turned against the reference face: neighbours in a workgroup go on together.
        for (var k = i; k < other.face_count; k++) {
            let turned = faces[other.first_face + k].plane;
            if (all(turned == incident) | (plane_cosine(against, turned) >= INCIDENT_COSINE)) {
                break;
            }
            i = k + 1u;
        }
        if (count > MAX_MANIFOLD_POINTS) {
            count = thin(&points, count, plane.xyz, &deepest);
        }
        if (i >= other.face_count) {
            break;
        }
        let face = faces[other.first_face + i];
        i++;
        var lowest = -LOWEST;
        for (var c = 0u; c < face.corner_count; c++) {
            let corner = carried(to_reference, vertices[other.first_vertex + face_vertices[face.first_corner + c]].xyz);
            lowest = min(lowest, dot(plane.xyz, corner) - plane.w);
            corners[c] = corner;
        }
        var kept = select(0u, face.corner_count, lowest <= facing.margin);
        for (var l = 0u; l < outline.lines; l++) {
            let line = lines[outline.first + l];
            if (reach(&corners, kept, line) > CLIP_TOLERANCE) {
                kept = cut(&corners, kept, line);
            }
        }
        let earlier = count;
        for (var c = 0u; c < kept; c++) {
            let p = corners[c];
            var separation = LOWEST;
            for (var b = 0u; b < outline.bearing; b++) {
                let bearing = lines[outline.first + outline.lines + b];
                separation = max(separation, dot(bearing.xyz, p) - bearing.w);
            }
            // Neighbouring faces share corners.
            var again = false;
            for (var e = 0u; e < earlier; e++) {
                let apart = points[e].xyz - p;
                again |= dot(apart, apart) < CLIP_TOLERANCE * CLIP_TOLERANCE;
            }
            points[count] = vec4(p, separation);
            let is_contact = (separation <= facing.margin) & !again;
            count += select(0u, 1u, is_contact);
            deepest = select(deepest, min(deepest, separation), is_contact);
        }
    }
    let outward = rotate(pose.rotation, plane.xyz);
    let normal = select(-outward, outward, is_a);
    manifolds[slot] = Manifold(normal, count);
    for (var k = 0u; k < count; k++) {
        // A point of the other hull and its foot on the reference face.
        let on_other = rotate(pose.rotation, points[k].xyz) + pose.translation;
        let foot = on_other - points[k].w * outward;
        let on_a = select(on_other, foot, is_a);
        let on_b = select(foot, on_other, is_a);
        manifold_points[slot * MAX_MANIFOLD_POINTS + k] = ManifoldPoint(on_a, points[k].w, on_b);
    }
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
    if (facing.side >= NO_FACE) {
        manifolds[slot].count = 0u;
        return;
    }
    clip(candidate, slot, facing);
}
