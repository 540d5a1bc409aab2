// Triangles as they are seen: solid (with holes or as glass too), ground and wall. Twin: `cpu::raster`.
#import light

struct View {
    clip: mat4x4<f32>,
    eye: vec3<f32>,
    pixel: f32,
    background: vec3<f32>,
    exposure: f32,
    bounce: vec3<f32>,
    grid: f32,
    center: vec3<f32>,
    radius: f32,
    suns: u32,
    skies: u32,
    grid_at: vec2<f32>,
}

struct Vertex {
    position: vec3<f32>,
    normal: u32,
    uv: vec2<f32>,
    color: u32,
    detail: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> lights: array<Light>;
@group(0) @binding(2) var sun_depths: texture_depth_2d_array;
@group(0) @binding(3) var sky_depths: texture_depth_2d_array;
@group(0) @binding(4) var nearer: sampler_comparison;
@group(0) @binding(5) var<storage, read> vertices: array<Vertex>;
@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var between: sampler;
// What is less opaque is a hole.
@group(1) @binding(2) var<uniform> cutoff: f32;

struct Fragment {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(perspective, centroid) position: vec3<f32>,
    @location(1) @interpolate(perspective, centroid) normal: vec3<f32>,
    @location(2) @interpolate(perspective, centroid) uv: vec2<f32>,
    @location(3) @interpolate(perspective, centroid) color: vec4<f32>,
    @location(4) @interpolate(flat) detail: f32,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Fragment {
    let it = vertices[index];
    let color = unpack4x8unorm(it.color);
    let clip = view.clip * vec4(it.position, 1.0);
    return Fragment(clip, it.position, unpack_normal(it.normal), it.uv, vec4(linear(color.rgb), color.a), it.detail);
}

@fragment
fn solid(it: Fragment, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    return shaded(it, front);
}

// A stage of its own, because one that may drop a pixel cannot be told beforehand that it is hidden.
@fragment
fn holed(it: Fragment, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    if it.color.a * texel(it).a < cutoff {
        discard;
    }
    return shaded(it, front);
}

@fragment
fn ground(it: Fragment) -> @location(0) vec4<f32> {
    let away = distance(it.position, view.eye);
    let fade = smoothstep(1.5, 3.2, distance(it.position.xz, view.center.xz) / view.radius);
    var share = vec3(1.0);
    if fade < 1.0 {
        let light = illumination(it.position, vec3(0.0, 1.0, 0.0));
        // A line is one thousandth of the scene wide, and never narrower than a pixel.
        let steep = max(abs(view.eye.y - it.position.y) / max(away, 1e-6), 0.02);
        let soft = 0.75 * view.pixel * away / steep;
        let at = (it.position.xz - view.grid_at) / view.grid;
        let off = abs(at - round(at)) * view.grid;
        let half = 0.0015 * view.radius;
        let line = clamp((half + soft - min(off.x, off.y)) / (2.0 * soft), 0.0, 1.0) * min(half / soft, 1.0);
        share = light.lit / light.open * (1.0 - 0.16 * line);
    }
    return vec4(view.background * mix(share, vec3(1.0), fade), 1.0);
}

@fragment
fn wall(it: Fragment, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    if !front {
        return vec4(0.5 * view.background, 0.06);
    }
    let light = illumination(it.position, normalize(it.normal));
    return vec4(vec3(0.86, 0.85, 0.83) * light.lit / light.open, 0.6);
}

fn shaded(it: Fragment, front: bool) -> vec4<f32> {
    let normal = normalize(it.normal) * select(-1.0, 1.0, front);
    let light = illumination(it.position, normal).lit;
    let color = 1.0 - exp(-view.exposure * it.color.rgb * texel(it).rgb * light);
    return vec4(color, it.color.a);
}

fn texel(it: Fragment) -> vec4<f32> {
    let level = log2(max(it.detail * view.pixel * distance(it.position, view.eye), 1.0));
    return textureSampleLevel(image, between, it.uv, level);
}

struct Illumination {
    // With and without shadows.
    lit: vec3<f32>,
    open: vec3<f32>,
}

fn illumination(p: vec3<f32>, normal: vec3<f32>) -> Illumination {
    let below = view.bounce * (0.5 - 0.5 * normal.y);
    var found = Illumination(below, below);
    for (var i = 0u; i < view.suns; i++) {
        let light = lights[i];
        let facing = dot(normal, light.toward);
        if facing > 0.0 {
            let at = place(light, p + normal * light.offset);
            let depth = min(at.z - light.bias, 1.0);
            let share = textureSampleCompareLevel(sun_depths, nearer, at.xy, i, depth);
            found.open += facing * light.color;
            found.lit += facing * share * light.color;
        }
    }
    for (var i = 0u; i < view.skies; i++) {
        let light = lights[view.suns + i];
        let facing = dot(normal, light.toward);
        if facing > 0.0 {
            let at = place(light, p + normal * light.offset);
            let depth = min(at.z - light.bias, 1.0);
            let share = textureSampleCompareLevel(sky_depths, nearer, at.xy, i, depth);
            found.open += facing * light.color;
            found.lit += facing * share * light.color;
        }
    }
    return found;
}

// sRGB to linear light.
fn linear(c: vec3<f32>) -> vec3<f32> {
    return select(pow((c + 0.055) / 1.055, vec3(2.4)), c / 12.92, c <= vec3(0.04045));
}

// A unit vector from its octahedral shares.
fn unpack_normal(packed: u32) -> vec3<f32> {
    let flat = unpack2x16snorm(packed);
    let y = 1.0 - abs(flat.x) - abs(flat.y);
    let fold = max(-y, 0.0);
    let side = select(vec2(-1.0), vec2(1.0), flat >= vec2(0.0));
    return normalize(vec3(flat.x - fold * side.x, y, flat.y - fold * side.y));
}
