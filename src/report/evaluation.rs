//! The metrics of a scene, and of many.

use super::aligned;
use super::table::{self, column};
use crate::metrics::{Collision, Detection, Geometry, Layout, Stability, TOUCHING, mean, percent};
use serde::Serialize;
use serde_json::{Map, Value};
use std::fmt::{Display, Formatter, Result};

/// Everything that was measured of one scene. Serializes with its parts side by side; what was not asked for is absent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Metrics {
    /// The scene as it was named.
    pub scene: String,
    /// Objects in it.
    pub objects: usize,
    /// Collisions of meshes.
    pub collision: Collision,
    /// Motion when left to itself.
    pub stability: Stability,
    /// Beside a reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub geometry: Option<Geometry>,
    /// Beside a reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layout: Option<Layout>,
    /// Of masks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub detection: Option<Detection>,
}

/// Many scenes together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Overall {
    /// Scenes without a valid result, of those that were named, % (paper: failure rate).
    pub failure_rate_pct: f64,
    /// Every metric over the scenes that have it.
    pub over_scenes: Map<String, Value>,
    /// Each scene that could be measured.
    pub scenes: Vec<Metrics>,
    /// Why each of the others could not.
    pub failures: Vec<String>,
}

/// Mean and standard deviation of a metric over scenes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Arithmetic.
    pub mean: f64,
    /// Of the scenes themselves: the squares are divided by their number.
    pub standard_deviation: f64,
    /// How many scenes have it.
    pub scenes: usize,
}

/// A metric of a scene, if it has it.
type Column = table::Column<fn(&Metrics) -> Option<f64>>;

/// What is summed up over scenes, in the order of the table.
const COLUMNS: [Column; 16] = [
    column("collision_rate_pct", "coll. %", 1.0, 1, |m| Some(m.collision.strict.collision_rate_pct)),
    column("collision_rate_1mm_pct", "> 1 mm %", 1.0, 1, |m| Some(m.collision.deeper_than_1mm.collision_rate_pct)),
    column("stable_rate_pct", "stable %", 1.0, 1, |m| m.stability.means.map(|s| s.stable_rate_pct)),
    column("mean_position_drift_m", "drift mm", 1e3, 1, |m| m.stability.means.map(|s| s.mean_position_drift_m)),
    column("mean_rotation_drift_rad", "drift °", DEGREES, 2, |m| m.stability.means.map(|s| s.mean_rotation_drift_rad)),
    column("mean_peak_linear_velocity_mps", "peak m/s", 1.0, 3, |m| {
        m.stability.means.map(|s| s.mean_peak_linear_velocity_mps)
    }),
    column("mean_peak_angular_velocity_radps", "rad/s", 1.0, 3, |m| {
        m.stability.means.map(|s| s.mean_peak_angular_velocity_radps)
    }),
    column("chamfer_distance_m", "CD mm", 1e3, 1, |m| m.geometry.as_ref().map(|g| g.chamfer_distance_m)),
    column("f_score", "F", 1.0, 3, |m| m.geometry.as_ref().map(|g| g.f_score)),
    column("box_iou", "B-IoU", 1.0, 3, |m| m.geometry.as_ref().map(|g| g.box_iou)),
    column("mean_translation_m", "moved mm", 1e3, 1, |m| m.layout.as_ref().map(|l| l.mean_translation_m)),
    column("mean_rotation_rad", "turned °", DEGREES, 1, |m| m.layout.as_ref().map(|l| l.mean_rotation_rad)),
    column("fallen", "fallen", 1.0, 0, |m| m.layout.as_ref().map(|l| l.fallen.len() as f64)),
    column("recall_at_50", "recall", 1.0, 3, |m| m.detection.as_ref().map(|d| d.recall_at_50)),
    column("mean_iou", "mask IoU", 1.0, 3, |m| m.detection.as_ref().map(|d| d.mean_iou)),
    column("miss_rate", "missed", 1.0, 3, |m| m.detection.as_ref().map(|d| d.miss_rate)),
];

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

fn spread(column: &Column, scenes: &[Metrics]) -> Option<Spread> {
    let values: Vec<f64> = scenes.iter().filter_map(column.value).collect();
    let middle = mean(values.iter().copied());
    let variance = mean(values.iter().map(|value| (value - middle).powi(2)));
    (!values.is_empty()).then_some(Spread { mean: middle, standard_deviation: variance.sqrt(), scenes: values.len() })
}

/// The columns that any of the scenes has.
fn columns(scenes: &[Metrics]) -> impl Iterator<Item = &'static Column> + '_ {
    COLUMNS.iter().filter(|column| scenes.iter().any(|scene| (column.value)(scene).is_some()))
}

/// One heading, and one row a scene.
fn table(scenes: &[Metrics]) -> Vec<Vec<String>> {
    let heading = ["scene", "objects"].into_iter().chain(columns(scenes).map(|column| column.heading));
    let row = |scene: &Metrics| {
        let values = columns(scenes).map(|column| column.text((column.value)(scene)));
        [scene.scene.clone(), scene.objects.to_string()].into_iter().chain(values).collect()
    };
    [heading.map(String::from).collect()].into_iter().chain(scenes.iter().map(row)).collect()
}

impl Overall {
    /// Of the scenes that were measured and the reasons why others were not.
    pub fn new(scenes: Vec<Metrics>, failures: Vec<String>) -> Self {
        let failed = failures.len() + scenes.iter().filter(|scene| !scene.stability.valid).count();
        let entry =
            |column: &Column| Some((column.key.to_owned(), serde_json::to_value(spread(column, &scenes)?).ok()?));
        Self {
            failure_rate_pct: percent(failed, scenes.len() + failures.len()),
            over_scenes: columns(&scenes).filter_map(entry).collect(),
            scenes,
            failures,
        }
    }
}

impl Display for Metrics {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "{}", aligned(&table(std::slice::from_ref(self))))?;
        let unstable = self.stability.objects.iter().filter(|object| !object.stable);
        for object in unstable {
            let (drift, turn) = (1e3 * object.drift_m, DEGREES * object.rotation_rad);
            write!(f, "\nunstable: {} (moved {drift:.0} mm, turned {turn:.0}°)", object.name)?;
        }
        for pair in self.collision.pairs.iter().filter(|pair| pair.depth_m >= TOUCHING) {
            write!(f, "\nin one another: {} and {} ({:.1} mm)", pair.a, pair.b, 1e3 * pair.depth_m)?;
        }
        for name in self.layout.iter().flat_map(|layout| &layout.fallen) {
            write!(f, "\nfallen over: {name}")?;
        }
        Ok(())
    }
}

impl Display for Overall {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let mut rows = table(&self.scenes);
        let total: Vec<_> = columns(&self.scenes).map(|column| (column, spread(column, &self.scenes))).collect();
        for (name, value) in
            [("mean", (|s| s.mean) as fn(Spread) -> f64), ("standard deviation", |s| s.standard_deviation)]
        {
            let values = total.iter().map(|(column, spread)| column.text(spread.map(value)));
            rows.push([name.to_owned(), String::new()].into_iter().chain(values).collect());
        }
        writeln!(f, "{}", aligned(&rows))?;
        write!(f, "failure rate {:.1} %", self.failure_rate_pct)
    }
}
