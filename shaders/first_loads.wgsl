// Kernel `first_loads`: what contacts carry when a simulation begins, one invocation a candidate, patch after patch. It
// follows `solve_load`, and is run again until all are done, as `solve`. Its twin is `cpu::solve::Solver::find_loads`.
//
// Velocities stand for accelerations, m/s², and impulses for forces, N and N m.

#import batch
#import constants
#import contact
#import grid
#import sim
#import solver

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> patch_counts: array<u32>;
@group(0) @binding(3) var<storage, read> gaps: array<Gap>;
@group(0) @binding(4) var<storage, read_write> moving: array<Moving>;
@group(0) @binding(5) var<storage, read_write> frictions: array<Friction>;
@group(0) @binding(6) var<storage, read_write> normals: array<Normal>;
@group(0) @binding(7) var<storage, read_write> cursors: array<Cursor>;
@group(0) @binding(8) var<storage, read_write> patches: array<Patch>;
@group(0) @binding(9) var<storage, read_write> contacts: array<Contact>;

#import company
#import excess
#import pair

// The rows of a candidate.
struct Rows {
    moving: u32,
    slots: u32,
    frictions: u32,
    patches: u32,
}

// How much the bodies of a patch give way: the upper one of two alone, both where they are side by side or lie on each
// other. Patches of a pair are neighbours.
fn give_of(rows: Rows, p: u32) -> vec2<f32> {
    let at = patches[rows.slots + p];
    var bears = vec2(false);
    for (var q = p - min(p, MAX_PATCHES - 1u); q < min(p + MAX_PATCHES, rows.patches); q++) {
        let other = patches[rows.slots + q];
        let up = other.normal.y;
        bears |= vec2(up > BEARING_COSINE, up < -BEARING_COSINE) & vec2(other.pair == at.pair);
    }
    let a_bears = !bears.y & (at.normal.y > BEARING_COSINE);
    let b_bears = !bears.x & (at.normal.y < -BEARING_COSINE);
    return vec2(select(1.0, 0.0, a_bears), select(1.0, 0.0, b_bears));
}

// What the bodies' shares add up to.
fn sum_of(give: vec2<f32>, of_a: f32, of_b: f32) -> f32 {
    return of_a * give.x + of_b * give.y;
}

// Relative acceleration along the row, as far as the bodies give way.
fn speed_of(pair: ptr<function, Pair>, row: Row, give: vec2<f32>) -> f32 {
    let of_a = dot(row.axis, (*pair).linear_a) + dot(row.torque_a, (*pair).spin_a);
    return sum_of(give, -of_a, dot(row.axis, (*pair).linear_b) + dot(row.torque_b, (*pair).spin_b));
}

// Effective mass along the row of what gives way.
fn mass_along(pair: ptr<function, Pair>, row: Row, give: vec2<f32>) -> f32 {
    let size = dot(row.axis, row.axis);
    let of_a = size * (*pair).inverse_mass_a + dot(row.torque_a, row.torque_a);
    return inverse_of(sum_of(give, of_a, size * (*pair).inverse_mass_b + dot(row.torque_b, row.torque_b)));
}

// Takes the forces that keep the patch from sliding and spinning, as far as friction goes. True if sliding changed by
// more than `tolerance`.
fn hold_sliding(pair: ptr<function, Pair>, row: u32, give: vec2<f32>, tolerance: f32) -> bool {
    let friction = frictions[row];
    let turning =
        sum_of(give, dot(friction.twist_a, friction.twist_a), dot(friction.twist_b, friction.twist_b));
    let spinning =
        sum_of(give, -dot(friction.twist_a, (*pair).spin_a), dot(friction.twist_b, (*pair).spin_b));
    let most = friction.twist_limit;
    let twist = clamp(friction.impulse_twist - inverse_of(turning) * spinning, -most, most);
    twist_by(pair, friction, twist - friction.impulse_twist);
    let u = Row(friction.u, friction.u_a, friction.u_b);
    let v = Row(friction.v, friction.v_a, friction.v_b);
    let mass = min(mass_along(pair, u, give), mass_along(pair, v, give));
    let old = vec2(friction.impulse_u, friction.impulse_v);
    let wanted = old - vec2(mass * speed_of(pair, u, give), mass * speed_of(pair, v, give));
    let size = length(wanted);
    let tangential = wanted * select(1.0, friction.limit / size, size > friction.limit);
    let changes = tangential - old;
    push(pair, u, changes.x);
    push(pair, v, changes.y);
    frictions[row].impulse_u = tangential.x;
    frictions[row].impulse_v = tangential.y;
    frictions[row].impulse_twist = twist;
    return max(abs(changes.x), abs(changes.y)) > mass * tolerance;
}

// Takes the force that keeps the contact from closing. True if that changed by more than `tolerance`.
fn hold_closing(pair: ptr<function, Pair>, row: u32, give: vec2<f32>, tolerance: f32) -> bool {
    let n = normals[row];
    let along = Row(n.axis, n.torque_a, n.torque_b);
    let mass = mass_along(pair, along, give);
    let total = max(n.impulse - mass * speed_of(pair, along, give), 0.0);
    let change = total - n.impulse;
    push(pair, along, change);
    normals[row].impulse = total;
    return abs(change) > mass * tolerance;
}

