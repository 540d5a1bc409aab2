// The small steps of a substep, as `src/cpu/solve/`: accelerate, warm start, springs until they change little and
// friction before the first sweeps, advance, follow, then friction and rigid normals until nothing approaches any more;
// all but the warm start once more if that gained energy. All sweeps are one loop, because software drivers compile
// code that occurs twice twice.
//
// Import it below the bindings. The kernel has the tables that are named here, and says how invocations share a
// candidate: each has every so many of its bodies and patches, `is_due` tells whose turn it is in a sweep, between turns
// they `pause`, and `friction_row` and `point_row` are where a patch has its constraints in `frictions` and `normals`.

#import aim
#import constants
#import batch
#import cold
#import contact
#import follow
#import pair
#import sim
#import solver

// Most sweeps of a small step that gains no energy. Those of its second attempt have the numbers that follow, and then
// those that are made in any case.
const ATTEMPT: u32 = MAX_PUSHING_SWEEPS + MAX_RELAXING_SWEEPS;

// Invocations whose loops software drivers count together: what each does in a sweep of its own adds up.
const COUNTED_TOGETHER: u32 = 8u;

// An invocation's share of a candidate.
struct Share {
    // Which it is, and of how many.
    lane: u32,
    lanes: u32,
    // First row in `moving`, where other invocations look for bodies, too.
    moving: u32,
    // First rows in what all candidates have in one table: `axes` and `free`, `patches` and `gaps`, `levers`.
    far_moving: u32,
    far_slots: u32,
    far_rows: u32,
    // How many patches, and how many turns a sweep there and back takes.
    patches: u32,
    turns: vec2<u32>,
}

fn accelerate(share: Share) {
    let linear = 1.0 / (1.0 + sim.small_step * sim.linear_damping);
    let angular = 1.0 / (1.0 + sim.small_step * sim.angular_damping);
    for (var body = share.lane; body < batch.bodies; body += share.lanes) {
        let i = share.moving + body;
        let inverse_mass = moving[i].inverse_mass;
        if (inverse_mass == 0.0) {
            continue;
        }
        let now = (moving[i].linear + vec3(0.0, sim.small_step * sim.gravity, 0.0)) * linear;
        let spin = moving[i].spin * angular;
        moving[i].linear = now;
        moving[i].spin = spin;
        free[share.far_moving + body] = Free(now, spin, moving[i].shift, moving[i].turn);
        let allowed = (dot(now, now) * ENERGY_GAIN + LEFT_SPEED * LEFT_SPEED) / inverse_mass;
        moving[i].allowed = allowed + dot(spin, spin) * ENERGY_GAIN;
        moving[i].restless = MIN_PUSHING_SWEEPS - 1u;
    }
}

fn warm_start(share: Share) {
    for (var turn = 0u; turn < share.turns.x; turn++) {
        for (var p = share.lane; p < share.patches; p += share.lanes) {
            if (!is_due(share, p, turn, false)) {
                continue;
            }
            let row = friction_row(share, p);
            let friction = frictions[row];
            var pair = pair_of(share.moving + link_at(share, p).bodies);
            push(&pair, Row(friction.u, friction.u_a, friction.u_b), friction.impulse_u);
            push(&pair, Row(friction.v, friction.v_a, friction.v_b), friction.impulse_v);
            twist_by(&pair, friction, friction.impulse_twist);
            store(&pair);
            if (pair.inverse_mass_a > 0.0) {
                moving[pair.a].touched |= select(1u, 3u, pair.inverse_mass_b == 0.0);
            }
            if (pair.inverse_mass_b > 0.0) {
                moving[pair.b].touched |= select(1u, 3u, pair.inverse_mass_a == 0.0);
            }
        }
        pause();
    }
    for (var turn = 0u; turn < share.turns.x; turn++) {
        for (var p = share.lane; p < share.patches; p += share.lanes) {
            if (!is_due(share, p, turn, false)) {
                continue;
            }
            let link = link_at(share, p);
            var pair = pair_of(share.moving + link.bodies);
            let first = point_row(share, p, link);
            for (var k = 0u; k < link.count; k++) {
                let n = normals[first + k];
                push(&pair, Row(n.axis, n.torque_a, n.torque_b), n.impulse);
            }
            store(&pair);
        }
        pause();
    }
}

