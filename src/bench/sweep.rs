//! What is measured to see how speed depends on size.

use super::{Effort, Subject};
use crate::world::World;

/// What varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Number of candidates.
    Candidates,
    /// Number of bodies that move.
    Bodies,
    /// Number of hulls of the same bodies.
    Hulls,
}

/// One measurement of a sweep.
#[derive(Clone, Debug)]
pub struct Point {
    /// What varies around it.
    pub quantity: Quantity,
    /// What is simulated.
    pub world: World,
    /// How much of it.
    pub effort: Effort,
}

/// Numbers of candidates.
const CANDIDATES: [u32; 5] = [64, 256, 1024, 4096, 16384];
/// Numbers of bodies.
const BODIES: [usize; 5] = [4, 8, 12, 20, 30];
/// How often the hulls are cut in two.
const CUTS: [u32; 4] = [0, 1, 2, 3];
/// Most candidates where something else varies.
const FEW: u32 = 256;

/// The measurements of a sweep with at most `most.candidates`, quantity by quantity, each from small to large.
pub fn plan(subject: &Subject, most: Effort) -> Vec<Point> {
    let whole = subject.world();
    let few = Effort { candidates: most.candidates.min(FEW), ..most };
    let smaller = CANDIDATES.into_iter().filter(|&candidates| candidates < most.candidates);
    let candidates = smaller.chain([most.candidates]).map(|candidates| {
        let effort = Effort { candidates, ..most };
        Point { quantity: Quantity::Candidates, world: whole.clone(), effort }
    });
    let bodies = BODIES.into_iter().map(|count| {
        let world = subject.with_bodies(count).world();
        Point { quantity: Quantity::Bodies, world, effort: few }
    });
    let hulls = CUTS.into_iter().map(|times| {
        let world = subject.with_cut_hulls(times).world();
        Point { quantity: Quantity::Hulls, world, effort: few }
    });
    candidates.chain(bodies).chain(hulls).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_quantity_grows_and_candidates_end_at_the_most() {
        let subject = Subject::default();
        let of = |candidates: u32, quantity: Quantity| -> Vec<u32> {
            let points = plan(&subject, Effort { candidates, seed: 0, seconds: 0.0 });
            points.iter().filter(|p| p.quantity == quantity).map(|p| p.effort.candidates).collect()
        };
        assert_eq!(of(16384, Quantity::Candidates), CANDIDATES);
        assert_eq!(of(300, Quantity::Candidates), [64, 256, 300]);
        assert_eq!(of(7, Quantity::Candidates), [7]);
        assert_eq!(of(16384, Quantity::Bodies), [FEW; BODIES.len()]);
        assert_eq!(of(7, Quantity::Hulls), [7; CUTS.len()]);
    }
}
