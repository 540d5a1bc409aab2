//! Contact solver: temporal Gauss–Seidel with soft contacts (the idea of "soft step" in Box2D v3; the small steps are
//! those of PhysX's TGS).
//!
//! A substep is cut into `position_iterations` small steps `h`. Each applies gravity, warm-starts, solves every contact
//! as an overdamped spring, there and back until that changes little, with friction before the first sweeps, moves the
//! bodies, and solves once more with friction and rigid contacts, after a hit several times and over-relaxed, so that
//! push-out leaves no kinetic energy behind. What gains some all the same is solved again (`cold`). A plain spring sags
//! under load and a rigid contact rings when a heavy body lies on a light one; this spring is at rest at the load that
//! its patch has carried lately, which does neither. Its share of that load follows far more slowly: a patch must stay
//! stiff against leaning, or towers buckle. Normals are those of the substep's start; separations and lever arms follow
//! the bodies' motion (`follow`).
//!
//! A sweep is one long chain of dependent operations, so several candidates are solved side by side, one in each lane
//! of the processor's vectors, which takes hardly longer than one.

mod cold;
mod first_loads;
mod follow;
mod integrate;
mod lanes;
mod load;
mod rotation;
mod rows;
mod sweep;
mod union;

use super::simulate::Workspace;
use crate::world::{
    Body, SimSettings,
    constants::{
        CONTACT_DAMPING_RATIO, CONTACT_FREQUENCY, CONTACT_FREQUENCY_SHARE, DEEP_PUSH_OUT_RATE, TOUCHING_DEPTH,
    },
};
use fearless_simd::{Level, dispatch, prelude::*};
use first_loads::Give;
use glam::Vec3;
use lanes::{Number, at_most, splat};
use rows::{Friction, Moving, Normal};
use union::Union;

/// Solves a substep of several candidates.
pub struct Solver(Box<dyn Substep>);

impl Solver {
    /// With the vectors of `level`, of which `Level::new()` is the widest that the processor has. There is no room for
    /// any constraint yet; it grows with use.
    pub fn new(level: Level) -> Self {
        dispatch!(level, simd => Self(boxed(simd)))
    }

    /// How many candidates `level` solves side by side.
    pub fn lanes(level: Level) -> usize {
        dispatch!(level, simd => lanes_of(simd))
    }

    /// Gives the contacts of candidates that begin, and that have none of an earlier substep, what they carry.
    pub fn find_loads(&mut self, bodies: &[Body], settings: &SimSettings, candidates: &mut [Workspace]) {
        self.0.find_loads(bodies, settings, candidates);
    }

    /// Advances candidates by one substep. Contacts keep their impulses for the next call's warm start.
    pub fn substep(&mut self, bodies: &[Body], settings: &SimSettings, candidates: &mut [Workspace]) {
        self.0.substep(bodies, settings, candidates);
    }
}

fn lanes_of<S: Simd>(_: S) -> usize {
    Number::<S>::LEN
}

fn boxed<S: Simd>(simd: S) -> Box<dyn Substep> {
    Box::new(Wide {
        simd,
        bodies: Vec::new(),
        union: Union::new(simd),
        normals: Vec::new(),
        frictions: Vec::new(),
        gives: Vec::new(),
    })
}

trait Substep: Send + Sync {
    fn find_loads(&mut self, bodies: &[Body], settings: &SimSettings, candidates: &mut [Workspace]);
    fn substep(&mut self, bodies: &[Body], settings: &SimSettings, candidates: &mut [Workspace]);
}

/// The solver for one kind of vectors; the last entry of `bodies` is the ground.
struct Wide<S: Simd> {
    simd: S,
    bodies: Vec<Moving<S>>,
    union: Union<S>,
    /// For every point of the union.
    normals: Vec<Normal<S>>,
    /// For every patch of the union.
    frictions: Vec<Friction<S>>,
    /// The same, while the first loads are found.
    gives: Vec<Give<S>>,
}

impl<S: Simd> Substep for Wide<S> {
    fn find_loads(&mut self, bodies: &[Body], settings: &SimSettings, candidates: &mut [Workspace]) {
        let soft = Softness::new(settings.small_step());
        let simd = self.simd;
        for candidates in candidates.chunks_mut(Number::<S>::LEN) {
            simd.vectorize(
                #[inline(always)]
                || {
                    self.load(bodies, settings, &soft, candidates);
                    self.first_loads(settings, candidates);
                },
            );
        }
    }

    fn substep(&mut self, bodies: &[Body], settings: &SimSettings, candidates: &mut [Workspace]) {
        let soft = Softness::new(settings.small_step());
        let dt = settings.substep();
        let simd = self.simd;
        for candidates in candidates.chunks_mut(Number::<S>::LEN) {
            simd.vectorize(
                #[inline(always)]
                || {
                    self.load(bodies, settings, &soft, candidates);
                    self.small_steps(bodies, settings, &soft);
                    self.integrate(bodies, dt, candidates);
                    self.hand_over(settings, candidates);
                },
            );
        }
    }
}

/// The same with every nought positive. Contacts that a candidate lacks add noughts of either sign to its velocities,
/// and no bit must tell of its company.
fn unsigned(vector: Vec3) -> Vec3 {
    vector + 0.0
}

/// Spring coefficients of a soft contact over a small step.
#[derive(Clone, Copy, Debug)]
struct Softness {
    /// Share of the overlap pushed out per second, 1/s.
    bias_rate: f32,
    mass_scale: f32,
    impulse_scale: f32,
}

impl Softness {
    /// Implicit damped spring over a step `h` (E. Catto, "Soft Constraints", GDC 2011).
    fn new(h: f32) -> Self {
        let omega = std::f32::consts::TAU * CONTACT_FREQUENCY.min(CONTACT_FREQUENCY_SHARE / h);
        let a1 = 2.0 * CONTACT_DAMPING_RATIO + h * omega;
        let a2 = h * omega * a1;
        let a3 = 1.0 / (1.0 + a2);
        Self { bias_rate: omega / a1, mass_scale: a2 * a3, impulse_scale: a3 }
    }

    /// Speed at which two surfaces are to come closer, m/s, if their contact is at rest at the separation `rest`: deep
    /// overlap is left faster.
    #[inline(always)]
    fn push_out<S: Simd>(&self, separation: Number<S>, rest: Number<S>) -> Number<S> {
        let deep = at_most::<S>(separation + TOUCHING_DEPTH, splat(separation.token(), 0.0));
        (separation - rest) * self.bias_rate + deep * DEEP_PUSH_OUT_RATE
    }
}
