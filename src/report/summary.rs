//! The result in a few lines.

use crate::optimize::{ObjectOutcome, Outcome};
use crate::scene::Scene;
use serde::Serialize;
use std::fmt::{Display, Formatter, Result};

/// Counts and means over the objects that were simulated, and the names of those to look at.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Objects in the scene.
    pub objects: usize,
    /// Those that are neither held nor fixed to a wall or ceiling.
    pub simulated: usize,
    /// Those within the limits of the check.
    pub stable: usize,
    /// Mean distance from the input, m.
    pub mean_moved: f64,
    /// Largest distance from the input, m.
    pub max_moved: f64,
    /// Mean distance moved during the check, m.
    pub mean_drift: f64,
    /// Largest distance moved during the check, m.
    pub max_drift: f64,
    /// Names of the objects that did not stay during the check.
    pub unstable: Vec<String>,
    /// Names of the objects that turned by more than 30° from the input.
    pub fallen: Vec<String>,
    /// Names of the objects that their parent no longer bears.
    pub lost_support: Vec<String>,
}

impl Summary {
    /// Of the outcome's objects, in the scene's order.
    pub fn new(scene: &Scene, outcome: &Outcome) -> Self {
        let simulated: Vec<&ObjectOutcome> = outcome.objects.iter().filter(|object| object.simulated).collect();
        let over = |value: fn(&ObjectOutcome) -> f64| {
            let values = simulated.iter().map(|object| value(object));
            (
                values.clone().fold(0.0, |sum, value| sum + value) / simulated.len().max(1) as f64,
                values.fold(0.0, f64::max),
            )
        };
        let names = |which: fn(&ObjectOutcome) -> bool| -> Vec<String> {
            let objects = scene.objects.iter().zip(&outcome.objects);
            objects.filter(|(_, outcome)| which(outcome)).map(|(object, _)| object.name.clone()).collect()
        };
        let (mean_moved, max_moved) = over(|object| object.moved);
        let (mean_drift, max_drift) = over(|object| object.drift);
        Self {
            objects: outcome.objects.len(),
            simulated: simulated.len(),
            stable: simulated.iter().filter(|object| object.stable).count(),
            mean_moved,
            max_moved,
            mean_drift,
            max_drift,
            unstable: names(|object| object.simulated && !object.stable),
            fallen: names(|object| object.fallen),
            lost_support: names(|object| object.lost_support),
        }
    }
}

impl Display for Summary {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let list = |names: &[String]| if names.is_empty() { "none".into() } else { names.join(", ") };
        let millimetres = |mean: f64, max: f64| format!("{:.1} mm on average, {:.1} mm at most", 1e3 * mean, 1e3 * max);
        writeln!(f, "objects simulated   {} of {}", self.simulated, self.objects)?;
        writeln!(f, "stable              {} of {}", self.stable, self.simulated)?;
        writeln!(f, "moved from input    {}", millimetres(self.mean_moved, self.max_moved))?;
        writeln!(f, "drift in the check  {}", millimetres(self.mean_drift, self.max_drift))?;
        writeln!(f, "unstable            {}", list(&self.unstable))?;
        writeln!(f, "fallen over         {}", list(&self.fallen))?;
        write!(f, "lost support        {}", list(&self.lost_support))
    }
}
