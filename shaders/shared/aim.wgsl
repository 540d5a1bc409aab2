// What the impulse of a contact works towards.

#import constants
#import sim
#import solver

const TAU: f32 = 6.2831853;

// Spring coefficients of a soft contact over a small step: an implicit damped spring (E. Catto, "Soft Constraints", GDC
// 2011).
struct Softness {
    // Share of the overlap pushed out per second, 1/s.
    bias_rate: f32,
    mass_scale: f32,
    impulse_scale: f32,
}

fn softness() -> Softness {
    let h = sim.small_step;
    let omega = TAU * min(CONTACT_FREQUENCY, CONTACT_FREQUENCY_SHARE / h);
    let a1 = 2.0 * CONTACT_DAMPING_RATIO + h * omega;
    let a2 = h * omega * a1;
    let a3 = 1.0 / (1.0 + a2);
    return Softness(omega / a1, a2 * a3, a3);
}

// Sets what a contact's impulse works towards at this separation (m): a spring where the surfaces overlap; what is
// still apart may come no closer than touching.
fn aim(normal: ptr<function, Normal>, separation: f32, rest: f32) {
    let deep = DEEP_PUSH_OUT_RATE * min(separation + TOUCHING_DEPTH, 0.0);
    let push_out = max(softness().bias_rate * (separation - rest) + deep, -sim.max_push_out);
    (*normal).rigid_bias = max(separation, 0.0) / sim.small_step;
    (*normal).spring_bias = select((*normal).rigid_bias, push_out, separation <= 0.0);
    (*normal).depth = u32(separation <= 0.0) + u32(separation < -TOUCHING_DEPTH);
}
