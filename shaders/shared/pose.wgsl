// Rigid poses (metres, Y up) and motions; quaternions are xyzw and of unit length.

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

// Rotation `a` after rotation `b`.
fn compose(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return vec4(a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz), a.w * b.w - dot(a.xyz, b.xyz));
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
    return vec4(axis * sin(0.5 * angle), cos(0.5 * angle));
}

// Angle between two rotations, rad in [0, π].
fn angle_between(a: vec4<f32>, b: vec4<f32>) -> f32 {
    let d = compose(conjugate(a), b);
    return 2.0 * atan2(length(d.xyz), abs(d.w));
}