// Coulomb: the tangential impulse stays in the disk of radius μ times the patch's normal impulse, the twist below what
// the points' friction can resist about the centre.
fn sweep_friction(share: Share, sweep: u32) {
    for (var turn = 0u; turn < share.turns.x; turn++) {
        for (var p = share.lane; p < share.patches; p += share.lanes) {
            if (!is_due(share, p, turn, false)) {
                continue;
            }
            let bodies = share.moving + link_at(share, p).bodies;
            if (!is_restless(bodies, sweep)) {
                continue;
            }
            let row = friction_row(share, p);
            let friction = frictions[row];
            var pair = pair_of(bodies);
            let spinning = dot(friction.twist_b, pair.spin_b) - dot(friction.twist_a, pair.spin_a);
            let most = friction.twist_limit;
            let twist = clamp(friction.impulse_twist - friction.mass_twist * spinning, -most, most);
            twist_by(&pair, friction, twist - friction.impulse_twist);
            let u = Row(friction.u, friction.u_a, friction.u_b);
            let v = Row(friction.v, friction.v_a, friction.v_b);
            let old = vec2(friction.impulse_u, friction.impulse_v);
            let wanted = old - vec2(friction.mass * relative(&pair, u), friction.mass * relative(&pair, v));
            let size = length(wanted);
            let tangential = wanted * select(1.0, friction.limit / size, size > friction.limit);
            push(&pair, u, tangential.x - old.x);
            push(&pair, v, tangential.y - old.y);
            frictions[row].impulse_u = tangential.x;
            frictions[row].impulse_v = tangential.y;
            frictions[row].impulse_twist = twist;
            store(&pair);
        }
        pause();
    }
}

// One sweep over all patches, one way or the other: with `soft` overlap is pushed out, without only approach is
// stopped. Hits take `relaxation` times what would stop them. True if the relative speed of a contact changed.
fn sweep_normals(share: Share, sweep: u32, soft: bool, backwards: bool, relaxation: f32) -> bool {
    var changed = false;
    let spring = softness();
    let turns = select(share.turns.x, share.turns.y, backwards);
    for (var turn = 0u; turn < turns; turn++) {
        for (var i = share.lane; i < share.patches; i += share.lanes) {
            let p = patch_in_order(share, i, backwards);
            if (!is_due(share, p, turn, backwards)) {
                continue;
            }
            let link = link_at(share, p);
            let bodies = share.moving + link.bodies;
            if (!is_restless(bodies, sweep)) {
                continue;
            }
            var disturbed = false;
            var limit = 0.0;
            var twist_limit = 0.0;
            var pair = pair_of(bodies);
            let first = point_row(share, p, link);
            // Fetched one ahead, because everything else waits for the point before.
            var next = normals[first + in_order(0u, link.count, backwards)];
            for (var k = 0u; k < link.count; k++) {
                let n = next;
                next = normals[first + in_order(min(k + 1u, link.count - 1u), link.count, backwards)];
                let row = Row(n.axis, n.torque_a, n.torque_b);
                let springy = soft & (n.depth > 0u);
                let bias = select(n.rigid_bias, n.spring_bias, soft);
                var correction = n.mass * select(1.0, spring.mass_scale, springy) * (relative(&pair, row) + bias);
                let hit = correction - clamp(correction, -HIT_SPEED * n.mass, HIT_SPEED * n.mass);
                correction += hit * (relaxation - 1.0);
                let leak = select(0.0, spring.impulse_scale, springy);
                let total = max(n.impulse - correction - leak * (n.impulse - n.load), 0.0);
                let change = total - n.impulse;
                push(&pair, row, change);
                let counts = !soft | (n.depth < 2u);
                disturbed |= counts & (abs(change) > select(RELAXED_SPEED, PUSHED_SPEED, soft) * n.mass);
                normals[first + in_order(k, link.count, backwards)].impulse = total;
                limit += total;
                twist_limit += total * n.lever;
            }
            store(&pair);
            if (!soft) {
                let row = friction_row(share, p);
                frictions[row].limit = limit * sim.friction;
                frictions[row].twist_limit = twist_limit * sim.friction;
            }
            if (disturbed) {
                disturb(pair.a, sweep);
                disturb(pair.b, sweep);
                changed = true;
            }
        }
        pause();
    }
    return any_lane(changed);
}

// Moves the bodies by their velocities. All of their contacts are solved in the sweep that follows.
fn advance(share: Share, sweep: u32) {
    for (var i = share.moving + share.lane; i < share.moving + batch.bodies; i += share.lanes) {
        moving[i].shift += sim.small_step * moving[i].linear;
        moving[i].turn += sim.small_step * moving[i].spin;
        moving[i].restless = select(sweep, 0u, moving[i].inverse_mass == 0.0);
    }
}

