// How far what casts shadows is from one light. Twin: `cpu::raster::depths`.
#import light

@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var<storage, read> positions: array<vec4<f32>>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let at = place(light, positions[index].xyz);
    return vec4(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y, at.z, 1.0);
}
