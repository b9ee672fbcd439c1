//! The command line, as users and scripts meet it.

mod access;
mod commands;
mod evaluate;
mod jobs;
mod maps;
