// Chooses the few of many contact points that support a body as well as all of them: as `cpu::narrow_phase::reduce`.
//
// Offer all points, then take them in `TRIES`, each only if it `is_new` among those taken, until all are or there is no
// place left: the extremes of the first round, what completes their polygon, the extremes of the other rounds.

#import constants
#import vector

const LOWEST: f32 = -3.4e38;

// Directions in which the farthest point is kept; the other four are opposite.
const DIRECTIONS_X = vec4<f32>(0.955336, 0.466559, -0.295520, -0.884490);
const DIRECTIONS_Y = vec4<f32>(0.295520, 0.884490, 0.955336, 0.466559);

// Four directions and their opposites.
struct Round {
    reach: vec4<f32>,
    opposite_reach: vec4<f32>,
    point: vec4<u32>,
    opposite_point: vec4<u32>,
}

// What a body rests on, what it may roll onto, and what it may land on.
struct Extremes {
    resting: Round,
    rolling: Round,
    landing: Round,
}

// Tries: eight of the first round, as many to complete it, sixteen of the others.
const RESTING: u32 = 8u;
const COMPLETE: u32 = RESTING + MAX_MANIFOLD_POINTS;
const ROLLING: u32 = COMPLETE + 8u;
const TRIES: u32 = ROLLING + 8u;

// The polygon on which a body rests, across the normal, counter-clockwise.
struct SupportPolygon {
    count: u32,
    corners: array<vec2<f32>, MAX_MANIFOLD_POINTS>,
}

// The point that bears farthest beyond that polygon: by how much, m (0: none does), its number, and that of the edge.
struct Missing {
    reach: f32,
    number: u32,
    edge: u32,
}

fn no_extremes() -> Extremes {
    let none = Round(vec4(LOWEST), vec4(LOWEST), vec4(0u), vec4(0u));
    return Extremes(none, none, none);
}

// `same`: points nearer than this are one, m.
fn offered(round: Round, along: vec4<f32>, penalty: f32, same: f32, number: u32) -> Round {
    let farther = along - penalty > round.reach + same;
    let opposite_farther = -along - penalty > round.opposite_reach + same;
    return Round(
        select(round.reach, along - penalty, farther),
        select(round.opposite_reach, -along - penalty, opposite_farther),
        select(round.point, vec4(number), farther),
        select(round.opposite_point, vec4(number), opposite_farther),
    );
}

// `flat_point`: the point across the normal, m. `height`: how much farther than the deepest, m.
fn offer(extremes: ptr<function, Extremes>, flat_point: vec2<f32>, height: f32, number: u32) {
    let along = DIRECTIONS_X * flat_point.x + DIRECTIONS_Y * flat_point.y;
    let resting = RESTING_PENALTY * max(height - BEARING_HEIGHT, 0.0);
    (*extremes).resting = offered((*extremes).resting, along, resting, SAME_RESTING_POINT, number);
    (*extremes).rolling = offered((*extremes).rolling, along, ROLLING_PENALTY * height, SAME_POINT, number);
    (*extremes).landing = offered((*extremes).landing, along, LANDING_PENALTY * height, SAME_POINT, number);
}

// The extreme that is the `k`-th try.
fn extreme(extremes: Extremes, k: u32) -> u32 {
    let j = k & 3u;
    let first = (k & 4u) == 0u;
    let resting = select(extremes.resting.opposite_point[j], extremes.resting.point[j], first);
    let rolling = select(extremes.rolling.opposite_point[j], extremes.rolling.point[j], first);
    let landing = select(extremes.landing.opposite_point[j], extremes.landing.point[j], first);
    return select(select(landing, rolling, k < ROLLING), resting, k < RESTING);
}

// Whether the `k`-th try is for what is missing.
fn completes(k: u32) -> bool {
    return k >= RESTING && k < COMPLETE;
}

// Adds what was taken in the `k`-th try. `missing`: what the try found if it `completes`.
fn extend(support: ptr<function, SupportPolygon>, k: u32, missing: Missing, flat_point: vec2<f32>) {
    if (k >= COMPLETE) {
        return;
    }
    let at = select((*support).count, missing.edge + 1u, completes(k));
    for (var i = (*support).count; i > at; i--) {
        (*support).corners[i] = (*support).corners[i - 1u];
    }
    (*support).corners[at] = flat_point;
    (*support).count += 1u;
}

// Keeps a point that bears if it is farther beyond the polygon.
fn offer_missing(
    missing: ptr<function, Missing>,
    support: ptr<function, SupportPolygon>,
    flat_point: vec2<f32>,
    number: u32,
) {
    var most = Missing(0.0, number, 0u);
    for (var k = 0u; k < (*support).count; k++) {
        let corner = (*support).corners[k];
        let edge = (*support).corners[select(0u, k + 1u, k + 1u < (*support).count)] - corner;
        let apart = flat_point - corner;
        let along = dot(apart, edge);
        let square = dot(edge, edge);
        let beside = along > 0.0 && along < square;
        let beyond = select(0.0, (apart.x * edge.y - apart.y * edge.x) / sqrt(square), beside);
        most.edge = select(most.edge, k, beyond > most.reach);
        most.reach = max(most.reach, beyond);
    }
    if (most.reach > (*missing).reach + SAME_RESTING_POINT) {
        *missing = most;
    }
}

fn bears(height: f32) -> bool {
    return height <= BEARING_HEIGHT;
}

// Whether `p`, the `k`-th try, is none of the points taken.
fn is_new(taken: ptr<function, array<vec4<f32>, MAX_MANIFOLD_POINTS>>, count: u32, p: vec3<f32>, k: u32) -> bool {
    let same = select(SAME_POINT, SAME_RESTING_POINT, k < COMPLETE);
    var fresh = true;
    for (var i = 0u; i < count; i++) {
        let apart = (*taken)[i].xyz - p;
        fresh &= dot(apart, apart) >= same * same;
    }
    return fresh;
}

// A unit vector across `normal`; the second tangent is `cross(normal, first)`.
fn tangent(normal: vec3<f32>) -> vec3<f32> {
    let side = select(vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), abs(normal.x) < 0.8);
    return unit(side - normal * dot(normal, side));
}