// One sweep over all patches, one way or the other. True if a contact moves by more than the tolerance.
fn sweep_loads(rows: Rows, sweep: u32) -> bool {
    let rubs = sweep >= MAX_LOAD_SWEEPS;
    let backwards = sweep % MAX_LOAD_SWEEPS % 2u == 1u;
    let tolerance = LOAD_TOLERANCE * abs(sim.gravity);
    var changed = false;
    for (var i = 0u; i < rows.patches; i++) {
        let p = in_order(i, rows.patches, backwards);
        let link = link_of(patches[rows.slots + p]);
        let bodies = rows.moving + link.bodies;
        // The first sweeps, without friction and with it, are of all contacts.
        if (!is_restless(bodies, select(sweep, 0u, sweep == MAX_LOAD_SWEEPS))) {
            continue;
        }
        let friction = rows.frictions + p;
        let give = vec2(frictions[friction].mass, frictions[friction].mass_twist);
        var pair = pair_of(bodies);
        var disturbed = false;
        if (rubs) {
            disturbed = hold_sliding(&pair, friction, give, tolerance);
        }
        let first = rows.slots + link.first;
        var limit = 0.0;
        var twist_limit = 0.0;
        for (var k = 0u; k < link.count; k++) {
            let row = first + in_order(k, link.count, backwards);
            if (gaps[row].start <= TOUCHING_DEPTH && gaps[row].start > -1.0 / LOAD_LOSS) {
                disturbed |= hold_closing(&pair, row, give, tolerance);
            }
        }
        for (var k = 0u; k < link.count; k++) {
            limit += normals[first + k].impulse;
            twist_limit += normals[first + k].impulse * normals[first + k].lever;
        }
        frictions[friction].limit = limit * sim.friction;
        frictions[friction].twist_limit = twist_limit * sim.friction;
        store(&pair);
        if (disturbed) {
            disturb(pair.a, sweep);
            disturb(pair.b, sweep);
            changed = true;
        }
    }
    return changed;
}

// Writes the forces into the contacts of bodies that have come to rest, as impulses of a small step.
fn hand_over(rows: Rows) {
    for (var p = 0u; p < rows.patches; p++) {
        let i = rows.slots + p;
        if (is_restless(rows.moving + link_of(patches[i]).bodies, 2u * MAX_LOAD_SWEEPS)) {
            continue;
        }
        let friction = frictions[rows.frictions + p];
        let tangential = friction.impulse_u * friction.u + friction.impulse_v * friction.v;
        patches[i].friction = tangential * sim.small_step;
        patches[i].twist = friction.impulse_twist * sim.small_step;
        let first = rows.slots + patches[i].first;
        let count = patches[i].count;
        for (var k = 0u; k < count; k++) {
            let j = first + turn_of(k, count);
            contacts[j].impulse = normals[first + k].impulse * sim.small_step;
            let load = excess(contacts[j]);
            contacts[j].load = load;
            contacts[j].impulse = load;
        }
    }
}

// How many sweeps are within `Sim::loops`. As `gpu::solver::load_sweeps`.
fn portion(patches: u32) -> u32 {
    let sweep = (1u + 2u * MAX_MANIFOLD_POINTS) * patches + 1u;
    let around = (2u + MAX_MANIFOLD_POINTS + 2u * MAX_PATCHES) * patches + batch.bodies + 4u;
    return clamp((sim.loops - min(sim.loops, around)) / sweep, 1u, 2u * MAX_LOAD_SWEEPS);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let candidate = invocation(id, workgroups);
    let counts = patches_of(candidate, lane);
    if (candidate >= batch.candidates) {
        return;
    }
    let patches_from = candidate * patch_rows(sim.contacts);
    let rows = Rows(candidate * (batch.bodies + 1u), candidate * sim.contacts, patches_from, counts.x);
    var sweep = cursors[candidate].sweep;
    if (sweep == 2u * MAX_LOAD_SWEEPS) {
        return;
    }
    if (sweep == 0u) {
        for (var i = rows.moving; i < rows.moving + batch.bodies; i++) {
            if (moving[i].inverse_mass > 0.0) {
                moving[i].linear = vec3(0.0, sim.gravity, 0.0);
                moving[i].spin = vec3(0.0);
            }
        }
        for (var p = 0u; p < rows.patches; p++) {
            // In the place of effective masses, which are of no use here and are found again by `solve_load`.
            let give = give_of(rows, p);
            frictions[rows.frictions + p].mass = give.x;
            frictions[rows.frictions + p].mass_twist = give.y;
        }
    }
    let most = portion(counts.y);
    for (var sweeps = 0u; sweeps < most; sweeps++) {
        if (sweep == 2u * MAX_LOAD_SWEEPS) {
            break;
        }
        let changed = sweep_loads(rows, sweep);
        let end = select(MAX_LOAD_SWEEPS, 2u * MAX_LOAD_SWEEPS, sweep >= MAX_LOAD_SWEEPS);
        sweep = select(end, sweep + 1u, changed);
    }
    cursors[candidate].sweep = sweep;
    if (sweep == 2u * MAX_LOAD_SWEEPS) {
        hand_over(rows);
    }
}
