//! Ctrl-C and SIGTERM: the first asks for a clean end, a later one ends at once.

use super::{Failure, say};
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
