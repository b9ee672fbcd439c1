//! Who traces what: a pure state machine. Time comes in as an argument, answers go out; nothing here waits, locks, or knows
//! clocks, threads and the network.

pub mod lease;
pub mod plan;
pub mod progress;
pub mod roster;
pub mod schedule;
