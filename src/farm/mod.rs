//! One picture on many machines: jobs, schedule, coordinator, workers, wire.

pub mod coordinator;
pub mod error;
pub mod job;
pub mod server;
pub mod worker;

pub use coordinator::{CoordinatorHandle, CoordinatorOptions, Layers, SceneSummary};
pub use error::FarmError;
