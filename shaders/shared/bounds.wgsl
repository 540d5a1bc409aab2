// Axis-aligned boxes, m.

struct Bounds {
    center: vec3<f32>,
    // Half the distance to an equal body at which contacts are made, m.
    margin: f32,
    half_extents: vec3<f32>,
    // 1 if the body keeps its contacts with others that keep theirs; of bodies' boxes only.
    is_still: u32,
}

// Where a body was when its contacts were last found; all zero if they never were.
struct Mark {
    rotation: vec4<f32>,
    translation: vec3<f32>,
    // Its margin then.
    margin: f32,
}

fn keep(a: Bounds, b: Bounds) -> bool {
    return a.is_still == 1u && b.is_still == 1u;
}

fn overlaps(a: Bounds, b: Bounds, margin: f32) -> bool {
    return all(abs(a.center - b.center) <= a.half_extents + b.half_extents + margin);
}
