//! The command line, as users and scripts meet it.

#[path = "../support/command_line.rs"]
mod command_line;
#[path = "../support/exr_channels.rs"]
mod exr_channels;

mod access;
mod commands;
mod evaluate;
mod jobs;
mod maps;
mod pictures;
mod progress;
mod scene_input;
mod sequences;
mod shell;
mod tev;
