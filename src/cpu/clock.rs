//! Where a substep's time goes, and what it finds. The clock is a type parameter: simulations that nobody watches have
//! none.

use super::narrow_phase::{Manifold, PairCache, Separation};
use crate::world::KernelTime;
use std::time::{Duration, Instant};

/// A part of the substep, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// Boxes, and hull pairs that may touch.
    BroadPhase,
    /// Separating axes of hull pairs.
    NarrowPhase,
    /// Contact points of hull pairs, and with the ground.
    Manifold,
    /// Points merged into patches and matched to the last substep's.
    Contacts,
    /// Constraints and integration.
    Solve,
}

impl Kernel {
    /// Names, in order.
    const NAMES: [&str; 5] = ["broad_phase", "narrow_phase", "manifold", "contacts", "solve"];
}

/// Told whenever a part of the work is done.
pub trait Clock {
    /// What was done since the last call was work of `kernel`.
    fn lap(&mut self, kernel: Kernel);

    /// The next hull pair of the list: its remembered axis before and after, and its contacts if an axis was found.
    #[inline(always)]
    fn pair(&mut self, _before: PairCache, _found: Option<&Separation>, _after: PairCache, _contacts: &Manifold) {}

    /// The contacts of a hull with the ground.
    #[inline(always)]
    fn ground(&mut self, _hull: usize, _contacts: &Manifold) {}
}

/// No clock.
impl Clock for () {
    #[inline(always)]
    fn lap(&mut self, _: Kernel) {}
}

/// Adds the time up, kernel by kernel.
#[derive(Clone, Copy, Debug)]
pub struct Laps {
    since: Instant,
    spent: [Duration; Kernel::NAMES.len()],
}

impl Laps {
    /// Starts now.
    pub fn start() -> Self {
        Self { since: Instant::now(), spent: Default::default() }
    }

    /// Both times together.
    #[must_use]
    pub fn plus(mut self, other: Self) -> Self {
        self.spent.iter_mut().zip(other.spent).for_each(|(sum, spent)| *sum += spent);
        self
    }

    /// The sum over all kernels, ms.
    pub fn milliseconds(&self) -> f64 {
        1e3 * self.spent.iter().sum::<Duration>().as_secs_f64()
    }

    /// The times, `scale` times as long.
    pub fn times(&self, scale: f64) -> Vec<KernelTime> {
        let milliseconds = |spent: &Duration| 1e3 * scale * spent.as_secs_f64();
        (Kernel::NAMES.iter().zip(&self.spent))
            .map(|(name, spent)| KernelTime { name: (*name).into(), milliseconds: milliseconds(spent) })
            .collect()
    }
}

impl Clock for Laps {
    fn lap(&mut self, kernel: Kernel) {
        let now = Instant::now();
        self.spent[kernel as usize] += now - self.since;
        self.since = now;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laps_add_up_under_their_names() {
        let mut one = Laps::start();
        one.spent = [1, 2, 3, 4, 5].map(Duration::from_millis);
        let mut two = Laps::start();
        std::thread::sleep(Duration::from_millis(2));
        two.lap(Kernel::Solve);
        let times = one.plus(two).times(10.0);
        assert_eq!(times.iter().map(|t| t.name.as_str()).collect::<Vec<_>>(), Kernel::NAMES);
        assert!((times[0].milliseconds - 10.0).abs() < 1e-9);
        assert!(times[4].milliseconds >= 70.0);
    }
}
