//! One picture on many machines: jobs, schedule, coordinator, workers, wire.
pub mod coordinator;
mod delivery;
pub mod error;
pub mod job;
pub mod lease;
pub mod merging;
pub mod plan;
pub mod progress;
pub mod request;
pub mod roster;
pub mod schedule;
pub mod server;
pub mod wire;
pub mod worker;

pub use coordinator::{CoordinatorHandle, CoordinatorOptions, Layers, SceneSummary};
pub use error::FarmError;
