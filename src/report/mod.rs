//! What a run leaves for people and their tools: the report, the energies as a table, the convex parts as files,
//! the states of a simulation over time.

mod csv;
mod document;
mod parts;
mod summary;
mod trajectory;

pub use csv::energy_csv;
pub use document::{Report, Run};
pub use parts::part_files;
pub use summary::Summary;
pub use trajectory::Trajectory;
