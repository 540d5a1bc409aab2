// Kernel `merge`: the contact points that stay of an entry's manifolds, in a few patches, one invocation a body pair of
// a candidate, and past the pairs a body and the ground: as `cpu::contacts::Gatherer`. Points are known by their
// numbers in `manifold_points`. An entry that keeps its contacts has as many as it had.

#import batch
#import body
#import bounds
#import constants
#import contact
#import grid
#import merged
#import reduce
#import sim

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> bodies: array<Body>;
@group(0) @binding(3) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> body_boxes: array<Bounds>;
@group(0) @binding(5) var<storage, read> pair_starts: array<u32>;
@group(0) @binding(6) var<storage, read> manifolds: array<Manifold>;
@group(0) @binding(7) var<storage, read> manifold_points: array<ManifoldPoint>;
@group(0) @binding(8) var<storage, read_write> merged: array<Merged>;
@group(0) @binding(9) var<storage, read_write> merged_points: array<u32>;

const NONE: u32 = 0xffffffffu;

// Points, or the patch that each of them is part of.
alias Numbers = array<u32, MAX_GATHERED_POINTS>;

// Where the points of each patch end.
alias Ends = array<u32, MAX_PATCHES>;

// Normal and separation of each patch's deepest point.
alias Seeds = array<vec4<f32>, MAX_PATCHES>;

fn normal_of(number: u32) -> vec3<f32> {
    return manifolds[number / MAX_MANIFOLD_POINTS].normal;
}

// Finds the patches of the first `count` points, the deepest first, and shares the points out: to the first patch that
// looks about their way, or when there can be no more patches, to the one that looks most their way. Without branches
// in its loops, so that points are fetched several at a time.
fn find_seeds(
    gathered: ptr<function, Numbers>,
    count: u32,
    owners: ptr<function, Numbers>,
    seeds: ptr<function, Seeds>,
) -> u32 {
    var deepest = NONE;
    var depth = -LOWEST;
    for (var i = 0u; i < count; i++) {
        (*owners)[i] = NONE;
        let separation = manifold_points[(*gathered)[i]].separation;
        deepest = select(deepest, (*gathered)[i], separation < depth);
        depth = min(depth, separation);
    }
    var patches = 0u;
    for (var k = 0u; k < MAX_PATCHES; k++) {
        if (deepest == NONE) {
            break;
        }
        let normal = normal_of(deepest);
        (*seeds)[k] = vec4(normal, depth);
        patches = k + 1u;
        deepest = NONE;
        depth = -LOWEST;
        for (var i = 0u; i < count; i++) {
            let number = (*gathered)[i];
            let is_free = (*owners)[i] == NONE;
            let joins = is_free & (dot(normal_of(number), normal) >= PATCH_COSINE);
            (*owners)[i] = select((*owners)[i], k, joins);
            let separation = select(-LOWEST, manifold_points[number].separation, is_free & !joins);
            deepest = select(deepest, number, separation < depth);
            depth = min(depth, separation);
        }
    }
    if (deepest == NONE) {
        return patches;
    }
    for (var i = 0u; i < count; i++) {
        if ((*owners)[i] != NONE) {
            continue;
        }
        let normal = normal_of((*gathered)[i]);
        var most = JOINING_COSINE;
        for (var k = 0u; k < patches; k++) {
            let aligned = dot(normal, (*seeds)[k].xyz);
            let nearer = aligned > most || (aligned == most && (*owners)[i] == NONE);
            (*owners)[i] = select((*owners)[i], k, nearer);
            most = select(most, aligned, nearer);
        }
    }
    return patches;
}

// Points by their patches, in the order in which they were gathered; those of no patch are left out.
fn sort_by_owner(
    gathered: ptr<function, Numbers>,
    count: u32,
    owners: ptr<function, Numbers>,
    sorted: ptr<function, Numbers>,
) -> Ends {
    var ends: Ends;
    for (var i = 0u; i < count; i++) {
        let owner = (*owners)[i];
        for (var k = 0u; k < MAX_PATCHES; k++) {
            ends[k] += u32(owner <= k);
        }
    }
    var next = Ends();
    for (var k = 1u; k < MAX_PATCHES; k++) {
        next[k] = ends[k - 1u];
    }
    for (var i = 0u; i < count; i++) {
        let owner = (*owners)[i];
        if (owner != NONE) {
            (*sorted)[next[owner]] = (*gathered)[i];
            next[owner] += 1u;
        }
    }
    return ends;
}

