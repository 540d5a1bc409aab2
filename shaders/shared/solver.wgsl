// What the solver keeps of a candidate during a substep, as `src/cpu/solve/`. Tables have `Batch::bodies + 1` rows a
// candidate for bodies (the last is the ground), `Sim::contacts` for patches and points.

#import vector

// State of a body.
struct Moving {
    // m/s
    linear: vec3<f32>,
    inverse_mass: f32,
    // rad/s
    angular: vec3<f32>,
    // 1 if it has contacts, or may come to touch something.
    touched: u32,
    // Shift and turn since the substep's start, m and rad.
    shift: vec3<f32>,
    // The number of the last sweep of the small step in which its contacts are solved.
    restless: u32,
    turn: vec3<f32>,
    // Columns of the world inverse inertia, 1 / (kg m²).
    inertia_x: vec3<f32>,
    inertia_y: vec3<f32>,
    inertia_z: vec3<f32>,
}

// A contact point ready to solve.
struct Normal {
    axis: vec3<f32>,
    // Effective mass, kg.
    mass: f32,
    angular_a: vec3<f32>,
    // Separation at the substep's start less the rest offset, m.
    separation: f32,
    angular_b: vec3<f32>,
    // Distance from the patch's centre, m: lever of its friction against twisting.
    lever: f32,
    // Accumulated impulse of one small step, N s.
    impulse: f32,
    // The impulse after the last rigid sweep: what bounds friction.
    rigid: f32,
    // `Contact::load`
    load: f32,
}

// Friction of a patch: two directions at the centre of pressure and the twist about the normal.
struct Friction {
    // Lever arms of the centre, m.
    arm_a: vec3<f32>,
    // Effective masses, kg and kg m².
    mass_u: f32,
    arm_b: vec3<f32>,
    mass_v: f32,
    // How far the second body had moved past the first when the lever arms were made, m.
    passed: vec3<f32>,
    mass_twist: f32,
    // Accumulated along both directions, N s, and about the normal, N m s.
    impulse: vec3<f32>,
}

// How far the solver has come with a candidate's substep.
struct Cursor {
    // Small steps that are done.
    step: u32,
    // Sweeps of the present one that are done, and after how many it ends.
    sweep: u32,
    end: u32,
}

// One scalar constraint between two bodies: the relative velocity of their touching points along `axis`.
struct Row {
    axis: vec3<f32>,
    angular_a: vec3<f32>,
    angular_b: vec3<f32>,
}

fn inertia_of(body: Moving) -> mat3x3<f32> {
    return mat3x3(body.inertia_x, body.inertia_y, body.inertia_z);
}

// Effective mass of a row.
fn mass_of(row: Row, a: Moving, b: Moving) -> f32 {
    let k = dot(row.axis, row.axis) * (a.inverse_mass + b.inverse_mass)
        + dot(row.angular_a, times(inertia_of(a), row.angular_a))
        + dot(row.angular_b, times(inertia_of(b), row.angular_b));
    return select(0.0, 1.0 / k, k > 0.0);
}

// The row along `axis` of a point with these lever arms.
fn row_along(axis: vec3<f32>, arm_a: vec3<f32>, arm_b: vec3<f32>) -> Row {
    return Row(axis, cross(arm_a, axis), cross(arm_b, axis));
}

// The row of the relative spin about `axis`.
fn row_about(axis: vec3<f32>) -> Row {
    return Row(vec3(0.0), axis, axis);
}

// The first of two unit vectors that make a right-handed frame with `normal`.
fn tangent(normal: vec3<f32>) -> vec3<f32> {
    let side = select(vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), abs(normal.x) < 0.8);
    return unit(side - normal * dot(normal, side));
}
