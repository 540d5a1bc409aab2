// Which of several axes that part two hulls is taken.

// By how much faces of the larger hull are preferred to the other's, and faces to edges, m and as a share of the depth;
// and ways to the side to ways down.
struct Preference {
    bias: f32,
    relative: f32,
    // Most times that a way along the ground is longer than one into it.
    ground: f32,
}

fn preferred(preference: Preference, distance: f32) -> f32 {
    return preference.bias + preference.relative * max(-distance, 0.0);
}

// Whatever is worse than the remembered axis by more than both preferences cannot win.
fn least_worth(preference: Preference, room: vec2<f32>, axis: Separation) -> f32 {
    let worth = worth_of(preference, room, axis.normal, axis.distance);
    let floor = worth - 2.0 * preferred(preference, worth) - LINEAR_SLOP;
    return select(-FAR, floor, (axis.feature & REMEMBERED) != 0u);
}

// How far a body can be pushed down before the ground counts, m: as `BroadPhase::room`, with a hull of the other body.
fn room_under(body: Bounds, hull: Bounds, other: Body) -> f32 {
    let narrower = any(body.half_extents.xz <= hull.half_extents.xz);
    let bottom = max(body.center.y - body.half_extents.y, 0.0);
    let room = bottom + ROOM_SHARE * 2.0 * body.half_extents.y + COHERENT_DEPTH;
    return select(FAR, room, narrower & (other.unit == STATIC));
}

// What a distance along an axis (world frame, first to second) is worth beside others: as `HullPair::worth`.
fn worth_of(preference: Preference, room: vec2<f32>, axis: vec3<f32>, distance: f32) -> f32 {
    let barred = -distance * abs(axis.y) > select(room.x, room.y, axis.y < 0.0);
    let aside = max(sqrt(max(1.0 - axis.y * axis.y, 0.0)), 1.0 / preference.ground);
    return select(distance, distance / aside, barred);
}
