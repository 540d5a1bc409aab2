// Contacts go with bodies that have moved since their rows were made; as `src/cpu/solve/follow.rs`.

#import constants
#import solver
#import vector

// How two bodies have moved since the substep's start.
struct Motion {
    // How far the second has moved past the first, m.
    passed: vec3<f32>,
    // How either has turned, rad, and how much of that is about axes that `Axes` calls round.
    turned_a: vec3<f32>,
    turned_b: vec3<f32>,
    rolled_a: vec3<f32>,
    rolled_b: vec3<f32>,
    // Whether both are free.
    is_free: bool,
}

fn motion_of(a: Moving, b: Moving, axes_a: Axes, axes_b: Axes) -> Motion {
    let round_a = vec3(axes_a.round_x, axes_a.round_y, axes_a.round_z);
    let round_b = vec3(axes_b.round_x, axes_b.round_y, axes_b.round_z);
    return Motion(
        b.shift - a.shift,
        from_frame(axes_a, a.turn),
        from_frame(axes_b, b.turn),
        from_frame(axes_a, a.turn * round_a),
        from_frame(axes_b, b.turn * round_b),
        a.inverse_mass > 0.0 && b.inverse_mass > 0.0,
    );
}

fn exceeds(vector: vec3<f32>, length: f32) -> bool {
    return dot(vector, vector) >= length * length;
}

// True if the motion differs from that for which the rows were made so much that lever arms do.
fn is_far(motion: Motion, levers: Levers) -> bool {
    return exceeds(motion.rolled_a - levers.rolled_a, TURN_TOLERANCE)
        || exceeds(motion.rolled_b - levers.rolled_b, TURN_TOLERANCE)
        || (motion.is_free && exceeds(motion.passed - levers.passed, ARM_TOLERANCE));
}

// Lever arms that were `arms` at first. Two free bodies push at a common point, half-way between where either has it:
// else their impulses would turn the pair. On something fixed a contact's points go with the body that moves.
fn arms_after(motion: Motion, arms: Arms) -> Arms {
    let by = plus_cross(cross(motion.rolled_a, arms.a), motion.rolled_b, arms.b);
    if (motion.is_free) {
        return Arms(arms.a + 0.5 * (by + motion.passed), arms.b + 0.5 * (by - motion.passed));
    }
    return Arms(arms.a + by, arms.b + by);
}

// How far a point of the second body has moved past that of the first, with these lever arms at first, going straight
// on.
fn moved_by(motion: Motion, arms: Arms) -> vec3<f32> {
    return plus_cross(plus_cross(motion.passed, motion.turned_b, arms.b), arms.a, motion.turned_a);
}

// How far the touching points have moved apart since the substep's start, as the row has it, m.
fn moved(n: Normal, passed: vec3<f32>, a: Moving, b: Moving) -> f32 {
    return dot(n.axis, passed) + dot(n.torque_b, b.turn) - dot(n.torque_a, a.turn);
}
