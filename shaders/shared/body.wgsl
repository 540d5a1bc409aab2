// Bodies and units, the same for all candidates.

// `Body::unit` of a body that never moves.
const STATIC: u32 = 0xffffffffu;

struct Body {
    first_hull: u32,
    hull_count: u32,
    unit: u32,
    // 1 / kg, 0 if static.
    inverse_mass: f32,
    // 1 / (kg m²) about the principal axes, 0 if static.
    inverse_inertia: vec3<f32>,
    // Largest distance of a vertex from the centre of mass, m.
    radius: f32,
}

struct Unit {
    // Point about which the adjustment turns, m.
    pivot: vec3<f32>,
    root: u32,
}
