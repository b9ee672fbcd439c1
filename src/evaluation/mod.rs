//! How far a picture is from a reference.

mod metrics;

pub use metrics::{CompareError, Metrics, compare};
