//! Rigid poses and motions in the simulator's precision.

use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3, Vec4};
use std::f32::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4};

/// A rigid pose in metres, Y up: `world = rotation · local + translation`. 32 bytes, as the kernels store it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Pose {
    /// Unit quaternion, xyzw in memory.
    pub rotation: Quat,
    /// Position of the local origin, metres.
    pub translation: Vec3,
    pad: f32,
}

impl Pose {
    /// The pose that leaves everything where it is.
    pub const IDENTITY: Self = Self::new(Quat::IDENTITY, Vec3::ZERO);

    /// A pose from its two parts.
    pub const fn new(rotation: Quat, translation: Vec3) -> Self {
        Self { rotation, translation, pad: 0.0 }
    }

    /// The pose `height` metres further up.
    #[must_use]
    pub fn raised(&self, height: f32) -> Self {
        Self { translation: self.translation + Vec3::Y * height, ..*self }
    }

    /// Local point to world point.
    #[inline]
    pub fn point(&self, local: Vec3) -> Vec3 {
        self.rotation * local + self.translation
    }

    /// World point to local point.
    #[inline]
    pub fn inverse_point(&self, world: Vec3) -> Vec3 {
        self.rotation.conjugate() * (world - self.translation)
    }

    /// `self ∘ inner`: first `inner`, then `self`.
    #[inline]
    pub fn then(&self, inner: &Self) -> Self {
        Self::new((self.rotation * inner.rotation).normalize(), self.point(inner.translation))
    }

    /// The pose that undoes this one.
    #[inline]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.conjugate();
        Self::new(rotation, rotation * -self.translation)
    }

    /// True if no component is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        self.rotation.is_finite() && self.translation.is_finite()
    }
}

/// Linear (m/s) and angular (rad/s) velocity of a body's centre of mass, world frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Velocity {
    /// m/s.
    pub linear: Vec3,
    pad0: f32,
    /// rad/s.
    pub angular: Vec3,
    pad1: f32,
}

impl Velocity {
    /// A velocity from its two parts.
    pub const fn new(linear: Vec3, angular: Vec3) -> Self {
        Self { linear, pad0: 0.0, angular, pad1: 0.0 }
    }

    /// True if no component is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        self.linear.is_finite() && self.angular.is_finite()
    }
}

/// Sine and cosine of an angle up to some turns, to 10⁻⁷: the same operations as the shaders', because libraries and
/// drivers differ in the last bit (polynomials of the Cephes library).
#[inline]
fn sin_cos(angle: f32) -> (f32, f32) {
    sin_cos_quarters(angle * FRAC_2_PI)
}

/// The same of an angle in quarter turns: drivers take two constant factors together.
#[inline]
pub fn sin_cos_quarters(angle: f32) -> (f32, f32) {
    let quarter = angle.round_ties_even();
    let x = (angle - quarter) * FRAC_PI_2;
    let z = x * x;
    let sine = x * (1.0 + z * (-0.166_666_55 + z * (0.008_332_161 + z * -0.000_195_152_96)));
    let cosine = 1.0 + z * (-0.5 + z * (0.041_666_646 + z * (-0.001_388_731_6 + z * 0.000_024_433_157)));
    let number = quarter as i32;
    let (sine, cosine) = if number & 1 == 0 { (sine, cosine) } else { (cosine, sine) };
    let sign = |negative: bool| if negative { -1.0 } else { 1.0 };
    (sign(number & 2 == 2) * sine, sign((number + 1) & 2 == 2) * cosine)
}

/// Rotation `a` after rotation `b`, in the shaders' order of operations: drivers regroup the sums of sums of glam's.
#[inline]
pub fn compose(a: Quat, b: Quat) -> Quat {
    let [x, y, z, w] = b.to_array();
    Quat::from_vec4(
        a.w * Vec4::new(x, y, z, w)
            + a.x * Vec4::new(w, -z, y, -x)
            + a.y * Vec4::new(z, w, -x, -y)
            + a.z * Vec4::new(-y, x, w, -z),
    )
}

/// A rotation of unit length, in the shaders' order of operations.
#[inline]
pub fn unit_rotation(q: Quat) -> Quat {
    let length = (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w).sqrt();
    Quat::from_vec4(Vec4::from(q) / length)
}

/// The rotation about an axis by the axis' length, rad.
#[inline]
pub fn from_scaled_axis(v: Vec3) -> Quat {
    let angle = v.length();
    if angle == 0.0 {
        return Quat::IDENTITY;
    }
    let (sine, cosine) = sin_cos(0.5 * angle);
    let axis = v / angle * sine;
    Quat::from_xyzw(axis.x, axis.y, axis.z, cosine)
}

/// Geodesic angle between two rotations, radians in [0, π]. Accurate for small angles, where `acos` is not.
pub fn angle_between(a: Quat, b: Quat) -> f32 {
    let d = compose(a.conjugate(), b);
    2.0 * arctangent(d.xyz().length(), d.w.abs())
}

/// Angle in [0, π/2] of the direction (x, y), neither negative, to 10⁻⁷: the shaders' operations, as `sin_cos`. 0 of no
/// direction.
fn arctangent(y: f32, x: f32) -> f32 {
    const TAN_PI_8: f32 = 0.414_213_57;
    let (low, high) = (x.min(y), x.max(y));
    let steep = low > TAN_PI_8 * high;
    let (above, below) = if steep { (low - high, low + high) } else { (low, high) };
    let t = above / if below == 0.0 { 1.0 } else { below };
    let z = t * t;
    let near = t * (1.0 + z * (-0.333_329_5 + z * (0.199_777_11 + z * (-0.138_776_86 + z * 0.080_537_446))));
    let angle = if steep { FRAC_PI_4 } else { 0.0 } + near;
    if y > x { FRAC_PI_2 - angle } else { angle }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_and_rotations_are_those_of_the_library() {
        for i in -20_000_i16..=20_000 {
            let angle = f32::from(i) * 1e-3;
            let (sine, cosine) = sin_cos(angle);
            let (s, c) = f64::from(angle).sin_cos();
            // The last bits of an angle of some turns are lost.
            let tolerance = 1.5e-7 + 1.2e-7 * f64::from(angle.abs());
            assert!((f64::from(sine) - s).abs() < tolerance && (f64::from(cosine) - c).abs() < tolerance, "{angle}");
            let turn = from_scaled_axis(Vec3::new(0.6, 0.0, -0.8) * angle);
            assert!(angle_between(turn, Quat::from_axis_angle(Vec3::new(0.6, 0.0, -0.8), angle)) < 6e-6, "{angle}");
            let other = Quat::from_rotation_y(1.0 + angle);
            let [found, known] = [unit_rotation(compose(turn * 3.0, other)), turn * other].map(Vec4::from);
            assert!((found - known).abs().max_element() < 5e-7, "{angle}");
        }
    }

    #[test]
    fn arctangents_are_those_of_the_library() {
        for i in 0_i16..=10_000 {
            let (y, x) = (f64::from(i) * FRAC_PI_2 as f64 / 1e4).sin_cos();
            let (y, x) = (y as f32, x.abs() as f32);
            let known = f64::from(y).atan2(f64::from(x));
            assert!((f64::from(arctangent(y, x)) - known).abs() < 1.5e-7, "{y} {x}");
            assert!((f64::from(arctangent(3e-5 * y, 3e-5 * x)) - known).abs() < 3e-7, "{y} {x}");
        }
        assert_eq!(arctangent(0.0, 0.0), 0.0);
    }
}
