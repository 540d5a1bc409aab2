// What the solver keeps of a candidate during a substep, as `src/cpu/solve/`. Tables have `Batch::bodies + 1` rows a
// candidate for bodies (the last is the ground), `Sim::contacts` for points, `patch_rows` for the friction of patches.

#import vector

// Motion of a body.
struct Moving {
    // m/s
    linear: vec3<f32>,
    inverse_mass: f32,
    // Angular velocity, as the frame has it.
    spin: vec3<f32>,
    // The number of the last sweep of the small step in which its contacts are solved.
    restless: u32,
    // Shift since the substep's start, m.
    shift: vec3<f32>,
    // 1 if it has contacts, or may come to touch something; 3 if that is something fixed.
    touched: u32,
    // Turn since the substep's start, as the frame has it.
    turn: vec3<f32>,
    // Twice the most kinetic energy that it may have after the small step, J.
    allowed: f32,
}

// Columns of the matrix from the world to the body's principal axes at the substep's start, each scaled by the root of
// its inverse moment of inertia. There a torque's arm is also what a unit impulse does to the spin. And one for every
// axis of the body about which it may turn in a substep and keep its inertia about as it is, nought for the others.
struct Axes {
    x: vec3<f32>,
    round_x: f32,
    y: vec3<f32>,
    round_y: f32,
    z: vec3<f32>,
    round_z: f32,
}

// Motion of a body before the impulses of the small step; as in `Moving`.
struct Free {
    linear: vec3<f32>,
    spin: vec3<f32>,
    shift: vec3<f32>,
    turn: vec3<f32>,
}

// A contact point ready to solve, in the order of a sweep.
struct Normal {
    axis: vec3<f32>,
    // Effective mass, kg.
    mass: f32,
    // Torque of a unit impulse about either body, in its frame.
    torque_a: vec3<f32>,
    // Accumulated impulse of one small step, N s.
    impulse: f32,
    torque_b: vec3<f32>,
    // `Contact::load`
    load: f32,
    // Distance from the patch's centre, m: lever of its friction against twisting.
    lever: f32,
    // Speed at which the surfaces are to come closer, rigid or as a spring, m/s.
    rigid_bias: f32,
    spring_bias: f32,
    // 0 if the surfaces are apart, 1 if they overlap, 2 if so by more than `TOUCHING_DEPTH`.
    depth: u32,
}

// Lever arms on two bodies, m.
struct Arms {
    a: vec3<f32>,
    b: vec3<f32>,
}

// How far a contact point's surfaces are apart, and its lever arms.
struct Gap {
    // At the substep's start.
    arms: Arms,
    // Separation less the rest offset at the substep's start, m.
    found: f32,
    // The same as the row has it, if the bodies were where they began the substep.
    start: f32,
    // `Contact::rest`, m.
    rest: f32,
}

// Friction of a patch: two directions at the centre of pressure and the twist about the normal.
struct Friction {
    // The directions.
    u: vec3<f32>,
    // Effective mass, the smaller one: with one each, what slides would be drawn aside. kg
    mass: f32,
    v: vec3<f32>,
    // Effective moment of inertia about the normal, kg m².
    mass_twist: f32,
    // Torques of unit impulses about either body, in its frame.
    u_a: vec3<f32>,
    // What the points' impulses after the last rigid sweep allow: N s along the surface, N m s about the normal.
    limit: f32,
    u_b: vec3<f32>,
    twist_limit: f32,
    v_a: vec3<f32>,
    // Accumulated along both directions, N s, and about the normal, N m s.
    impulse_u: f32,
    v_b: vec3<f32>,
    impulse_v: f32,
    // Unit torques about the normal, in the bodies' frames.
    twist_a: vec3<f32>,
    impulse_twist: f32,
    twist_b: vec3<f32>,
}

// Lever arms of a patch.
struct Levers {
    // Of its centre at the substep's start.
    center: Arms,
    // For which motion its rows were made, as in `Motion`.
    passed: vec3<f32>,
    rolled_a: vec3<f32>,
    rolled_b: vec3<f32>,
}

// Invocations that share a candidate's patches before and after the small steps.
const PATCH_LANES: u32 = 32u;

// A candidate has at most one patch for so many slots of contact points, or its slots are doubled as if there were too
// few.
const SLOTS_PER_PATCH: u32 = 4u;

fn patch_rows(contacts: u32) -> u32 {
    return (contacts + SLOTS_PER_PATCH - 1u) / SLOTS_PER_PATCH;
}

// How far the solver has come with a candidate's substep; before the first one, with the sweeps that find its loads.
struct Cursor {
    // Small steps that are done.
    step: u32,
    // The next sweep of the present one.
    sweep: u32,
}

// One scalar constraint between two bodies: the relative velocity of their touching points along `axis`.
struct Row {
    axis: vec3<f32>,
    torque_a: vec3<f32>,
    torque_b: vec3<f32>,
}

fn matrix_of(axes: Axes) -> mat3x3<f32> {
    return mat3x3(axes.x, axes.y, axes.z);
}

// What a body's frame has, in the world.
fn from_frame(axes: Axes, v: vec3<f32>) -> vec3<f32> {
    return vec3(dot(axes.x, v), dot(axes.y, v), dot(axes.z, v));
}

fn inverse_of(k: f32) -> f32 {
    return select(0.0, 1.0 / k, k > 0.0);
}

// Effective mass of a row between bodies whose inverse masses add up to so much.
fn mass_of(row: Row, inverse_mass: f32) -> f32 {
    let turning = dot(row.torque_a, row.torque_a) + dot(row.torque_b, row.torque_b);
    return inverse_of(dot(row.axis, row.axis) * inverse_mass + turning);
}

// The row along `axis` of a point with these lever arms.
fn row_along(axis: vec3<f32>, arms: Arms, a: mat3x3<f32>, b: mat3x3<f32>) -> Row {
    return Row(axis, times(a, cross(arms.a, axis)), times(b, cross(arms.b, axis)));
}

// Sets the rows of a patch's friction at its lever arms.
fn aim_friction(friction: ptr<function, Friction>, arms: Arms, a: mat3x3<f32>, b: mat3x3<f32>, inverse_mass: f32) {
    let u = row_along((*friction).u, arms, a, b);
    let v = row_along((*friction).v, arms, a, b);
    (*friction).u_a = u.torque_a;
    (*friction).u_b = u.torque_b;
    (*friction).v_a = v.torque_a;
    (*friction).v_b = v.torque_b;
    (*friction).mass = min(mass_of(u, inverse_mass), mass_of(v, inverse_mass));
}

// Which of `count` points of a patch comes as the `k`-th of a sweep: every third, so that points across the patch
// follow one another.
fn turn_of(k: u32, count: u32) -> u32 {
    return select(3u * k % count, k, count % 3u == 0u);
}

// The first of two unit vectors that make a right-handed frame with `normal`.
fn tangent(normal: vec3<f32>) -> vec3<f32> {
    let side = select(vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), abs(normal.x) < 0.8);
    return unit(side - normal * dot(normal, side));
}
