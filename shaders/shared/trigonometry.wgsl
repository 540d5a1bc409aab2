// Sine and cosine of angles up to some turns, to 10⁻⁷: as `world::sin_cos`, operation by operation. Drivers have their own.
fn sin_cos(angle: vec2<f32>) -> mat2x2<f32> {
    const TWO_OVER_PI: f32 = 0.63661975;
    const HALF_PI: f32 = 1.5707964;
    let turns = angle * TWO_OVER_PI;
    let quarter = round(turns);
    let x = (turns - quarter) * HALF_PI;
    let z = x * x;
    let sine = x * (1.0 + z * (-0.16666655 + z * (0.008332161 + z * -0.00019515296)));
    let cosine = 1.0 + z * (-0.5 + z * (0.041666646 + z * (-0.0013887316 + z * 0.000024433157)));
    let number = vec2<u32>(vec2<i32>(quarter));
    let odd = (number & vec2(1u)) == vec2(1u);
    let sine_sign = select(vec2(1.0), vec2(-1.0), (number & vec2(2u)) == vec2(2u));
    let cosine_sign = select(vec2(1.0), vec2(-1.0), ((number + vec2(1u)) & vec2(2u)) == vec2(2u));
    return mat2x2(sine_sign * select(sine, cosine, odd), cosine_sign * select(cosine, sine, odd));
}
