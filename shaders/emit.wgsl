// Kernel `emit`: patches and contacts of an entry, with the impulses of the last substep's, one invocation a body pair
// of a candidate, and past the pairs a body and the ground: as `cpu::contacts::ContactSet`, `push` and `keep`.

#import batch
#import constants
#import contact
#import grid
#import merged
#import pose
#import sim

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> poses: array<Pose>;
@group(0) @binding(4) var<storage, read> manifolds: array<Manifold>;
@group(0) @binding(5) var<storage, read> manifold_points: array<ManifoldPoint>;
@group(0) @binding(6) var<storage, read> merged: array<Merged>;
@group(0) @binding(7) var<storage, read> merged_points: array<u32>;
@group(0) @binding(8) var<storage, read> starts: array<vec2<u32>>;
@group(0) @binding(9) var<storage, read> old_starts: array<vec2<u32>>;
@group(0) @binding(10) var<storage, read> old_patch_counts: array<u32>;
@group(0) @binding(11) var<storage, read> old_patches: array<Patch>;
@group(0) @binding(12) var<storage, read> old_contacts: array<Contact>;
@group(0) @binding(13) var<storage, read_write> patches: array<Patch>;
@group(0) @binding(14) var<storage, read_write> contacts: array<Contact>;

const NONE: u32 = 0xffffffffu;

fn distance_squared(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return dot(a - b, a - b);
}

// The same contact after its bodies moved by little: as `cpu::contacts::Contact::followed`.
fn followed(contact: Contact, is_ground: bool, pose_a: Pose, pose_b: Pose) -> Contact {
    let in_world = rotate(pose_a.rotation, contact.anchor_a) + pose_a.translation;
    let on_a = select(in_world, contact.anchor_a, is_ground);
    let on_b = rotate(pose_b.rotation, contact.anchor_b) + pose_b.translation;
    var moved = contact;
    moved.point = 0.5 * (on_a + on_b);
    moved.separation = contact.found + dot(contact.normal, on_b - on_a);
    return moved;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let index = invocation(id, workgroups);
    let entries = batch.pairs + batch.bodies;
    if (index >= batch.candidates * entries) {
        return;
    }
    let candidate = index / entries;
    let entry = index % entries;
    let sizes = merged[index].sizes;
    let start = starts[index];
    if (sizes == 0u || start.y + contact_count(sizes).y > sim.contacts) {
        return;
    }
    let is_ground = entry >= batch.pairs;
    let pair = select(pairs[min(entry, batch.pairs - 1u)], vec2(GROUND, entry - batch.pairs), is_ground);
    let pose_a = poses[candidate * batch.bodies + select(pair.x, 0u, is_ground)];
    let pose_b = poses[candidate * batch.bodies + pair.y];
    let row = candidate * sim.contacts;
    let old_count = old_patch_counts[candidate];
    let old_first = min(old_starts[index].x, old_count);
    var old_end = old_count;
    if (entry + 1u < entries) {
        old_end = min(old_starts[index + 1u].x, old_count);
    }
    if (merged[index].first == KEPT) {
        var at = start;
        for (var i = old_first; i < old_end; i++) {
            let old = old_patches[row + i];
            patches[row + at.x] = old;
            patches[row + at.x].first = at.y;
            for (var j = 0u; j < min(old.count, MAX_MANIFOLD_POINTS); j++) {
                contacts[row + at.y + j] = followed(old_contacts[row + old.first + j], is_ground, pose_a, pose_b);
            }
            at += vec2(1u, old.count);
        }
        return;
    }
    // Old points that have handed over their impulse, eight bits an old patch: it must not be counted twice.
    var used = vec2(0u);
    var number = merged[index].first;
    var point = start.y;
    for (var k = 0u; k < MAX_PATCHES; k++) {
        let size = patch_size(sizes, k);
        if (size == 0u) {
            break;
        }
        let normal = manifolds[merged_points[number] / MAX_MANIFOLD_POINTS].normal;
        var matching = NONE;
        var best = MATCH_COSINE;
        for (var i = old_first; i < old_end; i++) {
            let aligned = dot(old_patches[row + i].normal, normal);
            if (aligned > MATCH_COSINE && aligned >= best) {
                matching = i;
                best = aligned;
            }
        }
        var made = Patch(normal, entry, vec3(0.0), 0.0, pair.x, pair.y, point, size);
        var old_point = 0u;
        var old_size = 0u;
        if (matching != NONE) {
            made.friction = old_patches[row + matching].friction;
            made.twist = old_patches[row + matching].twist;
            old_point = row + old_patches[row + matching].first;
            old_size = old_patches[row + matching].count;
        }
        patches[row + start.x + k] = made;
        for (var i = 0u; i < size; i++) {
            let source = manifold_points[merged_points[number + i]];
            let middle = 0.5 * (source.on_a + source.on_b);
            let in_a = rotate(conjugate(pose_a.rotation), middle - pose_a.translation);
            let anchor_a = select(in_a, middle, is_ground);
            let anchor_b = rotate(conjugate(pose_b.rotation), middle - pose_b.translation);
            var nearest = NONE;
            var least = MATCH_DISTANCE * MATCH_DISTANCE;
            for (var j = 0u; j < old_size; j++) {
                let bit = 8u * (matching - old_first) + j;
                let word = select(used.x, used.y, bit >= 32u);
                let old = old_contacts[old_point + j];
                // A body that slides keeps its point in one of the two frames.
                let apart = min(distance_squared(old.anchor_a, anchor_a), distance_squared(old.anchor_b, anchor_b));
                if (apart < least && extractBits(word, bit & 31u, 1u) == 0u) {
                    nearest = j;
                    least = apart;
                }
            }
            var impulse = 0.0;
            var load = 0.0;
            var rest = 0.0;
            if (nearest != NONE) {
                impulse = old_contacts[old_point + nearest].impulse;
                load = old_contacts[old_point + nearest].load;
                rest = old_contacts[old_point + nearest].rest;
                let bit = 8u * (matching - old_first) + nearest;
                used |= vec2(select(1u, 0u, bit >= 32u), select(0u, 1u, bit >= 32u)) << vec2(bit & 31u);
            }
            let own = manifolds[merged_points[number + i] / MAX_MANIFOLD_POINTS].normal;
            contacts[row + point + i] =
                Contact(own, source.separation, middle, impulse, anchor_a, load, anchor_b, source.separation, rest);
        }
        number += size;
        point += size;
    }
}
