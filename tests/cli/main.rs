//! The command line, as users and scripts meet it.

#[path = "../support/command_line.rs"]
mod command_line;
#[path = "../support/exr_channels.rs"]
mod exr_channels;
#[path = "../support/http_client.rs"]
mod http_client;
#[path = "../support/result_records.rs"]
mod result_records;
#[path = "../support/serving.rs"]
mod serving;

mod access;
mod commands;
mod evaluate;
mod farm_sequences;
mod imported_symbols;
mod jobs;
mod maps;
mod pictures;
mod progress;
mod restarts;
mod scene_input;
mod sequences;
mod shell;
mod tev;
