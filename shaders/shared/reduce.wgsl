// Chooses the few of many contact points that support a body as well as all of them: as `cpu::narrow_phase::reduce`.
//
// Offer all points, then take the eight extremes in their order, each only if it `is_new` among those taken.

#import constants

const LOWEST: f32 = -3.4e38;

// Directions in which the farthest point is kept; the other four are opposite.
const DIRECTIONS_X = vec4<f32>(0.955336, 0.466559, -0.295520, -0.884490);
const DIRECTIONS_Y = vec4<f32>(0.295520, 0.884490, 0.955336, 0.466559);

struct Extremes {
    reach: vec4<f32>,
    opposite_reach: vec4<f32>,
    point: vec4<u32>,
    opposite_point: vec4<u32>,
}

fn no_extremes() -> Extremes {
    return Extremes(vec4(LOWEST), vec4(LOWEST), vec4(0u), vec4(0u));
}

// `flat`: the point across the normal, m. `gap`: how much farther than the deepest, m.
fn offer(extremes: ptr<function, Extremes>, flat_point: vec2<f32>, gap: f32, number: u32) {
    let along = DIRECTIONS_X * flat_point.x + DIRECTIONS_Y * flat_point.y;
    let distance = along - GAP_PENALTY * gap;
    let opposite = -along - GAP_PENALTY * gap;
    let farther = distance > (*extremes).reach + SAME_POINT;
    let opposite_farther = opposite > (*extremes).opposite_reach + SAME_POINT;
    (*extremes).reach = select((*extremes).reach, distance, farther);
    (*extremes).opposite_reach = select((*extremes).opposite_reach, opposite, opposite_farther);
    (*extremes).point = select((*extremes).point, vec4(number), farther);
    (*extremes).opposite_point = select((*extremes).opposite_point, vec4(number), opposite_farther);
}

fn extreme(extremes: Extremes, k: u32) -> u32 {
    return select(extremes.opposite_point[k & 3u], extremes.point[k & 3u], k < 4u);
}

fn is_new(taken: ptr<function, array<vec4<f32>, MAX_MANIFOLD_POINTS>>, count: u32, p: vec3<f32>) -> bool {
    var fresh = true;
    for (var i = 0u; i < count; i++) {
        let apart = (*taken)[i].xyz - p;
        fresh &= dot(apart, apart) >= SAME_POINT * SAME_POINT;
    }
    return fresh;
}

// A unit vector across `normal`; the second tangent is `cross(normal, first)`.
fn tangent(normal: vec3<f32>) -> vec3<f32> {
    let side = select(vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), abs(normal.x) < 0.8);
    return normalize(side - normal * dot(normal, side));
}
