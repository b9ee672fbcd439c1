//! Tallies, the rules that merge them into an estimate, and the picture read from it.
//!
//! A worker returns a [`Tally`]: sums and counts of a [`Shard`], never means. [`Estimate::merge`] folds tallies in shard
//! order; it never asks which method made them. A [`Picture`] is normalised radiance, taken at any time.

pub mod error;
pub mod merging;
pub mod picture;
pub mod picture_files;
pub mod radius;
pub mod shard;
pub mod tally;

pub use error::ErrorEstimate;
pub use merging::{Estimate, MergeError, PixelEstimate, PixelSums};
pub use picture::Picture;
pub use radius::{RadiusField, RadiusRule};
pub use shard::{Region, Shard, Twin};
pub use tally::{PixelTally, Tally, TallyError};
