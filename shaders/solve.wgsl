// Kernel `solve`: the small steps of a substep, one invocation a candidate, patch after patch. It is run again until all
// are done: Mesa's software driver ends every loop once those of an invocation have gone round 65,535 times, without a word.
//
// The order is `src/cpu/solve/`': accelerate, warm start, friction and soft normals until they change little, advance,
// follow, then friction and rigid normals until nothing approaches any more; all but the warm start once more if that gained
// energy. All sweeps are one loop, because software drivers compile code that occurs twice twice.

#import constants
#import batch
#import contact
#import grid
#import sim
#import solver

const TAU: f32 = 6.2831853;

// Most sweeps of a small step that gains no energy. Those of its second attempt have the numbers that follow, and then those
// that are made in any case.
const ATTEMPT: u32 = MAX_PUSHING_SWEEPS + MAX_RELAXING_SWEEPS;

// Invocations whose loops software drivers count together: what each does in a sweep of its own adds up.
const COUNTED_TOGETHER: u32 = 8u;

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> sim: Sim;
@group(0) @binding(2) var<storage, read> patch_counts: array<u32>;
@group(0) @binding(3) var<storage, read> patches: array<Patch>;
@group(0) @binding(4) var<storage, read_write> moving: array<Moving>;
@group(0) @binding(5) var<storage, read_write> frictions: array<Friction>;
@group(0) @binding(6) var<storage, read_write> normals: array<Normal>;
@group(0) @binding(7) var<storage, read_write> cursors: array<Cursor>;

// Most patches of the workgroup's candidates, which go through their loops together.
var<workgroup> most_patches: atomic<u32>;

// Two bodies while their constraints are solved.
struct Pair {
    a: u32,
    b: u32,
    inverse_mass_a: f32,
    inverse_mass_b: f32,
    linear_a: vec3<f32>,
    spin_a: vec3<f32>,
    linear_b: vec3<f32>,
    spin_b: vec3<f32>,
}

// Row of `moving` with a patch's first body.
fn first_body(at: Patch, bodies: u32) -> u32 {
    return bodies + select(at.a, batch.bodies, at.a == GROUND);
}

fn pair_of(at: Patch, bodies: u32) -> Pair {
    let a = first_body(at, bodies);
    let b = bodies + at.b;
    let body_a = moving[a];
    let body_b = moving[b];
    return Pair(
        a,
        b,
        body_a.inverse_mass,
        body_b.inverse_mass,
        body_a.linear,
        body_a.spin,
        body_b.linear,
        body_b.spin,
    );
}

fn store(pair: ptr<function, Pair>) {
    moving[(*pair).a].linear = (*pair).linear_a;
    moving[(*pair).a].spin = (*pair).spin_a;
    moving[(*pair).b].linear = (*pair).linear_b;
    moving[(*pair).b].spin = (*pair).spin_b;
}

// Relative velocity along the row, m/s.
fn relative(pair: ptr<function, Pair>, row: Row) -> f32 {
    return dot(row.axis, (*pair).linear_b - (*pair).linear_a) + dot(row.torque_b, (*pair).spin_b)
        - dot(row.torque_a, (*pair).spin_a);
}

fn push(pair: ptr<function, Pair>, row: Row, impulse: f32) {
    (*pair).linear_a -= impulse * (*pair).inverse_mass_a * row.axis;
    (*pair).spin_a -= impulse * row.torque_a;
    (*pair).linear_b += impulse * (*pair).inverse_mass_b * row.axis;
    (*pair).spin_b += impulse * row.torque_b;
}

fn twist_by(pair: ptr<function, Pair>, friction: Friction, impulse: f32) {
    (*pair).spin_a -= impulse * friction.twist_a;
    (*pair).spin_b += impulse * friction.twist_b;
}

fn accelerate(bodies: u32) {
    let linear = 1.0 / (1.0 + sim.small_step * sim.linear_damping);
    let angular = 1.0 / (1.0 + sim.small_step * sim.angular_damping);
    for (var i = bodies; i < bodies + batch.bodies; i++) {
        let gain = select(sim.small_step * sim.gravity, 0.0, moving[i].inverse_mass == 0.0);
        moving[i].linear = (moving[i].linear + vec3(0.0, gain, 0.0)) * linear;
        moving[i].spin *= angular;
        moving[i].free_linear = moving[i].linear;
        moving[i].free_spin = moving[i].spin;
        moving[i].free_shift = moving[i].shift;
        moving[i].free_turn = moving[i].turn;
        moving[i].restless = select(MIN_PUSHING_SWEEPS - 1u, 0u, moving[i].inverse_mass == 0.0);
    }
}

