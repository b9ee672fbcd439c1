//! Coordinators and workers: their rules alone, on a simulated network, and over real HTTP.

#[path = "../support/fault_proxy.rs"]
mod fault_proxy;
#[path = "../support/hand.rs"]
mod hand;
#[path = "../support/http_client.rs"]
mod http_client;
#[path = "../support/seeds.rs"]
mod seeds;
#[path = "../support/split_mix.rs"]
mod split_mix;

mod end_to_end;
mod lease_state_machine;
mod network;
mod simulation;
mod users;
mod wire_roundtrip;
mod worker_protocol;
