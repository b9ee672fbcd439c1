//! The photon map of one pass: photons sorted by grid cell, gathered in a canonical order.
//!
//! [`trace`] emits a pass's photons in parallel, [`build`](PhotonMap::build) sorts them once. Methods look at them through
//! [`PhotonLookup`], which [`KdTree`] implements as well. The order of photons, and so every rounded sum, depends on the pass alone.

mod build;
mod compact;
mod gather;
mod grid;
mod kd_tree;
mod light_segment;
mod lookup;
mod nearest;
mod photon;

pub use build::{PhotonChunk, trace, trace_chunks, trace_with};
pub use compact::CompactPhoton;
pub use gather::{GatherQuery, Gathered};
pub use grid::Grid;
pub use kd_tree::KdTree;
pub use light_segment::{LightLookup, LightPhoton, LightSegment};
pub use lookup::{OriginLookup, PhotonLookup};
pub use nearest::{FIRST_SEARCH_CELLS, Nearest};
pub use photon::{
    OriginPhoton, PathPhoton, PathSegment, Photon, PhotonColumns, PhotonRecord, PhotonWith, StoredPhoton, TracedPhoton,
};

/// The photons of one pass in a grid, with whatever else methods keep of them.
pub struct PhotonMap<E = ()> {
    grid: Grid,
    /// Index of the first photon of each cell, and the number of photons last.
    cell_start: Vec<u32>,
    photons: PhotonColumns<E>,
}

impl<E> PhotonMap<E> {
    /// What else is kept of the photons, in the order of their indices.
    pub fn extras(&self) -> &[E] {
        &self.photons.extra
    }
}

impl<E: Copy + Sync> PhotonMap<E> {
    /// The photon with an index, and what else is kept of it.
    fn record(&self, index: usize) -> PhotonWith<E> {
        PhotonWith { photon: self.photon(index), extra: self.photons.extra[index] }
    }
}
