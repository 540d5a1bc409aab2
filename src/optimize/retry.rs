//! A run that outlives its device: when one fails, or the scene does not fit onto it, the next simulator goes on from
//! the last group that was done.

use super::{Checkpoint, Config, Event, Observer, OptimizeError, Outcome, run};
use crate::scene::Scene;
use crate::shape::Shape;
use crate::world::{Backend, BackendError, Flow};
use std::sync::{Arc, atomic::AtomicBool};

/// As [`run`], with another backend whenever the device of one fails or holds too little: `next` is told the failure
/// and opens it, or has none left. The result is what resuming from the last checkpoint with the backend that ended the
/// run gives; the outcome's notes name every change. Also returns that backend.
///
/// # Errors
/// As [`run`]; a backend's failure only if there is no next backend.
#[allow(clippy::too_many_arguments)]
pub fn run_on(
    scene: &Scene,
    shapes: &[Shape],
    first: Box<dyn Backend>,
    next: &mut dyn FnMut(&BackendError) -> Option<Box<dyn Backend>>,
    config: &Config,
    seed: u64,
    resume: Option<Checkpoint>,
    observer: &mut dyn Observer,
) -> Result<(Outcome, Box<dyn Backend>), OptimizeError> {
    let mut backend = first;
    let mut notes = Vec::new();
    let mut keeper = Keeper { observer, last: resume };
    loop {
        let resume = keeper.last.clone();
        match run(scene, shapes, backend.as_ref(), config, seed, resume, &mut keeper) {
            Ok(mut outcome) => {
                outcome.notes.extend(notes);
                return Ok((outcome, backend));
            }
            Err(OptimizeError::Backend(failure @ (BackendError::Device(_) | BackendError::Capacity(_)))) => {
                let Some(other) = next(&failure) else { return Err(failure.into()) };
                notes.push(format!(
                    "{} failed ({failure}); {} went on after {} groups",
                    backend.describe(),
                    other.describe(),
                    keeper.last.as_ref().map_or(0, |checkpoint| checkpoint.completed)
                ));
                backend = other;
            }
            Err(error) => return Err(error),
        }
    }
}

/// Remembers the last checkpoint.
struct Keeper<'a> {
    observer: &'a mut dyn Observer,
    last: Option<Checkpoint>,
}

impl Observer for Keeper<'_> {
    fn event(&mut self, event: Event<'_>) -> Flow {
        if let Some(checkpoint) = event.checkpoint() {
            self.last = Some(checkpoint.clone());
        }
        self.observer.event(event)
    }

    fn stop(&self) -> Arc<AtomicBool> {
        self.observer.stop()
    }
}
