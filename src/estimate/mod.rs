//! Tallies, the rules that merge them into an estimate, and the picture read from it.
//!
//! A method declares what its tallies hold (a [`Declaration`]). A worker returns a [`Tally`]: sums and counts of a [`Shard`], never
//! means. [`Estimate::merge`] folds tallies in shard order by the declared rules; it never asks which method made them. A
//! [`Picture`] is normalised radiance, taken at any time.

pub mod declaration;
pub mod denoise;
pub(crate) mod error;
pub(crate) mod evenness;
mod group_sums;
pub(crate) mod merging;
pub(crate) mod picture;
pub mod picture_files;
pub mod radius;
pub(crate) mod reading;
pub(crate) mod shard;
mod shard_sums;
pub(crate) mod shrinking;
pub mod snapshot;
pub(crate) mod tally;

pub use declaration::{Declaration, PlaneDeclaration, PlaneRule, ScalarDeclaration, ScalarRule};
pub use error::ErrorEstimate;
pub use group_sums::GroupSums;
pub use merging::{Acceptance, Estimate, EstimateError, MergeError};
pub use picture::Picture;
pub use radius::{RadiusField, RadiusRule};
pub use reading::PixelSums;
pub use shard::{Region, Shard, Twin};
pub use shard_sums::{PixelEvenness, PixelTally, RowSums, ShardSums};
pub use shrinking::PixelEstimate;
pub use tally::{ProposalCount, Tally, TallyError};
