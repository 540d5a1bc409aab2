//! Numbers and vectors of several candidates side by side, a lane each.
//!
//! Every operation does in each lane what the same expression does with `f32` and glam, in the same order: nothing is
//! fused or approximated, so a candidate has the same bits on every processor, in every lane and in any company.

use fearless_simd::prelude::*;
use glam::{Mat3, Vec3};
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Most lanes of any processor's vectors.
pub const MOST_LANES: usize = 16;

/// A number of every lane: as many lanes as the processor's vectors have.
pub type Number<S> = <S as Simd>::f32s;

/// A yes or no of every lane.
pub type Mask<S> = <S as Simd>::mask32s;

/// The same number in all lanes.
#[inline(always)]
pub fn splat<S: Simd>(simd: S, number: f32) -> Number<S> {
    SimdBase::splat(simd, number)
}

/// The same yes or no in all lanes.
#[inline(always)]
pub fn all<S: Simd>(simd: S, answer: bool) -> Mask<S> {
    SimdMask::splat(simd, answer)
}

/// The larger of two numbers. Of none and a number it is either: a candidate with such numbers is lost.
#[inline(always)]
pub fn at_least<S: Simd>(number: Number<S>, floor: Number<S>) -> Number<S> {
    number.max(floor)
}

/// The smaller of two numbers, likewise.
#[inline(always)]
pub fn at_most<S: Simd>(number: Number<S>, ceiling: Number<S>) -> Number<S> {
    number.min(ceiling)
}

/// The number nearest to `number` that is no larger than `limit` (≥ 0), either way.
#[inline(always)]
pub fn within<S: Simd>(number: Number<S>, limit: Number<S>) -> Number<S> {
    at_most::<S>(at_least::<S>(number, -limit), limit)
}

/// A vector of every lane.
#[derive(Clone, Copy, Debug)]
pub struct Vector<S: Simd> {
    x: Number<S>,
    y: Number<S>,
    z: Number<S>,
}

impl<S: Simd> Vector<S> {
    #[inline(always)]
    pub fn splat(simd: S, vector: Vec3) -> Self {
        Self { x: splat(simd, vector.x), y: splat(simd, vector.y), z: splat(simd, vector.z) }
    }

    #[inline(always)]
    pub fn new(x: Number<S>, y: Number<S>, z: Number<S>) -> Self {
        Self { x, y, z }
    }

    #[inline(always)]
    pub fn components(self) -> [Number<S>; 3] {
        [self.x, self.y, self.z]
    }

    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    #[inline(always)]
    pub fn set_lane(&mut self, lane: usize, vector: Vec3) {
        (self.x[lane], self.y[lane], self.z[lane]) = vector.into();
    }

    /// This where `mask` says so, `other` elsewhere.
    #[inline(always)]
    pub fn or(self, mask: Mask<S>, other: Self) -> Self {
        Self { x: mask.select(self.x, other.x), y: mask.select(self.y, other.y), z: mask.select(self.z, other.z) }
    }

    /// Times the same number in all lanes.
    #[inline(always)]
    pub fn times(self, by: f32) -> Self {
        Self { x: self.x * by, y: self.y * by, z: self.z * by }
    }

    /// Times the same vector in all lanes, component by component.
    #[inline(always)]
    pub fn scaled(self, by: Vec3) -> Self {
        Self { x: self.x * by.x, y: self.y * by.y, z: self.z * by.z }
    }

    /// Divided by it.
    #[inline(always)]
    pub fn unscaled(self, by: Vec3) -> Self {
        Self { x: self.x / by.x, y: self.y / by.y, z: self.z / by.z }
    }

    #[inline(always)]
    pub fn plus_y(self, y: f32) -> Self {
        Self { y: self.y + y, ..self }
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> Number<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// This plus a cross product, term by term: of a sum of two cross products drivers choose the order.
    #[inline(always)]
    pub fn plus_cross(self, u: Self, v: Self) -> Self {
        Self { x: self.x + u.y * v.z - u.z * v.y, y: self.y + u.z * v.x - u.x * v.z, z: self.z + u.x * v.y - u.y * v.x }
    }

    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }
}

impl<S: Simd> ExtractToken for Vector<S> {
    type S = S;

    #[inline(always)]
    fn token(&self) -> S {
        self.x.token()
    }
}

impl<S: Simd> Add for Vector<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<S: Simd> Sub for Vector<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<S: Simd> Mul<Number<S>> for Vector<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, by: Number<S>) -> Self {
        Self { x: self.x * by, y: self.y * by, z: self.z * by }
    }
}

impl<S: Simd> Div<Number<S>> for Vector<S> {
    type Output = Self;

    #[inline(always)]
    fn div(self, by: Number<S>) -> Self {
        Self { x: self.x / by, y: self.y / by, z: self.z / by }
    }
}

impl<S: Simd> Neg for Vector<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl<S: Simd> AddAssign for Vector<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Simd> SubAssign for Vector<S> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

/// A matrix of every lane, by columns.
#[derive(Clone, Copy, Debug)]
pub struct Matrix<S: Simd>([Vector<S>; 3]);

impl<S: Simd> Matrix<S> {
    #[inline(always)]
    pub fn zero(simd: S) -> Self {
        Self([Vector::splat(simd, Vec3::ZERO); 3])
    }

    #[inline(always)]
    pub fn set_lane(&mut self, lane: usize, matrix: Mat3) {
        let [x, y, z] = &mut self.0;
        x.set_lane(lane, matrix.x_axis);
        y.set_lane(lane, matrix.y_axis);
        z.set_lane(lane, matrix.z_axis);
    }

    /// The product of the transposed matrix.
    #[inline(always)]
    pub fn back(self, vector: Vector<S>) -> Vector<S> {
        let [x, y, z] = self.0;
        Vector::new(x.dot(vector), y.dot(vector), z.dot(vector))
    }
}

impl<S: Simd> Mul<Vector<S>> for Matrix<S> {
    type Output = Vector<S>;

    #[inline(always)]
    fn mul(self, by: Vector<S>) -> Vector<S> {
        let [x, y, z] = self.0;
        x * by.x + y * by.y + z * by.z
    }
}
