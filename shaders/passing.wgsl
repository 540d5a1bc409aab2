// Kernel `passing`: drops the contacts of hulls that only pass each other or glide over each other, one invocation a slot
// of a hull pair. As `cpu::narrow_phase::passes`.

#import batch
#import body
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
@group(0) @binding(2) var<storage, read> bodies: array<Body>;
@group(0) @binding(3) var<storage, read> hulls: array<Hull>;
@group(0) @binding(4) var<storage, read> vertices: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> faces: array<Face>;
@group(0) @binding(6) var<storage, read> edges: array<Edge>;
@group(0) @binding(7) var<storage, read> poses: array<Pose>;
@group(0) @binding(8) var<storage, read> velocities: array<Velocity>;
@group(0) @binding(9) var<storage, read> facings: array<Facing>;
@group(0) @binding(10) var<storage, read> manifold_points: array<ManifoldPoint>;
@group(0) @binding(11) var<storage, read_write> manifolds: array<Manifold>;

struct Mover {
    pose: Pose,
    // Its speeds; if nothing touches it, gravity included.
    linear: vec3<f32>,
    angular: vec3<f32>,
}

fn mover(row: u32, body: u32, time: f32) -> Mover {
    let velocity = velocities[row + body];
    let fall = select(time * sim.gravity, 0.0, bodies[body].unit == STATIC);
    return Mover(poses[row + body], velocity.linear + vec3(0.0, fall, 0.0), velocity.angular);
}

fn moved(body: Mover, at: vec3<f32>, time: f32) -> vec3<f32> {
    return time * (body.linear + cross(body.angular, at - body.pose.translation));
}

fn later(body: Mover, time: f32) -> Pose {
    let turn = from_scaled_axis(time * body.angular);
    return Pose(compose(turn, body.pose.rotation), body.pose.translation + time * body.linear);
}

// From the other body's frame to that of a side: now, half-way and at the end.
struct Way {
    now: Frame,
    halfway: Frame,
    later: Frame,
}

// Where a point of the other body is on its way, in the frame of the side.
struct Places {
    now: vec3<f32>,
    halfway: vec3<f32>,
    later: vec3<f32>,
}

// Heights over a plane at both ends of a way, lowered by as much as the way sags below the line between them.
fn heights(plane: vec4<f32>, places: Places) -> vec2<f32> {
    let now = dot(plane.xyz, places.now) - plane.w;
    let halfway = dot(plane.xyz, places.halfway) - plane.w;
    let later = dot(plane.xyz, places.later) - plane.w;
    let sag = min(halfway - 0.5 * (now + later), 0.0);
    return vec2(now + sag, later + sag);
}

// True if a plane through an edge of `hull`, on which that hull lies, has all of `other` on its outer side all the way.
// `nearest`, a point of `other` that is about to touch (its body's frame), is asked first: it rules out most edges.
fn stays_beside(hull: Hull, other: Hull, way: Way, nearest: vec3<f32>) -> bool {
    for (var i = hull.first_edge; i < hull.first_edge + hull.edge_count; i++) {
        let sides = edges[i].faces;
        let left_plane = faces[hull.first_face + sides.x].plane;
        let right_plane = faces[hull.first_face + sides.y].plane;
        // Which shares of the left face's plane, the rest being the right one's, have what was seen so far outside.
        var low = 0.0;
        var high = 1.0;
        for (var k = 0u; low < high && k <= other.vertex_count; k++) {
            let vertex = vertices[other.first_vertex + max(k, 1u) - 1u].xyz;
            let point = select(vertex, nearest, k == 0u);
            let places = Places(carried(way.now, point), carried(way.halfway, point), carried(way.later, point));
            let left = heights(left_plane, places);
            let right = heights(right_plane, places);
            let level = right / (right - left);
            low = select(low, max(low, level.x), left.x > right.x);
            high = select(high, min(high, level.x), left.x < right.x);
            low = select(low, max(low, level.y), left.y > right.y);
            high = select(high, min(high, level.y), left.y < right.y);
            let outside = max(left, right) > vec2(0.0);
            high = select(low, high, outside.x & outside.y);
        }
        if (low < high) {
            return true;
        }
    }
    return false;
}

