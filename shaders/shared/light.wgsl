// A direction that light comes from, with its map of depths.
struct Light {
    u: vec4<f32>,
    v: vec4<f32>,
    depth: vec4<f32>,
    toward: vec3<f32>,
    offset: f32,
    bias: f32,
}

// Across and down the map, both from 0 to 1, and the depth.
fn place(light: Light, p: vec3<f32>) -> vec3<f32> {
    let q = vec4(p, 1.0);
    return vec3(dot(light.u, q), dot(light.v, q), dot(light.depth, q));
}
