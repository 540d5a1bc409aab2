// Kernel `passing`: drops the contacts of hulls that only pass each other, one invocation a slot of a hull pair.
// As `cpu::narrow_phase::passes`.

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
@group(0) @binding(6) var<storage, read> poses: array<Pose>;
@group(0) @binding(7) var<storage, read> velocities: array<Velocity>;
@group(0) @binding(8) var<storage, read> facings: array<Facing>;
@group(0) @binding(9) var<storage, read> manifold_points: array<ManifoldPoint>;
@group(0) @binding(10) var<storage, read_write> manifolds: array<Manifold>;

// A body that nothing touches.
struct Mover {
    pose: Pose,
    // Its speeds, gravity included.
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

// True if a face of `hull` has all of `other` on its outer side, now and later.
fn stays_beside(hull: Hull, other: Hull, now: Frame, then: Frame) -> bool {
    for (var i = hull.first_face; i < hull.first_face + hull.face_count; i++) {
        let plane = faces[i].plane;
        var outside = true;
        for (var k = other.first_vertex; outside && k < other.first_vertex + other.vertex_count; k++) {
            let vertex = vertices[k].xyz;
            let heights = vec2(dot(plane.xyz, carried(now, vertex)), dot(plane.xyz, carried(then, vertex)));
            outside = min(heights.x, heights.y) > plane.w;
        }
        if (outside) {
            return true;
        }
    }
    return false;
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
    let manifold = manifolds[slot];
    if (facing.side == NO_CONTACT || manifold.count == 0u) {
        return;
    }
    let row = candidate * batch.bodies;
    // Contacts act up to a small step beyond the end of the substep.
    let horizon = sim.substep + sim.small_step;
    let a = mover(row, facing.bodies.x, horizon);
    let b = mover(row, facing.bodies.y, horizon);
    var acts = false;
    for (var i = slot * MAX_MANIFOLD_POINTS; i < slot * MAX_MANIFOLD_POINTS + manifold.count; i++) {
        let point = manifold_points[i];
        let closer = dot(manifold.normal, moved(a, point.on_a, horizon) - moved(b, point.on_b, horizon));
        acts = acts || (point.separation > 0.0 && closer > point.separation);
    }
    if (!acts) {
        return;
    }
    let first = hulls[facing.hulls.x];
    let second = hulls[facing.hulls.y];
    let a_later = later(a, horizon);
    let b_later = later(b, horizon);
    let beside_first = stays_beside(first, second, between(a.pose, b.pose), between(a_later, b_later));
    if (beside_first || stays_beside(second, first, between(b.pose, a.pose), between(b_later, a_later))) {
        manifolds[slot].count = 0u;
    }
}