// True if a face of `hull` that looks another way than `outward`, the contact's, has all of `other` above it, now and
// later, or hardly below. `nearest`: a point of `other` that is about to touch (the frame of the hull's body).
fn glides_over(hull: Hull, other: Hull, now: Frame, then: Frame, nearest: vec3<f32>, outward: vec3<f32>) -> bool {
    for (var i = hull.first_face; i < hull.first_face + hull.face_count; i++) {
        let plane = faces[i].plane;
        var over = dot(plane.xyz, outward) < GLIDING_COSINE && dot(plane.xyz, nearest) - plane.w > -GLIDING_DEPTH;
        for (var k = 0u; over && k < other.vertex_count; k++) {
            let vertex = vertices[other.first_vertex + k].xyz;
            let low = min(dot(plane.xyz, carried(now, vertex)), dot(plane.xyz, carried(then, vertex)));
            over = low - plane.w > -GLIDING_DEPTH;
        }
        if (over) {
            return true;
        }
    }
    return false;
}

// The first contact of the slot farther apart than `least` that acts, or past its end.
fn acting(slot: u32, a: Mover, b: Mover, horizon: f32, least: f32) -> u32 {
    let manifold = manifolds[slot];
    let end = slot * MAX_MANIFOLD_POINTS + manifold.count;
    var first = end;
    for (var i = slot * MAX_MANIFOLD_POINTS; i < end; i++) {
        let point = manifold_points[i];
        let closer = dot(manifold.normal, moved(a, point.on_a, horizon) - moved(b, point.on_b, horizon));
        first = select(first, min(first, i), point.separation > least && closer > point.separation);
    }
    return first;
}

// Where a point (world) is in a body's frame.
fn seen_from(pose: Pose, point: vec3<f32>) -> vec3<f32> {
    return rotate(conjugate(pose.rotation), point - pose.translation);
}

fn flies_past(slot: u32, row: u32, facing: Facing, horizon: f32) -> bool {
    let a = mover(row, facing.bodies.x, horizon);
    let b = mover(row, facing.bodies.y, horizon);
    let point = acting(slot, a, b, horizon, 0.0);
    if (point == slot * MAX_MANIFOLD_POINTS + manifolds[slot].count) {
        return false;
    }
    let first = hulls[facing.hulls.x];
    let second = hulls[facing.hulls.y];
    let a_halfway = later(a, 0.5 * horizon);
    let b_halfway = later(b, 0.5 * horizon);
    let a_later = later(a, horizon);
    let b_later = later(b, horizon);
    let past_first = Way(between(a.pose, b.pose), between(a_halfway, b_halfway), between(a_later, b_later));
    let past_second = Way(between(b.pose, a.pose), between(b_halfway, a_halfway), between(b_later, a_later));
    return stays_beside(first, second, past_first, seen_from(b.pose, manifold_points[point].on_b))
        || stays_beside(second, first, past_second, seen_from(a.pose, manifold_points[point].on_a));
}

// What rests falls nowhere: without gravity.
fn glides(slot: u32, row: u32, facing: Facing, horizon: f32) -> bool {
    let a = mover(row, facing.bodies.x, 0.0);
    let b = mover(row, facing.bodies.y, 0.0);
    let point = acting(slot, a, b, horizon, -GLIDING_DEPTH);
    if (point == slot * MAX_MANIFOLD_POINTS + manifolds[slot].count) {
        return false;
    }
    let first = hulls[facing.hulls.x];
    let second = hulls[facing.hulls.y];
    let a_later = later(a, horizon);
    let b_later = later(b, horizon);
    let on_first = seen_from(a.pose, manifold_points[point].on_b);
    let on_second = seen_from(b.pose, manifold_points[point].on_a);
    let along_first = rotate(conjugate(a.pose.rotation), manifolds[slot].normal);
    let along_second = -rotate(conjugate(b.pose.rotation), manifolds[slot].normal);
    return glides_over(first, second, between(a.pose, b.pose), between(a_later, b_later), on_first, along_first)
        || glides_over(second, first, between(b.pose, a.pose), between(b_later, a_later), on_second, along_second);
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
    if (facing.side == NO_CONTACT || manifolds[slot].count == 0u) {
        return;
    }
    let row = candidate * batch.bodies;
    // Contacts act up to a small step beyond the end of the substep.
    let horizon = sim.substep + sim.small_step;
    if (flies_past(slot, row, facing, horizon) || glides(slot, row, facing, horizon)) {
        manifolds[slot].count = 0u;
    }
}
