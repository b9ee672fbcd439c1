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

/// A range of consecutive passes × a pixel region. How passes are cut into shards is fixed by the job.
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