// Contacts where the bodies are now.
fn locate(share: Share) {
    for (var p = share.lane; p < share.patches; p += share.lanes) {
        let link = link_at(share, p);
        let a = moving[share.moving + link.bodies.x];
        let b = moving[share.moving + link.bodies.y];
        let axes_a = axes[share.far_moving + link.bodies.x];
        let axes_b = axes[share.far_moving + link.bodies.y];
        let motion = motion_of(a, b, axes_a, axes_b);
        let inverse_mass = a.inverse_mass + b.inverse_mass;
        let before = levers[share.far_rows + p];
        let follows = is_far(motion, before);
        if (follows) {
            levers[share.far_rows + p] = Levers(before.center, motion.passed, motion.rolled_a, motion.rolled_b);
            let row = friction_row(share, p);
            var friction = frictions[row];
            let center = arms_after(motion, before.center);
            aim_friction(&friction, center, matrix_of(axes_a), matrix_of(axes_b), inverse_mass);
            frictions[row] = friction;
        }
        let first = point_row(share, p, link);
        for (var k = 0u; k < link.count; k++) {
            let j = link.first + k;
            var n = normals[first + k];
            var separation = gaps[share.far_slots + j].start + moved(n, motion.passed, a, b);
            if (follows) {
                let gap = gaps[share.far_slots + j];
                let row = row_along(n.axis, arms_after(motion, gap.arms), matrix_of(axes_a), matrix_of(axes_b));
                n.torque_a = row.torque_a;
                n.torque_b = row.torque_b;
                n.mass = mass_of(row, inverse_mass);
                separation = gap.found + dot(n.axis, moved_by(motion, gap.arms));
                gaps[share.far_slots + j].start = separation - moved(n, motion.passed, a, b);
            }
            aim(&n, separation, gaps[share.far_slots + j].rest);
            normals[first + k] = n;
        }
    }
}

// How many small steps, and how many sweeps of each, are within `Sim::loops`. As `gpu::solver::portion`.
fn portion(patches: u32, longest: u32) -> vec2<u32> {
    let points = 1u + MAX_MANIFOLD_POINTS;
    let sweep = (1u + points) * patches + 3u;
    let around = (2u + (2u + 8u * COUNTED_TOGETHER) * points) * patches + (2u + longest) * batch.bodies + 3u;
    let left = sim.loops - min(sim.loops, around);
    return vec2(max(sim.loops / (around + longest * sweep), 1u), clamp(left / sweep, 1u, longest));
}

// All small steps from `start` on, or as many as are within `Sim::loops`. `patches`: the most that invocations whose
// loops go together have.
fn small_steps(share: Share, start: Cursor, patches: u32) -> Cursor {
    let extra = max(sim.velocity_iterations, 1u) - 1u;
    let most = portion(patches, 2u * ATTEMPT + extra);
    var at = start;
    for (var turn = 0u; turn < most.x; turn++) {
        if (at.step >= sim.small_steps) {
            break;
        }
        let end = 2u * ATTEMPT + select(0u, extra, at.step + 1u == sim.small_steps);
        if (at.sweep == 0u) {
            accelerate(share);
            pause();
            warm_start(share);
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
                advance(share, at.sweep);
                pause();
            }
            if (advances || at.sweep == ATTEMPT) {
                locate(share);
                pause();
            }
            // Sweeps that are made in any case are made of all contacts.
            let sweep = select(at.sweep, 0u, is_extra);
            if (!soft || number < MAX_FRICTION_SWEEPS) {
                sweep_friction(share, sweep);
            }
            let relaxation = select(1.0, OVER_RELAXATION, !is_extra && number > MAX_PUSHING_SWEEPS);
            let changed = sweep_normals(share, sweep, soft, soft && number % 2u == 1u, relaxation);
            at.sweep++;
            if (soft && !changed && number + 1u >= MIN_PUSHING_SWEEPS) {
                at.sweep += MAX_PUSHING_SWEEPS - 1u - number;
            }
            if (is_extra || soft || (changed && number + 1u < ATTEMPT)) {
                continue;
            }
            // Relaxed, or given up.
            let again = at.sweep <= ATTEMPT && gains_energy(share);
            pause();
            if (again) {
                start_cold(share);
                pause();
            }
            at.sweep = select(2u * ATTEMPT, ATTEMPT, again);
        }
        if (at.sweep >= end) {
            at.sweep = 0u;
            at.step++;
        }
    }
    return at;
}
