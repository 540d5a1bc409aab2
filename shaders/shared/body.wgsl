// Bodies and units, the same for all candidates.

#import constants

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

// As `Body::is_slender`.
fn is_slender(inverse_inertia: vec3<f32>) -> bool {
    return largest(inverse_inertia) > SLENDER_INERTIA_RATIO * min(inverse_inertia.x, min(inverse_inertia.y, inverse_inertia.z));
}

// As `Body::round_axes`.
fn round_axes(inverse_inertia: vec3<f32>) -> vec3<f32> {
    let most = select(0.0, largest(inverse_inertia), is_slender(inverse_inertia));
    return vec3<f32>(inverse_inertia >= vec3(most));
}

fn largest(v: vec3<f32>) -> f32 {
    return max(v.x, max(v.y, v.z));
}

struct Unit {
    // Point about which the adjustment turns, m.
    pivot: vec3<f32>,
    root: u32,
}