fn warm_start(bodies: u32, slots: u32, rows: u32, count: u32) {
    for (var p = 0u; p < count; p++) {
        let at = patches[slots + p];
        let friction = frictions[rows + p];
        var pair = pair_of(at, bodies);
        push(&pair, Row(friction.u, friction.u_a, friction.u_b), friction.impulse.x);
        push(&pair, Row(friction.v, friction.v_a, friction.v_b), friction.impulse.y);
        twist_by(&pair, friction, friction.impulse.z);
        store(&pair);
    }
    for (var p = 0u; p < count; p++) {
        let at = patches[slots + p];
        var pair = pair_of(at, bodies);
        for (var j = slots + at.first; j < slots + at.first + at.count; j++) {
            push(&pair, Row(normals[j].axis, normals[j].torque_a, normals[j].torque_b), normals[j].impulse);
        }
        store(&pair);
    }
}

// True if a patch has to be solved in this sweep.
fn is_restless(at: Patch, bodies: u32, sweep: u32) -> bool {
    return max(moving[first_body(at, bodies)].restless, moving[bodies + at.b].restless) >= sweep;
}

// The contacts of a body are solved in the sweep after this one, too, and in the rest of this; the first sweeps are of all
// contacts in any case.
fn disturb(body: u32, sweep: u32) {
    moving[body].restless = select(max(moving[body].restless, sweep + 1u), 0u, moving[body].inverse_mass == 0.0);
}

// Coulomb: the tangential impulse stays in the disk of radius μ times the patch's normal impulse, the twist below what
// the points' friction can resist about the centre.
fn sweep_friction(bodies: u32, slots: u32, rows: u32, count: u32, sweep: u32) {
    for (var p = 0u; p < count; p++) {
        let at = patches[slots + p];
        if (!is_restless(at, bodies, sweep)) {
            continue;
        }
        let friction = frictions[rows + p];
        var pair = pair_of(at, bodies);
        let old = friction.impulse;
        let spinning = dot(friction.twist_b, pair.spin_b) - dot(friction.twist_a, pair.spin_a);
        let most = friction.twist_limit;
        let twist = clamp(old.z - friction.mass_twist * spinning, -most, most);
        twist_by(&pair, friction, twist - old.z);
        let u = Row(friction.u, friction.u_a, friction.u_b);
        let v = Row(friction.v, friction.v_a, friction.v_b);
        let wanted = old.xy - vec2(friction.mass * relative(&pair, u), friction.mass * relative(&pair, v));
        let size = length(wanted);
        let tangential = wanted * select(1.0, friction.limit / size, size > friction.limit);
        push(&pair, u, tangential.x - old.x);
        push(&pair, v, tangential.y - old.y);
        frictions[rows + p].impulse = vec3(tangential, twist);
        store(&pair);
    }
}

