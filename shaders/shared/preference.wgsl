// Which of several axes that part two hulls is taken.

// By how much faces of the larger hull are preferred to the other's, and faces to edges, m and as a share of the depth; and
// ways to the side to ways down.
struct Preference {
    bias: f32,
    relative: f32,
    // How many times more the part of a way out counts that leads into the ground.
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

// How far a body can be pushed down without standing in the ground, m: as `BroadPhase::room`, with a hull of the other body.
fn room_under(body: Bounds, hull: Bounds, other: Body) -> f32 {
    let narrower = all(body.half_extents.xz <= hull.half_extents.xz);
    let gap = max(hull.center.y - hull.half_extents.y, 0.0);
    let barred = other.unit == STATIC && narrower && gap < ROOM_SHARE * 2.0 * body.half_extents.y;
    return select(FAR, max(body.center.y - body.half_extents.y, 0.0) + COHERENT_DEPTH, barred);
}

// A distance along an axis (world frame, first to second) less what the way into the ground adds: as `HullPair::detour`.
fn worth_of(preference: Preference, room: vec2<f32>, axis: vec3<f32>, distance: f32) -> f32 {
    let below = -distance * abs(axis.y) - select(room.x, room.y, axis.y < 0.0);
    return distance - preference.ground * max(below, 0.0);
}
