//! `energy.csv`: one line an iteration.

use crate::optimize::Outcome;
use crate::world::Status;
use std::fmt::Write;

/// The iterations of all groups. Energies are weighted sums in `best`, `iteration_best` and `elite_mean`; the four
/// terms of the best candidate are unweighted. An energy that does not exist (no usable candidate) is an empty field.
pub fn energy_csv(outcome: &Outcome) -> String {
    let mut text =
        String::from("group,name,iteration,best,stability,velocity,penetration,layout,iteration_best,elite_mean");
    for fault in Status::FAULTS {
        text += &format!(",{}", fault.name);
    }
    text.push('\n');
    for record in &outcome.iterations {
        let stats = &record.stats;
        let best = &stats.best;
        let name = outcome.groups.get(record.group).map_or("", |group| &group.name);
        // Writing to a String cannot fail.
        let _ = write!(text, "{},{},{}", record.group, field(name), stats.iteration);
        for energy in [best.total, best.stability, best.velocity, best.penetration, best.layout] {
            let _ = write!(text, ",{}", number(energy, best.total.is_finite()));
        }
        for energy in [stats.iteration_best, stats.elite_mean] {
            let _ = write!(text, ",{}", number(energy, energy.is_finite()));
        }
        for count in stats.flagged {
            let _ = write!(text, ",{count}");
        }
        text.push('\n');
    }
    text
}

fn number(value: f32, exists: bool) -> String {
    if exists { value.to_string() } else { String::new() }
}

/// A text as one field (RFC 4180).
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}
