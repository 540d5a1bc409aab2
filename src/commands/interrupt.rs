//! Ctrl-C and SIGTERM: the first asks for a clean end, a later one ends at once.

use super::{Failure, say};
use rest3d_gpu::optimize::{Event, Observer};
use rest3d_gpu::world::Flow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// Signals within this time are one: `timeout` sends its own to the program and to its group.
const ONE_SIGNAL: Duration = Duration::from_millis(500);

/// Installs the handler; the flag becomes true at the first signal.
pub fn watch() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    let first = OnceLock::new();
    ctrlc::set_handler(move || match first.get() {
        None => {
            first.get_or_init(Instant::now);
            flag.store(true, Ordering::Relaxed);
            say(format_args!("stopping; once more to end at once without a result"));
        }
        Some(first) if first.elapsed() > ONE_SIGNAL => std::process::exit(1),
        Some(_) => {}
    })
    .map_err(|error| Failure::Other(format!("Ctrl-C cannot be watched: {error}")))?;
    Ok(stop)
}

/// Passes the flag on to a search, and the search's events to `show`.
pub struct Watch<'a, F> {
    stop: &'a Arc<AtomicBool>,
    show: F,
}

impl<'a, F: FnMut(&Event<'_>)> Watch<'a, F> {
    /// Of the flag of [`watch`].
    pub fn new(stop: &'a Arc<AtomicBool>, show: F) -> Self {
        Self { stop, show }
    }
}

impl<F: FnMut(&Event<'_>)> Observer for Watch<'_, F> {
    fn event(&mut self, event: Event<'_>) -> Flow {
        (self.show)(&event);
        if self.stop.load(Ordering::Relaxed) { Flow::Stop } else { Flow::Continue }
    }

    fn stop(&self) -> Arc<AtomicBool> {
        Arc::clone(self.stop)
    }
}
