//! How the log of a farm is written.

use clap::{Args, ValueEnum};

/// How log lines are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum LogForm {
    /// For people.
    #[default]
    Text,
    /// A line of JSON each, for programs that collect logs.
    Json,
}

/// How the log of a farm is written.
#[derive(Clone, Copy, Debug, Args)]
pub(super) struct LogOption {
    /// How log lines are written.
    #[arg(long, value_enum, default_value_t, env = "PHOTONFARM_LOG", value_name = "FORM")]
    pub(super) log: LogForm,
}
