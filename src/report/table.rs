//! Tables of text for people.

/// A column of numbers: its key in documents, its heading with a unit for people, what makes its values readable, and
/// where they come from.
pub(super) struct Column<V> {
    pub key: &'static str,
    pub heading: &'static str,
    scale: f64,
    decimals: usize,
    pub value: V,
}

pub(super) const fn column<V>(
    key: &'static str,
    heading: &'static str,
    scale: f64,
    decimals: usize,
    value: V,
) -> Column<V> {
    Column { key, heading, scale, decimals, value }
}

impl<V> Column<V> {
    /// A cell; a dash if there is no value.
    pub fn text(&self, value: Option<f64>) -> String {
        value.map_or("–".into(), |value| format!("{:.*}", self.decimals, self.scale * value))
    }
}

/// Rows with their columns aligned: the first to the left, the others, numbers, to the right. No line end after the
/// last.
pub fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|c| c.chars().count()).max();
    let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
    let lines = rows.iter().map(|row| {
        let cells = row.iter().zip(&widths).enumerate();
        let cells: Vec<String> = cells
            .map(
                |(column, (cell, &width))| {
                    if column == 0 { format!("{cell:width$}") } else { format!("{cell:>width$}") }
                },
            )
            .collect();
        cells.join("  ").trim_end().to_owned()
    });
    lines.collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::aligned;

    #[test]
    fn columns_are_aligned_by_characters() {
        let rows = [["name", "µs"], ["solve", "1234"]].map(|row| row.map(String::from).to_vec());
        assert_eq!(aligned(&rows), "name     µs\nsolve  1234");
        assert_eq!(aligned(&[]), "");
    }
}
