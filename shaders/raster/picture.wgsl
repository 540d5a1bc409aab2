// Triangles as they are seen: solid (with holes or as glass too), ground and wall. Twin: `cpu::raster`.
//
// Shadows are smooth and dear, colours are neither: a first pass at half the resolution (`shadow`) finds out which
// share of the light arrives, and the picture takes it from there wherever it lies in the same plane. A wall is cut
// into small triangles, at whose corners that is enough.
#import light
#import shading

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
    forward: vec3<f32>,
    width: f32,
    across: vec3<f32>,
    height: f32,
    upward: vec3<f32>,
    sun: vec3<f32>,
    sky: vec3<f32>,
    open: array<vec4<f32>, 10>,
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

// Shares of the sun's and the sky's light that arrive, the distance to the eye, 0 where nothing is, and the normal.
@group(2) @binding(0) var shares: texture_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Fragment {
    return corner(index);
}

fn corner(index: u32) -> Fragment {
    let it = vertices[index];
    let color = unpack4x8unorm(it.color);
    let clip = view.clip * vec4(it.position, 1.0);
    return Fragment(clip, it.position, unpack_normal(it.normal), it.uv, vec4(linear(color.rgb), color.a), it.detail);
}

@vertex
fn wall_vertex(@builtin(vertex_index) index: u32) -> Fragment {
    var it = corner(index);
    it.color = vec4(share(it.position, it.normal, 1u), 0.0, 1.0);
    return it;
}

@fragment
fn shadow(it: Fragment, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    return shade(it, front);
}

fn shade(it: Fragment, front: bool) -> vec4<f32> {
    let normal = facing(it, front);
    return vec4(share(it.position, normal, 1u), distance(it.position, view.eye), number(normal));
}

@fragment
fn holed_shadow(it: Fragment, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    if it.color.a * texel(it).a < cutoff {
        discard;
    }
    return shade(it, front);
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
    let fade = smoothstep(FADE_FROM, FADE_TO, distance(it.position.xz, view.center.xz) / view.radius);
    var share = vec3(1.0);
    if fade < 1.0 {
        // A line is never narrower than a pixel.
        let steep = max(abs(view.eye.y - it.position.y) / max(away, LEAST_AWAY), FLATTEST_VIEW);
        let soft = LINE_EDGE * view.pixel * away / steep;
        let at = (it.position.xz - view.grid_at) / view.grid;
        let off = abs(at - round(at)) * view.grid;
        let half = LINE * view.radius;
        let line = clamp((half + soft - min(off.x, off.y)) / (2.0 * soft), 0.0, 1.0) * min(half / soft, 1.0);
        let up = vec3(0.0, 1.0, 0.0);
        share = light(up, arriving(it, up)) / light(up, vec2(1.0)) * (1.0 - LINE_SHADE * line);
    }
    return vec4(view.background * mix(share, vec3(1.0), fade), 1.0);
}

@fragment
fn wall(it: Fragment, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    if !front {
        return vec4(BACK * view.background, BACK_OPACITY);
    }
    let normal = normalize(it.normal);
    let share = light(normal, it.color.xy) / light(normal, vec2(1.0));
    return vec4(vec3(WALL_RED, WALL_GREEN, WALL_BLUE) * mix(vec3(1.0), share, WALL_SHADE), WALL_OPACITY);
}

fn shaded(it: Fragment, front: bool) -> vec4<f32> {
    let normal = facing(it, front);
    let color = 1.0 - exp(-view.exposure * it.color.rgb * texel(it).rgb * light(normal, arriving(it, normal)));
    return vec4(color, it.color.a);
}

fn texel(it: Fragment) -> vec4<f32> {
    let level = log2(max(it.detail * view.pixel * distance(it.position, view.eye), 1.0));
    return textureSampleLevel(image, between, it.uv, level);
}

// Unit normal on the side that is seen.
fn facing(it: Fragment, front: bool) -> vec3<f32> {
    return normalize(it.normal) * select(-1.0, 1.0, front);
}

