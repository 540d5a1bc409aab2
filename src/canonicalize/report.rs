//! What canonicalization did, object by object, and why.

use super::tolerances::{NOTEWORTHY, VISIBLE_SHIFT, VISIBLE_TILT};
use serde::Serialize;
use std::fmt::{Display, Formatter, Result};

/// The document. Lengths in m, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Canonicalization {
    /// The global rotation.
    pub rotation: Rotation,
    /// The angle between the scene's vertical and the file's up axis before; below a degree nothing is turned.
    pub tilt_degrees: f64,
    /// Objects that had a say about the vertical.
    pub votes: usize,
    /// Median angle between an object's up axis and the vertical.
    pub spread_degrees: f64,
    /// How far the turned scene was raised to bring its ground to the room's, m.
    pub ground_shift: f64,
    /// In the scene's order.
    pub objects: Vec<ObjectChange>,
}

/// A rotation in the frame of the file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rotation {
    /// Unit vector.
    pub axis: [f64; 3],
    /// Right-handed about `axis`.
    pub degrees: f64,
}

/// What became of one object, on top of the global rotation and ground shift.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectChange {
    /// Its name.
    pub name: String,
    /// How far it was turned to stand upright, without what its bearer carried it along.
    pub turned_degrees: f64,
    /// How far it was raised onto its support, m, without what its bearer carried it along; negative if lowered.
    pub raised: f64,
    /// Why it was turned, or not.
    pub why_turned: String,
    /// Why it was raised, or not.
    pub why_raised: String,
}

impl Canonicalization {
    /// What a user should know who takes the scene as it was, if it was far from canonical.
    pub fn warning(&self) -> Option<String> {
        let tilted = self.tilt_degrees > VISIBLE_TILT;
        let floating = self.ground_shift.abs() > VISIBLE_SHIFT;
        let shift = format!("{:.2} m {} the ground", self.ground_shift.abs(), side(-self.ground_shift));
        match (tilted, floating) {
            (true, true) => Some(format!("the scene is tilted by {:.1}° and stands {shift}", self.tilt_degrees)),
            (true, false) => Some(format!("the scene is tilted by {:.1}°", self.tilt_degrees)),
            (false, true) => Some(format!("the scene stands {shift}")),
            (false, false) => None,
        }
    }
}

fn side(height: f64) -> &'static str {
    if height > 0.0 { "above" } else { "below" }
}

impl Display for Canonicalization {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let [x, y, z] = self.rotation.axis;
        let objects = self.objects.len();
        let turned: Vec<&ObjectChange> = self.objects.iter().filter(|object| object.turned_degrees > 0.0).collect();
        let largest = turned.iter().map(|object| object.turned_degrees).fold(0.0, f64::max);
        write!(f, "tilt             {:.1}°, ", self.tilt_degrees)?;
        match self.rotation.degrees > 0.0 {
            true => writeln!(f, "turned by {:.1}° about ({x:.2}, {y:.2}, {z:.2})", self.rotation.degrees)?,
            false => writeln!(f, "not turned")?,
        }
        writeln!(f, "evidence         {} of {objects} objects, median {:.1}° off", self.votes, self.spread_degrees)?;
        writeln!(f, "ground           raised by {:.3} m", self.ground_shift)?;
        write!(f, "set upright      {} of {objects} objects, {largest:.1}° at most", turned.len())?;
        for object in &self.objects {
            if object.raised.abs() > NOTEWORTHY {
                write!(
                    f,
                    "\nlook at          {}: raised by {:.2} m, {}",
                    object.name, object.raised, object.why_raised
                )?;
            }
            if object.why_turned.contains("upside down") {
                write!(f, "\nlook at          {}: {}", object.name, object.why_turned)?;
            }
        }
        Ok(())
    }
}
