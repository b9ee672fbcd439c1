//! One picture on many machines: jobs, schedule, coordinator, workers, wire.

pub mod job;
