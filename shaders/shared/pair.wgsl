// Two bodies of a patch while its constraints are solved. Import it below the bindings: the kernel has `moving`.

#import batch
#import contact
#import solver

// Their velocities.
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

// What sweeps need to know of a patch.
struct Link {
    // Its bodies, and its points, from the candidate's first on.
    bodies: vec2<u32>,
    first: u32,
    count: u32,
    // Its turn in a sweep there, and in one back.
    turns: vec2<u32>,
}

fn link_of(at: Patch) -> Link {
    return Link(vec2(select(at.a, batch.bodies, at.a == GROUND), at.b), at.first, at.count, vec2(0u));
}

fn pair_of(bodies: vec2<u32>) -> Pair {
    let a = moving[bodies.x];
    let b = moving[bodies.y];
    return Pair(bodies.x, bodies.y, a.inverse_mass, b.inverse_mass, a.linear, a.spin, b.linear, b.spin);
}

// What is fixed stays as it is, and others may read it.
fn store(pair: ptr<function, Pair>) {
    if ((*pair).inverse_mass_a > 0.0) {
        moving[(*pair).a].linear = (*pair).linear_a;
        moving[(*pair).a].spin = (*pair).spin_a;
    }
    if ((*pair).inverse_mass_b > 0.0) {
        moving[(*pair).b].linear = (*pair).linear_b;
        moving[(*pair).b].spin = (*pair).spin_b;
    }
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

// True if a patch between these bodies has to be solved in this sweep.
fn is_restless(bodies: vec2<u32>, sweep: u32) -> bool {
    return max(moving[bodies.x].restless, moving[bodies.y].restless) >= sweep;
}

// The contacts of a body are solved in the sweep after this one, too, and in the rest of this; the first sweeps are of
// all contacts in any case.
fn disturb(body: u32, sweep: u32) {
    if (moving[body].inverse_mass > 0.0) {
        moving[body].restless = max(moving[body].restless, sweep + 1u);
    }
}

fn in_order(k: u32, count: u32, backwards: bool) -> u32 {
    return select(k, count - 1u - k, backwards);
}
