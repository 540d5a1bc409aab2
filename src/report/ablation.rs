//! The ablation tables: ours beside the paper's, for people and for programs.

use super::aligned;
use super::table::{self, column};
use crate::ablate::{Ended, Measured, Paper, Row, Run, Table};
use crate::metrics::{mean, percent};
use serde::Serialize;
use serde_json::{Map, Value};
use std::fmt::{Display, Formatter, Result, Write};

/// The document. Lengths in m, angles in rad, times in s, unless a name says otherwise.
#[derive(Clone, Debug, Serialize)]
pub struct Ablation {
    tool: &'static str,
    version: &'static str,
    /// The configuration as the user named it, with what the command line changed.
    config: String,
    seed: u64,
    backend: String,
    scenes: Vec<String>,
    tables: Vec<AblationTable>,
}

/// One table.
#[derive(Clone, Debug, Serialize)]
pub struct AblationTable {
    name: &'static str,
    title: &'static str,
    rows: Vec<AblationRow>,
}

/// One variant over all scenes.
#[derive(Clone, Debug, Serialize)]
pub struct AblationRow {
    label: &'static str,
    /// Means over the scenes that have a result; `failure_rate_pct` over all.
    ours: Map<String, Value>,
    /// The same keys, as far as the paper has them.
    paper: Map<String, Value>,
    /// Every scene.
    runs: Vec<Run>,
}

/// A metric of a run of ours and of a row of the paper, if they have it.
type Column = table::Column<(fn(&Measured) -> Option<f64>, fn(&Paper) -> Option<f64>)>;

/// The only column that is not a mean over results.
const FAILURES: &str = "failure_rate_pct";

/// In the order of the paper's tables; collisions deeper than 1 mm and the last two are ours alone.
const COLUMNS: [Column; 11] = [
    column(FAILURES, "fail %", 1.0, 0, (|_| None, |p| p.failure_rate_pct)),
    column("collision_rate_pct", "coll. %", 1.0, 1, (|m| Some(m.collision_rate_pct), |p| p.collision_rate_pct)),
    column("collision_rate_1mm_pct", "> 1 mm %", 1.0, 1, (|m| Some(m.collision_rate_1mm_pct), |_| None)),
    column("stable_rate_pct", "stable %", 1.0, 1, (|m| Some(m.stable_rate_pct), |p| Some(p.stable_rate_pct))),
    column("drift_m", "drift mm", 1e3, 1, (|m| Some(m.drift_m), |p| Some(p.drift_m))),
    column("linear_mps", "m/s", 1.0, 3, (|m| Some(m.linear_mps), |p| Some(p.linear_mps))),
    column("angular_radps", "rad/s", 1.0, 3, (|m| Some(m.angular_radps), |p| Some(p.angular_radps))),
    column("chamfer_m", "CD mm", 1e3, 1, (|m| m.chamfer_m, |p| p.chamfer_m)),
    column("f_score", "F", 1.0, 3, (|m| m.f_score, |p| p.f_score)),
    column("moved_m", "moved mm", 1e3, 1, (|m| m.moved_m, |_| None)),
    column("fallen", "fallen", 1.0, 1, (|m| m.fallen.map(|fallen| fallen as f64), |_| None)),
];

fn text(column: &Column, values: &Map<String, Value>) -> String {
    column.text(values.get(column.key).and_then(Value::as_f64))
}

impl AblationRow {
    /// Of the runs of a variant, one a scene.
    pub fn new(row: &Row, runs: Vec<Run>) -> Self {
        let results: Vec<&Measured> = runs.iter().filter_map(result).collect();
        let mut ours = Map::new();
        ours.insert(FAILURES.into(), percent(runs.len() - results.len(), runs.len()).into());
        for column in &COLUMNS {
            let values: Vec<f64> = results.iter().filter_map(|measured| (column.value.0)(measured)).collect();
            if !values.is_empty() {
                ours.insert(column.key.into(), mean(values.into_iter()).into());
            }
        }
        let paper =
            COLUMNS.iter().filter_map(|column| Some((column.key.to_owned(), (column.value.1)(&row.paper)?.into())));
        Self { label: row.label, ours, paper: paper.collect(), runs }
    }
}

fn result(run: &Run) -> Option<&Measured> {
    match &run.ended {
        Ended::Result(measured) => Some(measured),
        Ended::Failure(_) => None,
    }
}

impl AblationTable {
    /// Its rows in the order of `Table::rows`.
    pub fn new(table: Table, rows: Vec<AblationRow>) -> Self {
        Self { name: table.name(), title: table.title(), rows }
    }

    /// One heading, and two lines a row: ours, then the paper's.
    fn cells(&self) -> Vec<Vec<String>> {
        let known = |column: &&Column| {
            self.rows.iter().any(|row| row.ours.contains_key(column.key) || row.paper.contains_key(column.key))
        };
        let columns: Vec<&Column> = COLUMNS.iter().filter(known).collect();
        let line = |first: [&str; 2], text: &dyn Fn(&Column) -> String| -> Vec<String> {
            first.map(String::from).into_iter().chain(columns.iter().map(|column| text(column))).collect()
        };
        let rows = self.rows.iter().flat_map(|row| {
            [
                line([row.label, "ours"], &|column| text(column, &row.ours)),
                line(["", "paper"], &|column| text(column, &row.paper)),
            ]
        });
        [line(["", ""], &|column| column.heading.into())].into_iter().chain(rows).collect()
    }
}

impl Ablation {
    /// The document of finished tables.
    pub fn new(config: String, seed: u64, backend: String, scenes: Vec<String>, tables: Vec<AblationTable>) -> Self {
        let (tool, version) = (env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION"));
        Self { tool, version, config, seed, backend, scenes, tables }
    }

    /// The tables as Markdown.
    pub fn markdown(&self) -> String {
        let mut text = format!("# Ablations\n\n{}\n", self.circumstances());
        for table in &self.tables {
            let cells = table.cells();
            // Writing to a String cannot fail.
            let _ = writeln!(text, "\n## {}\n", table.title);
            for (i, row) in cells.iter().enumerate() {
                let _ = writeln!(text, "| {} |", row.join(" | "));
                if i == 0 {
                    let _ = writeln!(text, "|---|---|{}", "--:|".repeat(row.len() - 2));
                }
            }
        }
        text + &self.failures().iter().map(|failure| format!("\n- {failure}")).collect::<String>() + "\n"
    }

    fn circumstances(&self) -> String {
        let Self { config, seed, backend, scenes, .. } = self;
        format!(
            "Configuration {config}, seed {seed}, {backend}; means over {} scenes: {}.",
            scenes.len(),
            scenes.join(", ")
        )
    }

    /// Each failed run of each row.
    fn failures(&self) -> Vec<String> {
        let rows = self.tables.iter().flat_map(|table| &table.rows);
        rows.flat_map(|row| {
            row.runs.iter().filter_map(|run| match &run.ended {
                Ended::Failure(why) => Some(format!("{} failed on {}: {why}", row.label, run.scene)),
                Ended::Result(_) => None,
            })
        })
        .collect()
    }
}

impl Display for Ablation {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "{}", self.circumstances())?;
        for table in &self.tables {
            write!(f, "\n\n{}\n{}", table.title, aligned(&table.cells()))?;
        }
        for failure in self.failures() {
            write!(f, "\n{failure}")?;
        }
        Ok(())
    }
}
