//! Stores of coordinators: a real SQLite file always, real servers where the environment names them.

#[path = "../support/http_client.rs"]
mod http_client;

mod records;
mod standby;

/// The tests share the database and the bucket.
static ONE_AT_A_TIME: tokio::sync::Mutex<()> = tokio::sync::Mutex::const_new(());
