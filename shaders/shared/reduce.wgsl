// Chooses the few of many contact points that support a body as well as all of them: as `cpu::narrow_phase::reduce`.
//
// Offer all points, then take the extremes in their order and after them all points that bear, each only if it `is_new`
// among those taken, until there are `MAX_MANIFOLD_POINTS`.

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

// Extremes of all rounds, and those on which a body rests.
const EXTREMES: u32 = 24u;
const RESTING: u32 = 8u;

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

fn extreme(extremes: Extremes, k: u32) -> u32 {
    let j = k & 3u;
    let first = (k & 4u) == 0u;
    let resting = select(extremes.resting.opposite_point[j], extremes.resting.point[j], first);
    let rolling = select(extremes.rolling.opposite_point[j], extremes.rolling.point[j], first);
    let landing = select(extremes.landing.opposite_point[j], extremes.landing.point[j], first);
    return select(select(landing, rolling, k < 16u), resting, k < RESTING);
}

// The `k`-th to be tried: extremes, then all points by their numbers.
fn offered_in(extremes: Extremes, k: u32) -> u32 {
    return select(k - min(k, EXTREMES), extreme(extremes, k), k < EXTREMES);
}

fn bears(height: f32) -> bool {
    return height <= BEARING_HEIGHT;
}

// Whether `p`, tried as the `k`-th, is none of the points taken.
fn is_new(taken: ptr<function, array<vec4<f32>, MAX_MANIFOLD_POINTS>>, count: u32, p: vec3<f32>, k: u32) -> bool {
    let same = select(SAME_POINT, SAME_RESTING_POINT, k < RESTING);
    var fresh = count < MAX_MANIFOLD_POINTS;
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
