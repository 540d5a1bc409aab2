//! Ctrl-C and SIGTERM: the first asks for a clean end, the second ends at once.

use super::{Failure, say};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Installs the handler; the flag becomes true at the first signal.
pub fn watch() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(1);
        }
        say(format_args!("stopping after this iteration; once more to end at once without a result"));
    })
    .map_err(|error| Failure::Other(format!("Ctrl-C cannot be watched: {error}")))?;
    Ok(stop)
}
