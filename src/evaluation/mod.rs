//! How far a picture is from a reference.

mod difference;
mod metrics;

pub use difference::signed_difference;
pub use metrics::{CompareError, Metrics, compare};
