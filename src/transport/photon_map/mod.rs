//! The photon map of one pass: photons sorted by grid cell, gathered in a canonical order.
//!
//! [`trace`] emits a pass's photons in parallel, [`build`](PhotonMap::build) sorts them once, [`PhotonMap::gather`] sums
//! them around a point. The order of photons, and so every rounded sum, depends on the pass alone.

mod build;
mod gather;
mod grid;
mod nearest;
mod photon;

pub use build::{PhotonChunk, trace};
pub use gather::{GatherQuery, Gathered};
pub use grid::Grid;
pub use nearest::{FIRST_SEARCH_CELLS, Nearest};
pub use photon::{Photon, PhotonColumns};

/// The photons of one pass.
pub struct PhotonMap {
    grid: Grid,
    /// Index of the first photon of each cell, and the number of photons last.
    cell_start: Vec<u32>,
    photons: PhotonColumns,
}

impl PhotonMap {
    /// How many photons it holds.
    pub fn len(&self) -> usize {
        self.cell_start.last().map_or(0, |count| *count as usize)
    }

    /// Whether it holds none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
