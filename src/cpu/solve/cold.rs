//! Small steps that would add energy are solved again from nothing.
//!
//! A small step starts from the last one's impulses. When a hit is over they are far too large, and in a heap of heavy
//! and light things the sweeps do not take all of that back: what was hit would fly apart. Rigid contacts solved
//! without a first guess only ever brake.

use super::Wide;
use super::lanes::{Mask, splat};
use crate::world::constants::{ENERGY_GAIN, LEFT_SPEED};
use fearless_simd::prelude::*;

impl<S: Simd> Wide<S> {
    /// The candidates whose bodies have more kinetic energy than before the impulses of the small step.
    #[inline(always)]
    pub fn gains_energy(&self) -> Mask<S> {
        let (mut energy, mut bound) = (splat(self.simd, 0.0), splat(self.simd, 0.0));
        for body in self.bodies.iter().filter(|body| body.inverse_mass > 0.0) {
            let [linear, spin, ..] = body.free;
            energy += body.linear.dot(body.linear) / body.inverse_mass;
            energy += body.spin.dot(body.spin);
            let allowed = (linear.dot(linear) * ENERGY_GAIN + LEFT_SPEED * LEFT_SPEED) / body.inverse_mass;
            bound += allowed + spin.dot(spin) * ENERGY_GAIN;
        }
        energy.simd_gt(bound)
    }

    /// Takes the impulses of the small step back, and what they moved.
    #[inline(always)]
    pub fn start_cold(&mut self, candidates: Mask<S>) {
        let zero = splat(self.simd, 0.0);
        for body in &mut self.bodies {
            let now = [&mut body.linear, &mut body.spin, &mut body.shift, &mut body.turn];
            for (vector, free) in now.into_iter().zip(body.free) {
                *vector = free.or(candidates, *vector);
            }
        }
        for n in &mut self.normals {
            n.impulse = candidates.select(zero, n.impulse);
        }
        for f in &mut self.frictions {
            for number in f.impulse.iter_mut().chain([&mut f.limit, &mut f.twist_limit]) {
                *number = candidates.select(zero, *number);
            }
        }
    }
}
