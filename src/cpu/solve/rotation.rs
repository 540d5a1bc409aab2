//! Rotations of several candidates side by side: in each lane the operations of `world::pose` and glam, in their order.

use super::lanes::{Mask, Number, Vector, splat};
use fearless_simd::prelude::*;
use glam::Quat;
use std::f32::consts::{FRAC_2_PI, FRAC_PI_2};

/// A quaternion of every lane.
#[derive(Clone, Copy, Debug)]
pub struct Rotation<S: Simd> {
    xyz: Vector<S>,
    w: Number<S>,
}

impl<S: Simd> Rotation<S> {
    #[inline(always)]
    pub fn identity(simd: S) -> Self {
        Self { xyz: Vector::splat(simd, Quat::IDENTITY.xyz()), w: splat(simd, Quat::IDENTITY.w) }
    }

    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Quat {
        Quat::from_vec4(self.xyz.lane(lane).extend(self.w[lane]))
    }

    #[inline(always)]
    pub fn set_lane(&mut self, lane: usize, rotation: Quat) {
        self.xyz.set_lane(lane, rotation.xyz());
        self.w[lane] = rotation.w;
    }

    /// The rotation about an axis by the axis' length, rad: `world::from_scaled_axis`.
    #[inline(always)]
    pub fn from_scaled_axis(v: Vector<S>) -> Self {
        let simd = v.token();
        let angle = v.dot(v).sqrt();
        let [sine, cosine] = sin_cos_quarters::<S>(angle * 0.5 * FRAC_2_PI);
        let still = angle.simd_eq(0.0);
        let Self { xyz, w } = Self::identity(simd);
        Self { xyz: xyz.or(still, v / angle * sine), w: still.select(w, cosine) }
    }

    #[inline(always)]
    pub fn conjugate(self) -> Self {
        Self { xyz: -self.xyz, w: self.w }
    }

    /// This rotation after `other`: `world::compose`.
    #[inline(always)]
    pub fn after(self, other: Self) -> Self {
        let [ax, ay, az] = self.xyz.components();
        let [x, y, z] = other.xyz.components();
        let (aw, w) = (self.w, other.w);
        Self {
            xyz: Vector::new(
                aw * x + ax * w + ay * z - az * y,
                aw * y - ax * z + ay * w + az * x,
                aw * z + ax * y - ay * x + az * w,
            ),
            w: aw * w - ax * x - ay * y - az * z,
        }
    }

    /// Of unit length: `world::unit_rotation`.
    #[inline(always)]
    pub fn unit(self) -> Self {
        let length = (self.xyz.dot(self.xyz) + self.w * self.w).sqrt();
        Self { xyz: self.xyz / length, w: self.w / length }
    }

    #[inline(always)]
    pub fn rotate(self, v: Vector<S>) -> Vector<S> {
        let Self { xyz, w } = self;
        v * (w * w - xyz.dot(xyz)) + xyz * (v.dot(xyz) * 2.0) + xyz.cross(v) * (w * 2.0)
    }
}

/// Sine and cosine of angles in quarter turns: `world::sin_cos_quarters`.
#[inline(always)]
fn sin_cos_quarters<S: Simd>(angle: Number<S>) -> [Number<S>; 2] {
    let quarter = angle.round_ties_even();
    let x = (angle - quarter) * FRAC_PI_2;
    let z = x * x;
    let sine = x * (z * (z * (z * -0.000_195_152_96 + 0.008_332_161) + -0.166_666_55) + 1.0);
    let cosine = z * (z * (z * (z * 0.000_024_433_157 + -0.001_388_731_6) + 0.041_666_646) + -0.5) + 1.0;
    let swapped = is_odd::<S>(quarter);
    let [sine, cosine] = [swapped.select(cosine, sine), swapped.select(sine, cosine)];
    let negative = |quarter: Number<S>| is_odd::<S>((quarter * 0.5).floor());
    [negative(quarter).select(-sine, sine), negative(quarter + 1.0).select(-cosine, cosine)]
}

/// Of whole numbers.
#[inline(always)]
fn is_odd<S: Simd>(number: Number<S>) -> Mask<S> {
    (number - (number * 0.5).floor() * 2.0).simd_gt(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{compose, from_scaled_axis, unit_rotation};
    use fearless_simd::{Level, dispatch};
    use glam::Vec3;

    #[test]
    fn every_lane_has_the_bits_of_a_rotation_alone() {
        for level in [Level::new(), Level::baseline()] {
            dispatch!(level, simd => same_bits(simd));
        }
    }

    fn same_bits<S: Simd>(simd: S) {
        for i in 0..2000 {
            let turn = 0.004 * i as f32 * Vec3::new(0.6, -0.3, (0.1 * i as f32).sin());
            let other = Quat::from_rotation_y(0.3 * i as f32) * Quat::from_rotation_x(0.7) * 1.01;
            let (mut turns, mut others) = (Vector::splat(simd, Vec3::X), Rotation::identity(simd));
            let lane = i % Number::<S>::LEN;
            turns.set_lane(lane, turn);
            others.set_lane(lane, other);
            let found = Rotation::from_scaled_axis(turns).after(others.conjugate()).unit();
            let known = unit_rotation(compose(from_scaled_axis(turn), other.conjugate()));
            let bits = |v: [f32; 4]| v.map(f32::to_bits);
            assert_eq!(bits(found.lane(lane).to_array()), bits(known.to_array()), "{turn} rad");
            let (found, known) = (found.rotate(turns).lane(lane), known * turn);
            assert_eq!(found.to_array().map(f32::to_bits), known.to_array().map(f32::to_bits), "{turn}");
        }
    }
}
