//! What people who run a farm read in its log.

/// Target of log lines for people who run a farm; they are shown unless the log is off.
pub const EVENTS: &str = "photonfarm::events";
