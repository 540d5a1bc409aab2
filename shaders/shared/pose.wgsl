// Rigid poses (metres, Y up) and motions; quaternions are xyzw and of unit length.

#import trigonometry

struct Pose {
    rotation: vec4<f32>,
    translation: vec3<f32>,
}

struct Velocity {
    // m/s
    linear: vec3<f32>,
    // rad/s
    angular: vec3<f32>,
}

// Rotation `a` after rotation `b`: as `world::compose`. One sum after the other, because drivers regroup sums of sums.
fn compose(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return a.w * b + a.x * vec4(b.w, -b.z, b.y, -b.x) + a.y * vec4(b.z, b.w, -b.x, -b.y)
        + a.z * vec4(-b.y, b.x, b.w, -b.z);
}

// Of unit length: as `world::unit_rotation`.
fn unit_rotation(q: vec4<f32>) -> vec4<f32> {
    return q / length(q);
}

fn conjugate(q: vec4<f32>) -> vec4<f32> {
    return vec4(-q.xyz, q.w);
}

fn rotate(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    return v * (q.w * q.w - dot(q.xyz, q.xyz)) + q.xyz * (2.0 * dot(q.xyz, v)) + cross(q.xyz, v) * (2.0 * q.w);
}

// The rotation about an axis by the axis' length, rad.
fn from_scaled_axis(v: vec3<f32>) -> vec4<f32> {
    let angle = length(v);
    // At angle 0 the axis does not matter, but must be finite.
    let axis = v / select(angle, 1.0, angle == 0.0);
    let half = sin_cos(vec2(0.5 * angle));
    return vec4(axis * half[0].x, half[1].x);
}

// Angle between two rotations, rad in [0, π].
fn angle_between(a: vec4<f32>, b: vec4<f32>) -> f32 {
    let d = compose(conjugate(a), b);
    return 2.0 * arctangent(length(d.xyz), abs(d.w));
}