// One sweep over all patches, one way or the other: with `soft` overlap is pushed out, without only approach is stopped.
// What is still apart may come no closer than touching. True if the relative speed of a contact changed.
fn sweep_normals(
    bodies: u32,
    slots: u32,
    rows: u32,
    count: u32,
    sweep: u32,
    soft: bool,
    backwards: bool,
) -> bool {
    // Implicit damped spring over a small step (E. Catto, "Soft Constraints", GDC 2011).
    let h = sim.small_step;
    let omega = TAU * min(CONTACT_FREQUENCY, CONTACT_FREQUENCY_SHARE / h);
    let a1 = 2.0 * CONTACT_DAMPING_RATIO + h * omega;
    let a2 = h * omega * a1;
    let a3 = 1.0 / (1.0 + a2);
    var changed = false;
    for (var i = 0u; i < count; i++) {
        let p = select(i, count - 1u - i, backwards);
        let at = patches[slots + p];
        if (!is_restless(at, bodies, sweep)) {
            continue;
        }
        var disturbed = false;
        var limit = 0.0;
        var twist_limit = 0.0;
        var pair = pair_of(at, bodies);
        let shift = moving[pair.b].shift - moving[pair.a].shift;
        let turn_a = moving[pair.a].turn;
        let turn_b = moving[pair.b].turn;
        for (var k = 0u; k < at.count; k++) {
            let j = slots + at.first + select(k, at.count - 1u - k, backwards);
            let n = normals[j];
            let row = Row(n.axis, n.torque_a, n.torque_b);
            let moved = dot(n.axis, shift) + dot(n.torque_b, turn_b) - dot(n.torque_a, turn_a);
            let separation = n.separation + moved;
            let springy = soft && separation <= 0.0;
            let deep = DEEP_PUSH_OUT_RATE * min(separation + TOUCHING_DEPTH, 0.0);
            let push_out = max(omega / a1 * (separation - n.rest) + deep, -sim.max_push_out);
            let bias = select(max(separation, 0.0) / h, push_out, springy);
            let correction = n.mass * select(1.0, a2 * a3, springy) * (relative(&pair, row) + bias);
            let total = max(n.impulse - correction - select(0.0, a3, springy) * (n.impulse - n.load), 0.0);
            let change = total - n.impulse;
            push(&pair, row, change);
            let counts = !soft || separation >= -TOUCHING_DEPTH;
            disturbed |= counts && abs(change) > select(RELAXED_SPEED, PUSHED_SPEED, soft) * n.mass;
            normals[j].impulse = total;
            limit += total;
            twist_limit += total * n.lever;
        }
        store(&pair);
        if (!soft) {
            frictions[rows + p].limit = limit * sim.friction;
            frictions[rows + p].twist_limit = twist_limit * sim.friction;
        }
        if (disturbed) {
            disturb(pair.a, sweep);
            disturb(pair.b, sweep);
            changed = true;
        }
    }
    return changed;
}

// Moves the bodies by their velocities. All of their contacts are solved in the sweep that follows.
fn advance(bodies: u32, sweep: u32) {
    for (var i = bodies; i < bodies + batch.bodies; i++) {
        moving[i].shift += sim.small_step * moving[i].linear;
        moving[i].turn += sim.small_step * moving[i].spin;
        moving[i].restless = select(sweep, 0u, moving[i].inverse_mass == 0.0);
    }
}

// Two free bodies that have moved past each other push at a common point again, half-way. On something fixed a contact's
// points go with the body that moves.
fn follow(bodies: u32, slots: u32, rows: u32, count: u32) {
    for (var p = 0u; p < count; p++) {
        let at = patches[slots + p];
        let a = moving[first_body(at, bodies)];
        let b = moving[bodies + at.b];
        let passed = b.shift - a.shift;
        let further = passed - frictions[rows + p].passed;
        let is_fixed = a.inverse_mass == 0.0 || b.inverse_mass == 0.0;
        if (is_fixed || dot(further, further) < ARM_TOLERANCE * ARM_TOLERANCE) {
            continue;
        }
        let by = 0.5 * further;
        var friction = frictions[rows + p];
        friction.arm_a += by;
        friction.arm_b -= by;
        friction.passed = passed;
        aim_friction(&friction, a, b);
        frictions[rows + p] = friction;
        for (var j = slots + at.first; j < slots + at.first + at.count; j++) {
            let torque = cross(by, normals[j].axis);
            let torque_a = normals[j].torque_a + times(frame_of(a), torque);
            let torque_b = normals[j].torque_b - times(frame_of(b), torque);
            normals[j].torque_a = torque_a;
            normals[j].torque_b = torque_b;
            normals[j].mass = mass_of(Row(normals[j].axis, torque_a, torque_b), a, b);
        }
    }
}

// True if the bodies have more kinetic energy than before the impulses of the small step.
fn gains_energy(bodies: u32) -> bool {
    var energy = 0.0;
    var bound = 0.0;
    for (var i = bodies; i < bodies + batch.bodies; i++) {
        let body = moving[i];
        if (body.inverse_mass == 0.0) {
            continue;
        }
        energy += dot(body.linear, body.linear) / body.inverse_mass;
        energy += dot(body.spin, body.spin);
        bound += (dot(body.free_linear, body.free_linear) * ENERGY_GAIN + LEFT_SPEED * LEFT_SPEED) / body.inverse_mass;
        bound += dot(body.free_spin, body.free_spin) * ENERGY_GAIN;
    }
    return energy > bound;
}

