//! The result in a few lines.

use crate::optimize::{ObjectOutcome, Outcome, Placement};
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
    /// Those within the limits of the check, and not stuck in another.
    pub stable: usize,
    /// Mean distance from the input, m.
    pub mean_moved: f64,
    /// Largest distance from the input, m.
    pub max_moved: f64,
    /// Those that were put onto a wall or the ceiling.
    pub hung: usize,
    /// Their mean distance from the input, m.
    pub mean_moved_hung: f64,
    /// Their largest distance from the input, m.
    pub max_moved_hung: f64,
    /// Mean distance moved during the check, m.
    pub mean_drift: f64,
    /// Largest distance moved during the check, m.
    pub max_drift: f64,
    /// Names of the objects that did not stay during the check.
    pub unstable: Vec<String>,
    /// Names of the objects that did not stay with other convex parts of the same meshes.
    pub unstable_otherwise: Vec<String>,
    /// Names of the objects that turned by more than 30° from the input.
    pub fallen: Vec<String>,
    /// Names of the objects that their parent no longer bears.
    pub lost_support: Vec<String>,
    /// How many those are.
    pub support_violations: usize,
    /// Farthest that the exact step moved an object, m.
    pub max_parted: f64,
    /// Objects that the exact step moved.
    pub parted: usize,
    /// Pairs of objects whose meshes still meet, by name.
    pub mesh_overlaps: Vec<[String; 2]>,
}

impl Summary {
    /// Of the outcome's objects, in the scene's order.
    pub fn new(scene: &Scene, outcome: &Outcome) -> Self {
        let simulated: Vec<&ObjectOutcome> = outcome.objects.iter().filter(|object| object.simulated).collect();
        let is_hung = |(object, placement): &(&ObjectOutcome, &Option<Placement>)| {
            !object.simulated && placement.as_ref().is_some_and(|placement| placement.side.is_some())
        };
        let placed = outcome.objects.iter().zip(&outcome.placements);
        let hung: Vec<&ObjectOutcome> = placed.filter(is_hung).map(|(object, _)| object).collect();
        let mean_and_max = |objects: &[&ObjectOutcome], value: fn(&ObjectOutcome) -> f64| {
            let values = objects.iter().map(|object| value(object));
            (
                values.clone().fold(0.0, |sum, value| sum + value) / objects.len().max(1) as f64,
                values.fold(0.0, f64::max),
            )
        };
        let names = |which: fn(&ObjectOutcome) -> bool| -> Vec<String> {
            let objects = scene.objects.iter().zip(&outcome.objects);
            objects.filter(|(_, outcome)| which(outcome)).map(|(object, _)| object.name.clone()).collect()
        };
        let (mean_moved, max_moved) = mean_and_max(&simulated, |object| object.moved);
        let (mean_moved_hung, max_moved_hung) = mean_and_max(&hung, |object| object.moved);
        let (mean_drift, max_drift) = mean_and_max(&simulated, |object| object.drift);
        let lost_support = names(|object| object.lost_support);
        let parted = || outcome.clearances.shifts.iter().map(|shift| shift.length()).filter(|shift| *shift > 0.0);
        Self {
            objects: outcome.objects.len(),
            simulated: simulated.len(),
            stable: simulated.iter().filter(|object| object.stable).count(),
            mean_moved,
            max_moved,
            hung: hung.len(),
            mean_moved_hung,
            max_moved_hung,
            mean_drift,
            max_drift,
            unstable: names(|object| object.simulated && !object.stable),
            unstable_otherwise: names(|object| object.simulated && !object.stable_otherwise),
            fallen: names(|object| object.fallen),
            support_violations: lost_support.len(),
            lost_support,
            max_parted: parted().fold(0.0, f64::max),
            parted: parted().count(),
            mesh_overlaps: (outcome.clearances.overlaps.iter())
                .map(|overlap| overlap.objects.map(|object| scene.objects[object].name.clone()))
                .collect(),
        }
    }
}

impl Summary {
    /// What the exact step did, in a line.
    pub fn exact(&self) -> String {
        format!(
            "exact step: {} of {} objects moved, {:.2} mm at most; {} pairs of meshes still overlap",
            self.parted,
            self.objects,
            1e3 * self.max_parted,
            self.mesh_overlaps.len()
        )
    }
}

impl Display for Summary {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let list = |names: &[String]| if names.is_empty() { "none".into() } else { names.join(", ") };
        let millimetres = |mean: f64, max: f64| format!("{:.1} mm on average, {:.1} mm at most", 1e3 * mean, 1e3 * max);
        writeln!(f, "objects simulated   {} of {}", self.simulated, self.objects)?;
        writeln!(f, "stable              {} of {}", self.stable, self.simulated)?;
        writeln!(f, "moved from input    {}", millimetres(self.mean_moved, self.max_moved))?;
        if self.hung > 0 {
            writeln!(f, "moved to walls      {}", millimetres(self.mean_moved_hung, self.max_moved_hung))?;
        }
        writeln!(f, "drift in the check  {}", millimetres(self.mean_drift, self.max_drift))?;
        writeln!(f, "unstable            {}", list(&self.unstable))?;
        writeln!(f, "with other parts    {}", list(&self.unstable_otherwise))?;
        writeln!(f, "fallen over         {}", list(&self.fallen))?;
        writeln!(f, "lost support        {}", list(&self.lost_support))?;
        let overlapping: Vec<String> = self.mesh_overlaps.iter().map(|[a, b]| format!("{a} and {b}")).collect();
        write!(f, "meshes overlapping  {}", list(&overlapping))
    }
}
