//! How fast a backend simulates: a population of one scene, measured until the numbers settle, and how the speed
//! changes with the number of candidates, bodies and hulls.

mod contest;
mod measure;
mod subject;
mod sweep;

pub use contest::{Speed, contest};
pub use measure::{Effort, Measurement, mean_drift, measure, median};
pub use subject::{NOISE, Subject, starts};
pub use sweep::{Point, Quantity, plan};
