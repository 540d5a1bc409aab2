// Parameters of the simulation, the same for all candidates.

struct Sim {
    // Length of a substep and of a small step, s.
    substep: f32,
    small_step: f32,
    small_steps: u32,
    velocity_iterations: u32,
    // m
    contact_offset: f32,
    rest_offset: f32,
    // m/s²
    gravity: f32,
    // m/s
    max_push_out: f32,
    // 1/s
    linear_damping: f32,
    angular_damping: f32,
    friction: f32,
    // Slots of a candidate: hull pairs, and patches as well as contact points.
    hull_pairs: u32,
    contacts: u32,
    // How often all loops of an invocation together may go round.
    loops: u32,
}
