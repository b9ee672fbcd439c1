//! Denoising: what it keeps, what it takes away, what it says of itself, and how it is asked for.

#[expect(dead_code, reason = "other tests use the rest")]
#[path = "../support/command_line.rs"]
mod command_line;
#[path = "../support/exr_channels.rs"]
mod exr_channels;
#[path = "../support/http_client.rs"]
mod http_client;
#[expect(dead_code, reason = "other tests use the rest")]
#[path = "../support/split_mix.rs"]
mod split_mix;

mod asked_for;
mod filter;
mod plain_twin;
mod synthetic;
