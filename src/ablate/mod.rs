//! The paper's ablations: what each of its ideas is worth, one variant of the method at a time.
//!
//! `tables` says which variants there are and what the paper measured of them, `subject` what they are run on, `run`
//! carries one out and measures its result, `store` keeps it.

mod run;
mod store;
mod subject;
mod tables;

pub use run::{Ended, Measured, Run, identity, run};
pub use store::Store;
pub use subject::{Stage, Subject};
pub use tables::{Change, Paper, Row, Table, Term, Variant};
