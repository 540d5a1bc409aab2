// Axis-aligned boxes, m.

struct Bounds {
    center: vec3<f32>,
    // Half the distance to an equal body at which contacts are made, m.
    margin: f32,
    half_extents: vec3<f32>,
}

fn overlaps(a: Bounds, b: Bounds, margin: f32) -> bool {
    return all(abs(a.center - b.center) <= a.half_extents + b.half_extents + margin);
}
