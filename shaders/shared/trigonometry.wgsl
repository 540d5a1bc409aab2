const HALF_PI: f32 = 1.5707964;

// Sine and cosine of angles up to some turns, to 10⁻⁷: as `world::sin_cos`, operation by operation. Drivers have their
// own.
fn sin_cos(angle: vec2<f32>) -> mat2x2<f32> {
    const TWO_OVER_PI: f32 = 0.63661975;
    return sin_cos_quarters(angle * TWO_OVER_PI);
}

// The same of angles in quarter turns: drivers take two constant factors together.
fn sin_cos_quarters(angle: vec2<f32>) -> mat2x2<f32> {
    let quarter = round(angle);
    let x = (angle - quarter) * HALF_PI;
    let z = x * x;
    let sine = x * (1.0 + z * (-0.16666655 + z * (0.008332161 + z * -0.00019515296)));
    let cosine = 1.0 + z * (-0.5 + z * (0.041666646 + z * (-0.0013887316 + z * 0.000024433157)));
    let number = vec2<u32>(vec2<i32>(quarter));
    let odd = (number & vec2(1u)) == vec2(1u);
    let sine_sign = select(vec2(1.0), vec2(-1.0), (number & vec2(2u)) == vec2(2u));
    let cosine_sign = select(vec2(1.0), vec2(-1.0), ((number + vec2(1u)) & vec2(2u)) == vec2(2u));
    return mat2x2(sine_sign * select(sine, cosine, odd), cosine_sign * select(cosine, sine, odd));
}

// Angle in [0, π/2] of the direction (x, y), neither negative: as `world::angle_between` has it, operation by
// operation.
fn arctangent(y: f32, x: f32) -> f32 {
    const TAN_PI_8: f32 = 0.41421357;
    const QUARTER_PI: f32 = 0.7853982;
    let low = min(x, y);
    let high = max(x, y);
    let steep = low > TAN_PI_8 * high;
    let above = select(low, low - high, steep);
    let below = select(high, low + high, steep);
    let t = above / select(below, 1.0, below == 0.0);
    let z = t * t;
    let near = t * (1.0 + z * (-0.3333295 + z * (0.19977711 + z * (-0.13877686 + z * 0.080537446))));
    let angle = select(0.0, QUARTER_PI, steep) + near;
    return select(angle, HALF_PI - angle, y > x);
}
