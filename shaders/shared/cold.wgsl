// Small steps that would add energy are solved again from nothing; as `src/cpu/solve/cold.rs`. Part of `small_steps`.

// True if the bodies have more kinetic energy than before the impulses of the small step.
fn gains_energy(share: Share) -> bool {
    var energy = 0.0;
    var bound = 0.0;
    for (var i = share.moving; i < share.moving + batch.bodies; i++) {
        let body = moving[i];
        if (body.inverse_mass == 0.0) {
            continue;
        }
        energy += dot(body.linear, body.linear) / body.inverse_mass;
        energy += dot(body.spin, body.spin);
        bound += body.allowed;
    }
    return energy > bound;
}

// Takes the impulses of the small step back, and what they moved.
fn start_cold(share: Share) {
    for (var body = share.lane; body < batch.bodies; body += share.lanes) {
        let i = share.moving + body;
        if (moving[i].inverse_mass == 0.0) {
            continue;
        }
        let before = free[share.far_moving + body];
        moving[i].linear = before.linear;
        moving[i].spin = before.spin;
        moving[i].shift = before.shift;
        moving[i].turn = before.turn;
        moving[i].restless = ATTEMPT + MIN_PUSHING_SWEEPS - 1u;
    }
    for (var p = share.lane; p < share.patches; p += share.lanes) {
        let row = friction_row(share, p);
        frictions[row].impulse_u = 0.0;
        frictions[row].impulse_v = 0.0;
        frictions[row].impulse_twist = 0.0;
        frictions[row].limit = 0.0;
        frictions[row].twist_limit = 0.0;
        let link = link_at(share, p);
        let first = point_row(share, p, link);
        for (var k = 0u; k < link.count; k++) {
            normals[first + k].impulse = 0.0;
        }
    }
}
