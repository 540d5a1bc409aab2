// Kernel `ground`: contacts of hulls with the ground y = 0, one invocation a hull of a candidate: as
// `cpu::narrow_phase::plane_hull`. They lie behind the slots of the hull pairs. Of bodies that keep their contacts none
// are looked for.

#import batch
#import bounds
#import body
#import constants
#import contact
#import grid
#import hull
#import pose
#import reduce
#import sim

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> bodies: array<Body>;
@group(0) @binding(3) var<storage, read> hulls: array<Hull>;
@group(0) @binding(4) var<storage, read> hull_bodies: array<u32>;
@group(0) @binding(5) var<storage, read> vertices: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> poses: array<Pose>;
@group(0) @binding(7) var<storage, read> body_boxes: array<Bounds>;
@group(0) @binding(8) var<storage, read_write> manifolds: array<Manifold>;
@group(0) @binding(9) var<storage, read_write> manifold_points: array<ManifoldPoint>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let index = invocation(id, workgroups);
    let hull_count = arrayLength(&hull_bodies);
    if (index >= batch.candidates * hull_count) {
        return;
    }
    let candidate = index / hull_count;
    let hull = hulls[index % hull_count];
    let slot = candidate * (sim.hull_pairs + hull_count) + sim.hull_pairs + index % hull_count;
    let body = hull_bodies[index % hull_count];
    let pose = poses[candidate * batch.bodies + body];
    let box = body_boxes[candidate * batch.bodies + body];
    if (box.is_still == 1u) {
        return;
    }
    let margin = box.margin + 0.5 * sim.contact_offset;
    let up = rotate(conjugate(pose.rotation), vec3(0.0, 1.0, 0.0));
    let height = pose.translation.y;
    let is_far = dot(up, hull.center) + height > margin + hull.radius;
    if (is_far || bodies[body].unit == STATIC) {
        manifolds[slot].count = 0u;
        return;
    }
    var near = 0u;
    var deepest = -LOWEST;
    for (var i = 0u; i < hull.vertex_count; i++) {
        let separation = dot(up, vertices[hull.first_vertex + i].xyz) + height;
        near += select(0u, 1u, separation <= margin);
        deepest = min(deepest, separation);
    }
    let u = tangent(up);
    let v = cross(up, u);
    var extremes = no_extremes();
    // Three or fewer are kept as they come.
    var first = vec4(0u);
    var found = 0u;
    for (var i = 0u; i < hull.vertex_count; i++) {
        let p = vertices[hull.first_vertex + i].xyz;
        let separation = dot(up, p) + height;
        if (separation <= margin) {
            offer(&extremes, vec2(dot(u, p), dot(v, p)), separation - deepest, i);
            first[min(found, 3u)] = i;
            found++;
        }
    }
    var kept: array<vec4<f32>, MAX_MANIFOLD_POINTS>;
    var support = SupportPolygon();
    var missing = Missing(-LOWEST, 0u, 0u);
    var taken = 0u;
    let all = near <= 3u;
    for (var k = 0u; k < TRIES && taken < min(near, MAX_MANIFOLD_POINTS); k++) {
        let looks = completes(k) && missing.reach > 0.0;
        if (looks) {
            missing = Missing();
        }
        for (var i = 0u; i < select(0u, hull.vertex_count, looks); i++) {
            let p = vertices[hull.first_vertex + i].xyz;
            let separation = dot(up, p) + height;
            if (separation <= margin && bears(separation - deepest)) {
                offer_missing(&missing, &support, vec2(dot(u, p), dot(v, p)), i);
            }
        }
        let number = select(extreme(extremes, k), missing.number, completes(k));
        let p = vertices[hull.first_vertex + select(number, first[k & 3u], all)].xyz;
        let separation = dot(up, p) + height;
        if (all || ((missing.reach > 0.0 || !completes(k)) && is_new(&kept, taken, p, k))) {
            extend(&support, k, missing, vec2(dot(u, p), dot(v, p)));
            let on_b = rotate(pose.rotation, p) + pose.translation;
            let on_a = on_b - vec3(0.0, separation, 0.0);
            kept[taken] = vec4(p, separation);
            manifold_points[slot * MAX_MANIFOLD_POINTS + taken] = ManifoldPoint(on_a, separation, on_b);
            taken++;
        }
    }
    manifolds[slot] = Manifold(vec3(0.0, 1.0, 0.0), taken);
}