// Shares of the sun's and the sky's light that arrive at a pixel: those of the four places around it at half the
// resolution, as far as they lie in its plane and face as it does.
fn arriving(it: Fragment, normal: vec3<f32>) -> vec2<f32> {
    let size = vec2(view.width, view.height);
    let at = 0.5 * it.clip.xy - 0.5;
    let corner = floor(at);
    let part = at - corner;
    let tolerance = OFF_PLANE * view.pixel * distance(it.position, view.eye);
    var sum = vec3(0.0);
    for (var i = 0u; i < 4u; i++) {
        let step = vec2(f32(i & 1u), f32(i >> 1u));
        let cell = clamp(corner + step, vec2(0.0), ceil(0.5 * size) - 1.0);
        let there = textureLoad(shares, vec2<i32>(cell), 0);
        let place = (4.0 * cell + 2.0) / size - 1.0;
        let ray = normalize(view.forward + view.across * place.x - view.upward * place.y);
        let off = dot(view.eye + ray * there.z - it.position, normal) / tolerance;
        let alike = pow(max(dot(normal, normal_of(there.w)), 0.0), f32(ALIKE));
        let near = mix(1.0 - part, part, step);
        let weight = near.x * near.y * alike / (1.0 + off * off * off * off) * f32(there.z > 0.0);
        sum += weight * vec3(there.xy, 1.0);
    }
    let missing = sum.z < LEAST_KNOWN;
    let exact = share(it.position, normal, select(0u, SPARSE, missing));
    return select(sum.xy / sum.z, exact, missing);
}

// Light that falls onto a surface, given the shares of the sun's and the sky's that arrive: the cosines of all lights
// up to their squares (Ramamoorthi and Hanrahan, "An efficient representation for irradiance environment maps", 2001).
fn light(n: vec3<f32>, shares: vec2<f32>) -> vec3<f32> {
    let linear = view.open[1] * n.x + view.open[2] * n.y + view.open[3] * n.z;
    let squares = view.open[4] * n.x * n.x + view.open[5] * n.y * n.y + view.open[6] * n.z * n.z;
    let products = view.open[7] * n.x * n.y + view.open[8] * n.y * n.z + view.open[9] * n.z * n.x;
    let open = shares * (view.open[0] + linear + squares + products).xy;
    return view.sun * open.x + view.sky * open.y + view.bounce * (0.5 - 0.5 * n.y);
}

// Shares of the light that arrive at a point of a surface, by every n-th light; by none if `every` is 0, because
// software adapters go through both sides of a branch, but through no loop that nobody needs.
fn share(p: vec3<f32>, normal: vec3<f32>, every: u32) -> vec2<f32> {
    let suns = select(0u, view.suns, every > 0u);
    let skies = select(0u, view.skies, every > 0u);
    let step = max(every, 1u);
    var all = vec2(NO_LIGHT);
    var lit = all;
    for (var i = 0u; i < suns; i += step) {
        let it = lights[i];
        let facing = max(dot(normal, it.toward), 0.0);
        let at = place(it, p + normal * (it.offset * (GRAZING - facing)));
        let free = textureSampleCompareLevel(sun_depths, nearer, at.xy, i, min(at.z - it.bias, 1.0));
        all.x += facing;
        lit.x += facing * free;
    }
    for (var i = 0u; i < skies; i += step) {
        let it = lights[view.suns + i];
        let facing = max(dot(normal, it.toward), 0.0);
        let at = place(it, p + normal * (it.offset * (GRAZING - facing)));
        let free = textureSampleCompareLevel(sky_depths, nearer, at.xy, i, min(at.z - it.bias, 1.0));
        all.y += facing;
        lit.y += facing * free;
    }
    return lit / all;
}

// A normal as a whole number below 2²⁴, and back.
fn number(n: vec3<f32>) -> f32 {
    let flat = n / (abs(n.x) + abs(n.y) + abs(n.z));
    let side = select(vec2(-1.0), vec2(1.0), flat.xz >= vec2(0.0));
    let folded = select(flat.xz, (1.0 - abs(flat.zx)) * side, flat.y < 0.0);
    let steps = round((0.5 + 0.5 * folded) * 4095.0);
    return steps.x * 4096.0 + steps.y;
}

fn normal_of(number: f32) -> vec3<f32> {
    let x = floor(number / 4096.0);
    return unfolded(vec2(x, number - 4096.0 * x) / 4095.0 * 2.0 - 1.0);
}

// sRGB to linear light.
fn linear(c: vec3<f32>) -> vec3<f32> {
    return select(pow((c + 0.055) / 1.055, vec3(2.4)), c / 12.92, c <= vec3(0.04045));
}

// A unit vector from its octahedral shares.
fn unpack_normal(packed: u32) -> vec3<f32> {
    return unfolded(unpack2x16snorm(packed));
}

fn unfolded(flat: vec2<f32>) -> vec3<f32> {
    let y = 1.0 - abs(flat.x) - abs(flat.y);
    let fold = max(-y, 0.0);
    let side = select(vec2(-1.0), vec2(1.0), flat >= vec2(0.0));
    return normalize(vec3(flat.x - fold * side.x, y, flat.y - fold * side.y));
}
