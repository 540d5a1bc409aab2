//! One group's search: episodes of Cross-Entropy iterations, and when to stop.

use super::tolerances::IMPROVEMENT;
use crate::world::{
    Backend, BackendError, Best, CemSettings, Distribution, Energy, Flow, IterationStats, KernelTime, Search,
    SearchSettings, Status, Stream, World,
};

/// How a search ended.
#[derive(Clone, Debug)]
pub(super) struct Searched {
    /// The best candidate ever seen; none if every simulation failed.
    pub best: Option<Best>,
    /// Candidates with each status bit.
    pub flagged: [u64; Status::FAULTS.len()],
    /// Steps that candidates were simulated for, and those of all that might have been.
    pub steps: [u64; 2],
    /// True if the observer ended it.
    pub stopped: bool,
    /// What each kernel took, ms.
    pub kernels: Vec<KernelTime>,
}

/// Runs all episodes. `second`, if there is one, is another mean to start from: the first iteration is drawn about no
/// move, the second about that, and the one with the better elites goes on. `on_iteration` sees every iteration and may
/// stop the search.
pub(super) fn search(
    backend: &dyn Backend,
    world: &World,
    settings: &SearchSettings,
    stream: Stream,
    second: Option<Vec<f32>>,
    on_iteration: &mut dyn FnMut(&IterationStats, &dyn Search) -> Flow,
) -> Result<Searched, BackendError> {
    let cem = &settings.cem;
    let moving = world.bodies.iter().filter(|body| !body.is_static()).count();
    let mut search = backend.search(world, settings, stream)?;
    let mut flagged = [0; Status::FAULTS.len()];
    let mut steps = [0; 2];
    let mut stopped = false;
    let mut second = second.map(|mean| Distribution { mean, ..cem.initial(world.units.len()) });
    let mut first: Option<(f32, Distribution)> = None;
    let mut patience = Patience { limit: cem.patience, mark: f32::INFINITY, stale: 0 };
    'episodes: for episode in 0..cem.episodes {
        if episode > 0 {
            widen(search.as_mut(), cem);
        }
        patience.stale = 0;
        for _ in 0..cem.iterations {
            let stats = search.iterate()?;
            for (sum, count) in flagged.iter_mut().zip(stats.flagged) {
                *sum += u64::from(count);
            }
            steps = [steps[0] + stats.steps, steps[1] + settings.steps()];
            stopped = on_iteration(&stats, search.as_ref()) == Flow::Stop;
            if stopped || has_nothing_to_gain(&stats.best, settings, moving) {
                break 'episodes;
            }
            if let Some(start) = second.take() {
                first = Some((stats.elite_mean, search.distribution()));
                search.set_distribution(&start);
                continue;
            }
            if let Some((elite_mean, distribution)) = first.take()
                && elite_mean <= stats.elite_mean
            {
                search.set_distribution(&distribution);
            }
            if patience.is_over(stats.elite_mean) {
                break;
            }
        }
    }
    let kernels = search.kernel_times();
    Ok(Searched { best: search.best()?, flagged, steps, stopped, kernels })
}

/// True if the best layout is good, or stands and is about where it was: of so many objects.
fn has_nothing_to_gain(best: &Energy, settings: &SearchSettings, objects: usize) -> bool {
    let cem = &settings.cem;
    let layout = settings.energy.layout * best.layout;
    let stands = best.total - layout < cem.stop_energy;
    best.total < cem.stop_energy || (stands && layout < cem.stop_layout_each * objects as f32)
}

/// A later episode starts from the last one's distribution, widened where it has become narrow.
fn widen(search: &mut dyn Search, cem: &CemSettings) {
    let mut distribution = search.distribution();
    let initial = cem.initial(distribution.std.len() / 6);
    for (std, first) in distribution.std.iter_mut().zip(initial.std) {
        *std = std.max(cem.restart_std * first);
    }
    search.set_distribution(&distribution);
}

/// Counts iterations without progress.
struct Patience {
    limit: u32,
    mark: f32,
    stale: u32,
}

impl Patience {
    fn is_over(&mut self, elite_mean: f32) -> bool {
        if elite_mean < self.mark * (1.0 - IMPROVEMENT) {
            self.mark = elite_mean;
            self.stale = 0;
        } else {
            self.stale += 1;
        }
        self.limit > 0 && self.stale >= self.limit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_where_it_was_needs_no_search() {
        let mut settings = SearchSettings::default();
        settings.cem.stop_layout_each = 0.01;
        let done = |layout: f32, stability: f32, penetration: f32| {
            let energy = stability + 0.5 * penetration + layout;
            let best = Energy { total: energy, stability, velocity: 0.0, penetration, layout };
            has_nothing_to_gain(&best, &settings, 5)
        };
        assert!(done(0.004, 0.005, 0.0), "less than 0.01 in all");
        assert!(done(0.04, 0.005, 0.0), "five objects, 0.008 each");
        assert!(!done(0.06, 0.005, 0.0), "0.012 each");
        assert!(!done(0.03, 0.015, 0.0), "one moves");
        assert!(!done(0.0, 0.0, 0.1), "two overlap");
    }
}
