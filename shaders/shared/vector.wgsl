// Products and unit vectors with every operation in the order of the processor's (glam), so that both give the same
// bits: `*` of matrices, `normalize` and `dot` leave the order, and division or reciprocal, to the driver.

fn times(m: mat3x3<f32>, v: vec3<f32>) -> vec3<f32> {
    return m[0] * v.x + m[1] * v.y + m[2] * v.z;
}

// `start` plus a cross product: of a sum of two cross products the driver would choose the order.
fn plus_cross(start: vec3<f32>, u: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    return vec3(
        start.x + u.y * v.z - u.z * v.y,
        start.y + u.z * v.x - u.x * v.z,
        start.z + u.x * v.y - u.y * v.x,
    );
}

fn unit(v: vec3<f32>) -> vec3<f32> {
    return v * (1.0 / length(v));
}

// Cosine with the normal of a plane.
fn plane_cosine(v: vec3<f32>, plane: vec4<f32>) -> f32 {
    return (v.x * plane.x + v.z * plane.z) + v.y * plane.y;
}
