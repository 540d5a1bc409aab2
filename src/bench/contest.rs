//! Which of two backends simulates a heap of boxes faster: what `--backend auto` goes by.

use super::{Effort, measure};
use crate::shape::box_corners;
use crate::world::{Backend, BackendError, BodyDef, Pose, SimSettings, World};
use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

/// Sizes of the populations: a scene by itself, what a search simulates to its end, and the larger ones that the paper
/// has.
const CANDIDATES: [u32; 4] = [1, 64, 512, 2048];
/// Steps of a run: in the first ones there is most to solve.
const STEPS: u32 = 10;
/// How long each is measured at least, s.
const SECONDS: f64 = 0.25;
/// Larger populations are left out if one of them would take longer, s.
const PATIENCE: f64 = 3.0;

/// Candidates a second, of two backends with so many candidates at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Speed {
    /// How many at a time.
    pub candidates: u32,
    /// Of the card, 1/s.
    pub card: f64,
    /// Of the processor, 1/s.
    pub processor: f64,
}

/// Measures both, with few candidates and with many.
///
/// # Errors
/// If one of them failed.
pub fn contest(card: &dyn Backend, processor: &dyn Backend) -> Result<Vec<Speed>, BackendError> {
    let (world, settings) = (heap(), SimSettings { steps: STEPS, ..SimSettings::default() });
    let speed = |backend: &dyn Backend, candidates| {
        let effort = Effort { candidates, seed: 0, seconds: SECONDS };
        measure(backend, &world, &settings, effort, &mut |_| ()).map(|measured| measured.candidates_per_s)
    };
    let mut speeds: Vec<Speed> = Vec::new();
    for candidates in CANDIDATES {
        let slowest = speeds.last().map_or(f64::INFINITY, |last| last.card.min(last.processor));
        if f64::from(candidates) > PATIENCE * slowest {
            break;
        }
        speeds.push(Speed { candidates, card: speed(card, candidates)?, processor: speed(processor, candidates)? });
    }
    Ok(speeds)
}

impl Speed {
    /// True if it can have been measured.
    pub fn is_sound(&self) -> bool {
        [self.card, self.processor].into_iter().all(|speed| speed > 0.0 && speed.is_finite())
    }

    /// The one of these that tells most about populations of so many candidates: the largest that is no larger.
    pub fn of(speeds: &[Self], candidates: u32) -> Option<Self> {
        speeds.iter().rfind(|speed| speed.candidates <= candidates).or(speeds.first()).copied()
    }
}

/// A table with eleven boxes on it, some of them on others.
fn heap() -> World {
    let body = |size: Vec3, at: Vec3, unit: u32| {
        let parts = vec![box_corners(0.5 * size)];
        let mass = 500.0 * size.element_product();
        let inertia = mass / 12.0 * (Vec3::splat(size.length_squared()) - size * size);
        let start = Pose::new(Quat::from_rotation_y(0.4 * unit as f32), at);
        BodyDef { parts, mass, inertia, unit, start, reference: start }
    };
    let table = body(Vec3::new(1.2, 0.7, 0.8), 0.35 * Vec3::Y, 0);
    let things = (0..11).map(|i| {
        let at = Vec3::new(0.25 * (i % 4) as f32 - 0.4, 0.75 + 0.1 * (i / 8) as f32, 0.25 * (i / 4 % 2) as f32 - 0.1);
        body(Vec3::new(0.15, 0.1, 0.12), at, i + 1)
    });
    let defs: Vec<BodyDef> = std::iter::once(table).chain(things).collect();
    World::new(&defs, &(0..12).collect::<Vec<u32>>())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::cpu::CpuBackend;

    #[test]
    fn a_population_goes_by_the_nearest_that_is_no_larger() {
        let speed = |candidates| Speed { candidates, card: 1.0, processor: 2.0 };
        let speeds = [speed(64), speed(512)];
        let found = [1, 64, 511, 512, 9000].map(|n| Speed::of(&speeds, n).unwrap().candidates);
        assert_eq!(found, [64, 64, 64, 512, 512]);
        assert!(speeds[0].is_sound());
        for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(!Speed { card: wrong, ..speeds[0] }.is_sound());
        }
        assert_eq!(Speed::of(&[], 64), None);
    }

    #[test]
    fn both_simulate_a_heap_that_touches() {
        let speeds = contest(&CpuBackend, &CpuBackend).unwrap();
        // Slow processors leave out the largest.
        let sizes: Vec<u32> = speeds.iter().map(|speed| speed.candidates).collect();
        assert!(sizes.len() > 1 && CANDIDATES.starts_with(&sizes), "{sizes:?}");
        assert!(speeds.iter().all(Speed::is_sound));
        let settings = SimSettings { steps: STEPS, ..SimSettings::default() };
        let starts = super::super::starts(&heap(), 64, 0);
        let rollouts = CpuBackend.rollouts(&heap(), &settings, &starts).unwrap();
        assert!(rollouts.contacts_per_substep.unwrap() > 30.0, "{:?}", rollouts.contacts_per_substep);
    }
}
