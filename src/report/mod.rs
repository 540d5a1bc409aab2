//! What a run leaves for people and their tools: the report, also as a page, the energies as a table, the convex parts
//! as files, the states of a simulation over time, tables and curves of measurements.

mod ablation;
mod chart;
mod csv;
mod document;
mod evaluation;
mod html;
mod parts;
mod summary;
mod table;
mod trajectory;

pub use ablation::{Ablation, AblationRow, AblationTable};
pub use chart::{Chart, svg};
pub use csv::energy_csv;
pub use document::{Report, Run};
pub use evaluation::{Metrics, Overall, Spread};
pub use html::html;
pub use parts::part_files;
pub use summary::Summary;
pub use table::aligned;
pub use trajectory::Trajectory;
