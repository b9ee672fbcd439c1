//! What a worker leases: consecutive passes of a pixel region.

use serde::{Deserialize, Serialize};

/// A band of whole pixel rows, `row_start ≤ row < row_end`, as wide as the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// First row, counted from the top.
    pub row_start: u32,
    /// One past the last row.
    pub row_end: u32,
}

impl Region {
    /// How many rows the band has.
    pub fn rows(self) -> u32 {
        self.row_end - self.row_start
    }

    /// How many pixels the band has in a picture `width` pixels wide.
    pub fn pixel_count(self, width: u32) -> usize {
        self.rows() as usize * width as usize
    }
}

/// One of the two independent estimates that every job makes: its even passes and its odd passes. Their mean is the picture,
/// their difference tells its noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Twin {
    /// Passes 0, 2, 4, …
    Even = 0,
    /// Passes 1, 3, 5, …
    Odd = 1,
}

/// Passes of one [`Twin`] × a pixel region: `first_pass`, `first_pass + 2`, … How passes are cut into shards is fixed by the
/// job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shard {
    /// Index of the first pass.
    pub first_pass: u32,
    /// Number of passes, at least 1.
    pub passes: u32,
    /// The pixels.
    pub region: Region,
}

impl Twin {
    /// The twin that a pass belongs to.
    pub fn of_pass(pass: u32) -> Self {
        if pass.is_multiple_of(2) { Self::Even } else { Self::Odd }
    }
}

impl Shard {
    /// The twin that all its passes belong to.
    pub fn twin(&self) -> Twin {
        Twin::of_pass(self.first_pass)
    }

    /// The indices of its passes.
    pub fn pass_indices(&self) -> impl Iterator<Item = u32> + use<> {
        let first_pass = self.first_pass;
        (0..self.passes).map(move |pass| first_pass + 2 * pass)
    }
}
