//! Means over squares of pixels.

/// The mean over the pixels that are at most `reach` rows and columns away. Every sum is made anew: a running one would keep rounding errors of
/// bright pixels after these have left it.
pub(super) fn box_mean(values: &[f64], width: usize, reach: usize) -> Vec<f64> {
    let height = values.len() / width.max(1);
    let around = |place: usize, size: usize| place.saturating_sub(reach)..(place + reach + 1).min(size);
    let mut rows = Vec::with_capacity(values.len());
    for row in values.chunks_exact(width.max(1)) {
        rows.extend((0..width).map(|column| row[around(column, width)].iter().sum::<f64>()));
    }
    let mean = |index: usize| {
        let (row, column) = (index / width, index % width);
        let near = around(row, height);
        let count = near.len() * around(column, width).len();
        near.map(|row| rows[row * width + column]).sum::<f64>() / count as f64
    };
    (0..values.len()).map(mean).collect()
}