// Takes the impulses of the small step back, and what they moved.
fn start_cold(bodies: u32, slots: u32, rows: u32, count: u32) {
    for (var i = bodies; i < bodies + batch.bodies; i++) {
        moving[i].linear = moving[i].free_linear;
        moving[i].spin = moving[i].free_spin;
        moving[i].shift = moving[i].free_shift;
        moving[i].turn = moving[i].free_turn;
        moving[i].restless = select(ATTEMPT + MIN_PUSHING_SWEEPS - 1u, 0u, moving[i].inverse_mass == 0.0);
    }
    for (var p = 0u; p < count; p++) {
        frictions[rows + p].impulse = vec3(0.0);
        frictions[rows + p].limit = 0.0;
        frictions[rows + p].twist_limit = 0.0;
        let first = slots + patches[slots + p].first;
        for (var j = first; j < first + patches[slots + p].count; j++) {
            normals[j].impulse = 0.0;
        }
    }
}

// How many small steps, and how many sweeps of each, are within `Sim::loops`. As `gpu::solver::portion`.
fn portion(patches: u32, longest: u32) -> vec2<u32> {
    let points = 1u + MAX_MANIFOLD_POINTS;
    let sweep = (1u + points) * patches + 1u;
    let around = (2u + (2u + 4u * COUNTED_TOGETHER) * points) * patches + (2u + longest) * batch.bodies + 1u;
    let left = sim.loops - min(sim.loops, around);
    return vec2(max(sim.loops / (around + longest * sweep), 1u), clamp(left / sweep, 1u, longest));
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let candidate = invocation(id, workgroups);
    let is_spare = candidate >= batch.candidates;
    let room = patch_rows(sim.contacts);
    let count = select(min(patch_counts[min(candidate, batch.candidates - 1u)], room), 0u, is_spare);
    if (lane == 0u) {
        atomicStore(&most_patches, 0u);
    }
    workgroupBarrier();
    atomicMax(&most_patches, count);
    workgroupBarrier();
    if (is_spare) {
        return;
    }
    let bodies = candidate * (batch.bodies + 1u);
    let slots = candidate * sim.contacts;
    let rows = candidate * room;
    let extra = max(sim.velocity_iterations, 1u) - 1u;
    let most = portion(atomicLoad(&most_patches), 2u * ATTEMPT + extra);
    var at = cursors[candidate];
    for (var turn = 0u; turn < most.x; turn++) {
        if (at.step >= sim.small_steps) {
            break;
        }
        let end = 2u * ATTEMPT + select(0u, extra, at.step + 1u == sim.small_steps);
        if (at.sweep == 0u) {
            for (var i = slots; i < slots + count; i++) {
                let a = first_body(patches[i], bodies);
                let b = bodies + patches[i].b;
                moving[a].touched |= select(1u, 3u, moving[b].inverse_mass == 0.0);
                moving[b].touched |= select(1u, 3u, moving[a].inverse_mass == 0.0);
            }
            accelerate(bodies);
            warm_start(bodies, slots, rows, count);
        }
        for (var sweeps = 0u; sweeps < most.y; sweeps++) {
            if (at.sweep >= end) {
                break;
            }
            let is_extra = at.sweep >= 2u * ATTEMPT;
            let number = at.sweep % ATTEMPT;
            let soft = !is_extra && number < MAX_PUSHING_SWEEPS;
            let advances = !is_extra && number == MAX_PUSHING_SWEEPS;
            if (advances) {
                advance(bodies, at.sweep);
            }
            if (advances || at.sweep == ATTEMPT) {
                follow(bodies, slots, rows, count);
            }
            // Sweeps that are made in any case are made of all contacts.
            let sweep = select(at.sweep, 0u, is_extra);
            sweep_friction(bodies, slots, rows, count, sweep);
            let changed = sweep_normals(bodies, slots, rows, count, sweep, soft, soft && number % 2u == 1u);
            at.sweep++;
            if (soft && !changed && number + 1u >= MIN_PUSHING_SWEEPS) {
                at.sweep += MAX_PUSHING_SWEEPS - 1u - number;
            }
            if (is_extra || soft || (changed && number + 1u < ATTEMPT)) {
                continue;
            }
            // Relaxed, or given up.
            let again = at.sweep <= ATTEMPT && gains_energy(bodies);
            if (again) {
                start_cold(bodies, slots, rows, count);
            }
            at.sweep = select(2u * ATTEMPT, ATTEMPT, again);
        }
        if (at.sweep >= end) {
            at.sweep = 0u;
            at.step++;
        }
    }
    cursors[candidate] = at;
}
