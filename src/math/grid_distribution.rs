//! Picking one cell of a grid with given weights: a row, then a cell in it.

use super::discrete::Discrete;

/// A distribution over the cells of a grid with probabilities proportional to non-negative weights.
#[derive(Clone, Debug)]
pub(crate) struct GridDistribution {
    rows: Discrete,
    cells: Vec<Discrete>,
}

impl GridDistribution {
    /// Builds from `weights` ≥ 0, row by row, `columns` a row. `None` when they sum to 0 or are not finite.
    pub(crate) fn new(weights: &[f64], columns: usize) -> Option<Self> {
        let sums: Vec<f64> = weights.chunks(columns).map(|row| row.iter().sum()).collect();
        let rows = Discrete::new(&sums)?;
        // Rows without weight are never picked; what stands for them does not matter.
        let any = Discrete::new(&vec![1.0; columns])?;
        let cells = weights.chunks(columns).map(|row| Discrete::new(row).unwrap_or_else(|| any.clone())).collect();
        Some(Self { rows, cells })
    }

    /// The probability with which the cell is picked.
    pub(crate) fn probability(&self, row: usize, column: usize) -> f32 {
        self.rows.probability(row) * self.cells[row].probability(column)
    }

    /// Picks (row, column) with `u` in [0, 1)² and gives back `u` rescaled to [0, 1)² for further use.
    pub(crate) fn pick(&self, u: [f32; 2]) -> ([usize; 2], [f32; 2]) {
        let (row, within_row) = self.rows.pick(u[0]);
        let (column, within_column) = self.cells[row].pick(u[1]);
        ([row, column], [within_row, within_column])
    }
}