// Gathers the points of these manifolds. In a function of its own, because its arrays are set to zero first: most
// entries have no points, and that would be all the work.
fn gather(index: u32, first: u32, end: u32) {
    var gathered: Numbers;
    var owners: Numbers;
    var sorted: Numbers;
    var seeds: Seeds;
    var sizes = 0u;
    var count = 0u;
    for (var slot = first; slot <= end; slot++) {
        var added = 0u;
        if (slot < end) {
            added = manifolds[slot].count;
        }
        if (slot == end || count + added > MAX_GATHERED_POINTS) {
            let patches = find_seeds(&gathered, count, &owners, &seeds);
            let ends = sort_by_owner(&gathered, count, &owners, &sorted);
            sizes = 0u;
            count = 0u;
            var begin = 0u;
            for (var k = 0u; k < patches; k++) {
                let normal = seeds[k].xyz;
                let u = tangent(normal);
                let v = cross(normal, u);
                var extremes = no_extremes();
                for (var i = begin; i < ends[k]; i++) {
                    let p = manifold_points[sorted[i]];
                    offer(&extremes, vec2(dot(u, p.on_b), dot(v, p.on_b)), p.separation - seeds[k].w, sorted[i]);
                }
                var positions: array<vec4<f32>, MAX_MANIFOLD_POINTS>;
                var support = SupportPolygon();
                var missing = Missing(-LOWEST, 0u, 0u);
                var taken = 0u;
                let most = min(ends[k] - begin, MAX_MANIFOLD_POINTS);
                for (var j = 0u; j < TRIES && taken < most; j++) {
                    let looks = completes(j) && missing.reach > 0.0;
                    if (looks) {
                        missing = Missing();
                    }
                    for (var i = select(ends[k], begin, looks); i < ends[k]; i++) {
                        let p = manifold_points[sorted[i]];
                        if (bears(p.separation - seeds[k].w)) {
                            offer_missing(&missing, &support, vec2(dot(u, p.on_b), dot(v, p.on_b)), sorted[i]);
                        }
                    }
                    let number = select(extreme(extremes, j), missing.number, completes(j));
                    let p = manifold_points[number].on_b;
                    if ((missing.reach > 0.0 || !completes(j)) && is_new(&positions, taken, p, j)) {
                        extend(&support, j, missing, vec2(dot(u, p), dot(v, p)));
                        positions[taken] = vec4(p, 0.0);
                        gathered[count + taken] = number;
                        taken++;
                    }
                }
                count += taken;
                sizes = insertBits(sizes, taken, 4u * k, 4u);
                begin = ends[k];
            }
        }
        for (var i = 0u; i < added; i++) {
            gathered[count + i] = slot * MAX_MANIFOLD_POINTS + i;
        }
        count += added;
    }
    // Not more than were gathered, so they fit into the slots of these manifolds.
    merged[index] = Merged(sizes, first * MAX_MANIFOLD_POINTS);
    for (var i = 0u; i < count; i++) {
        merged_points[first * MAX_MANIFOLD_POINTS + i] = gathered[i];
    }
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
    let is_ground = entry >= batch.pairs;
    let pair = select(pairs[min(entry, batch.pairs - 1u)], vec2(entry - batch.pairs), is_ground);
    let boxes = candidate * batch.bodies;
    if (keep(body_boxes[boxes + pair.x], body_boxes[boxes + pair.y])) {
        merged[index].first = KEPT;
        return;
    }
    let row = candidate * (arrayLength(&manifolds) / batch.candidates);
    var first = 0u;
    var end = 0u;
    if (!is_ground) {
        let at = candidate * (batch.pairs + 1u) + entry;
        first = row + min(pair_starts[at], sim.hull_pairs);
        end = row + min(pair_starts[at + 1u], sim.hull_pairs);
    } else {
        let body = bodies[entry - batch.pairs];
        first = row + sim.hull_pairs + body.first_hull;
        end = first + body.hull_count;
    }
    var found = 0u;
    for (var slot = first; slot < end; slot++) {
        found += manifolds[slot].count;
    }
    if (found == 0u) {
        merged[index] = Merged(0u, first * MAX_MANIFOLD_POINTS);
        return;
    }
    gather(index, first, end);
}
