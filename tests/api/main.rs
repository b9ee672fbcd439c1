//! The API over real HTTP, as programs meet it: every endpoint, who may use it, encryption and webhooks.

#[path = "../support/exr_channels.rs"]
mod exr_channels;
#[path = "../support/hand.rs"]
mod hand;
#[path = "../support/http_client.rs"]
mod http_client;

mod access;
mod end_to_end;
mod mattes;
mod programs;
mod sequences;
mod tls;
mod webhooks;
