//! Rigid poses and motions in the simulator's precision.

use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};

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

/// Geodesic angle between two rotations, radians in [0, π]. Accurate for small angles, where `acos` is not.
pub fn angle_between(a: Quat, b: Quat) -> f32 {
    let d = a.conjugate() * b;
    2.0 * d.xyz().length().atan2(d.w.abs())
}
