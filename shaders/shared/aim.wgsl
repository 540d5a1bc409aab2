// What the impulse of a contact works towards.

#import constants
#import sim
#import solver

const TAU: f32 = 6.2831853;

// Sets what a contact's impulse works towards at this separation (m): an implicit damped spring over a small step (E. Catto,
// "Soft Constraints", GDC 2011) where the surfaces overlap; what is still apart may come no closer than touching.
fn aim(normal: ptr<function, Normal>, separation: f32) {
    let h = sim.small_step;
    let omega = TAU * min(CONTACT_FREQUENCY, CONTACT_FREQUENCY_SHARE / h);
    let a1 = 2.0 * CONTACT_DAMPING_RATIO + h * omega;
    let a2 = h * omega * a1;
    let a3 = 1.0 / (1.0 + a2);
    let overlaps = separation <= 0.0;
    let deep = DEEP_PUSH_OUT_RATE * min(separation + TOUCHING_DEPTH, 0.0);
    let push_out = max(omega / a1 * (separation - (*normal).rest) + deep, -sim.max_push_out);
    (*normal).rigid_bias = max(separation, 0.0) / h;
    (*normal).spring_bias = select((*normal).rigid_bias, push_out, overlaps);
    (*normal).spring_mass = (*normal).mass * select(1.0, a2 * a3, overlaps);
    (*normal).leak = select(0.0, a3, overlaps);
    (*normal).tolerance = select(PUSHED_SPEED * (*normal).mass, 3.4e38, separation < -TOUCHING_DEPTH);
}
