//! Kernel `moments`: the Gaussian of the elites, one dimension at a time.

/// Writes mean and standard deviation of the rows `elites` of `deltas` (row-major, one row of `mean.len()` numbers a
/// candidate). Two passes in rank order; the variance is divided by the number of elites, as in the paper. `epsilon` is
/// added to each deviation, and none falls below its `floor`. No elites: nothing changes.
pub fn moments(deltas: &[f32], elites: &[u32], epsilon: f32, floor: &[f32], mean: &mut [f32], std: &mut [f32]) {
    if elites.is_empty() {
        return;
    }
    let dimensions = mean.len();
    let count = elites.len() as f32;
    for d in 0..dimensions {
        let column = || elites.iter().map(|&row| deltas[row as usize * dimensions + d]);
        let average = column().sum::<f32>() / count;
        let variance = column().map(|x| (x - average) * (x - average)).sum::<f32>() / count;
        mean[d] = average;
        std[d] = (variance.sqrt() + epsilon).max(floor[d]);
    }
}
