//! Where a picture looks for photons: importons in a grid, and with what probability a photon is worth storing [Wald 1999, section 4.7].

use super::photon_map::{Grid, Photon};
use crate::math::Vec3;

/// A place where photons are looked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Importon {
    /// Position, m.
    pub position: Vec3,
    /// What the photons there count for in the picture; any scale.
    pub importance: f32,
}

/// The grid begins with so many cells along the scene's longest side.
const FINEST: u16 = 128;
/// Cells are enlarged until a mean importon sees so many around it.
const LEAST_SEEN: f64 = 16.0;
/// At most so many cells.
const MOST_CELLS: u64 = 1 << 20;
/// The least probability of storing a photon: none weighs more than its inverse times its flux.
pub(crate) const LEAST_ACCEPTANCE: f32 = 1.0 / 32.0;
/// Photons are all stored from this share of the importance on that a mean importon sees.
const ENOUGH: f32 = 0.25;

/// Importance by place.
pub(crate) struct ImportanceMap {
    grid: Grid,
    /// Of each cell and those around it.
    importance: Vec<f32>,
    /// One over the importance from which on all photons are stored.
    inverse_enough: f32,
}

impl ImportanceMap {
    /// A map between the smallest and the largest coordinates, m; `None` where there is no importon.
    pub(crate) fn new((low, high): (Vec3, Vec3), importons: &[Importon]) -> Option<Self> {
        let total: f64 = importons.iter().map(|importon| f64::from(importon.importance)).sum();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let longest = (high - low).max_element();
        let mut cells = FINEST;
        let (grid, importance) = loop {
            let grid = Grid::new(low, high, longest / f32::from(cells), MOST_CELLS);
            let (importance, seen) = spread(&grid, importons);
            if cells == 1 || seen >= LEAST_SEEN * importons.len() as f64 {
                break (grid, importance);
            }
            cells /= 2;
        };
        let at = |importon: &Importon| importance[grid.cell(grid.coordinates(importon.position))];
        let mean = importons.iter().map(|importon| f64::from(importon.importance * at(importon))).sum::<f64>() / total;
        Some(Self { grid, inverse_enough: 1.0 / (ENOUGH * mean as f32), importance })
    }

    /// The same for a photon.
    #[inline]
    pub(crate) fn of(&self, photon: &Photon) -> f32 {
        self.acceptance(Vec3::from_array(photon.position))
    }

    /// The probability with which a photon at `position` is stored: p_min + (1 − p_min)·I/I_enough, at most 1.
    #[inline]
    pub(crate) fn acceptance(&self, position: Vec3) -> f32 {
        let importance = self.importance[self.grid.cell(self.grid.coordinates(position))];
        (LEAST_ACCEPTANCE + (1.0 - LEAST_ACCEPTANCE) * importance * self.inverse_enough).min(1.0)
    }
}

/// The importance in and around each cell, and the importons there, summed over all importons.
fn spread(grid: &Grid, importons: &[Importon]) -> (Vec<f32>, f64) {
    let mut importance = vec![0.0; grid.cell_count()];
    let mut counts = vec![0_u32; grid.cell_count()];
    for importon in importons {
        for cell in grid.around(grid.coordinates(importon.position)) {
            importance[cell] += importon.importance;
            counts[cell] += 1;
        }
    }
    let seen = |importon: &Importon| f64::from(counts[grid.cell(grid.coordinates(importon.position))]);
    let seen = importons.iter().map(seen).sum();
    (importance, seen)
}
