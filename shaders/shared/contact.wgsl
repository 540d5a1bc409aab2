// What collision detection hands on, stage by stage. Normals point from the first body or hull to the second.

// `Patch::a` of a contact with the ground.
const GROUND: u32 = 0xffffffffu;

// Two hulls whose boxes overlap.
struct HullPair {
    pair: u32,
    a: u32,
    b: u32,
    // Feature of the last substep's axis: kind << 24 | first << 12 | second, as `cpu::narrow_phase::PairCache`; 0:
    // none.
    cache: u32,
}

// The axis of a hull pair.
struct Separation {
    normal: vec3<f32>,
    // Gap along the axis, m; negative: depth.
    distance: f32,
    // Coded as `HullPair::cache`; 0: farther apart than the margin.
    feature: u32,
}

// Head of a hull pair's contact points, which lie in a table of their own.
struct Manifold {
    normal: vec3<f32>,
    count: u32,
}

struct ManifoldPoint {
    on_a: vec3<f32>,
    // m
    separation: f32,
    on_b: vec3<f32>,
}

// Contact points of two bodies in about one direction.
struct Patch {
    normal: vec3<f32>,
    // Number of the body pair; past the last, the body's contact with the ground.
    pair: u32,
    // Tangential impulse on `b` of the last small step, N s.
    friction: vec3<f32>,
    // Angular impulse about the normal on `b` of the last small step, N m s.
    twist: f32,
    a: u32,
    b: u32,
    first: u32,
    count: u32,
}

struct Contact {
    normal: vec3<f32>,
    // m
    separation: f32,
    // Middle between the two surfaces, world, m.
    point: vec3<f32>,
    // Normal impulse of the last small step, N s.
    impulse: f32,
    // The point in the frame of the first body (the world for the ground), m.
    anchor_a: vec3<f32>,
    // Load carried on average lately, N s a small step.
    load: f32,
    // The point in the frame of the second body, m.
    anchor_b: vec3<f32>,
    // The separation when the point was found, m.
    found: f32,
    // Separation less the rest offset at which its spring is at rest, m; 0 before the first substep.
    rest: f32,
}
