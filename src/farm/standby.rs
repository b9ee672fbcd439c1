//! Coordinators that wait for their turn: several share a PostgreSQL database and an object store, one leads, and when it is not heard of any
//! more, another one goes on from what is stored.

use std::net::TcpListener;
use std::time::Duration;

use axum::Router;
use tokio::time::sleep;
use tokio_util::sync::CancellationToken;

use super::coordinator::Limits;
use super::events::EVENTS;
use super::http;
use super::store::{Store, StoreError, StoreLocation};
use super::tls::server::ServerTls;

/// How often a coordinator that stands by looks whether somebody leads.
const LOOK: Duration = Duration::from_secs(2);

/// What a coordinator that stands by answers with.
pub(crate) struct Standby {
    /// Where it listens. The socket stays open for whoever has it, too.
    pub listener: TcpListener,
    /// What it answers.
    pub answers: Router,
    /// How it encrypts.
    pub tls: Option<ServerTls>,
}

/// Opens a store as soon as nobody else leads; answers as one that stands by meanwhile.
///
/// # Errors
/// The store cannot be opened for another reason than that another coordinator leads.
pub(crate) async fn open_in_turn(location: &StoreLocation, standby: Standby) -> Result<Store, StoreError> {
    match Store::open(location).await {
        Err(StoreError::InUse { .. }) if location.records.is_shared() => {}
        opened => return opened,
    }
    tracing::info!(target: EVENTS, "another coordinator leads; this one stands by");
    let stopped = CancellationToken::new();
    let server = tokio::spawn(serve(standby, stopped.clone()));
    let opened = loop {
        sleep(LOOK).await;
        match Store::open(location).await {
            Err(StoreError::InUse { .. }) => {}
            Err(problem) if problem.is_temporary() => tracing::debug!(%problem, "who leads is not known"),
            opened => break opened,
        }
    };
    stopped.cancel();
    if let Err(problem) = server.await {
        tracing::error!(%problem, "the standby's server failed");
    }
    tracing::info!(target: EVENTS, "this coordinator leads now");
    opened
}

async fn serve(standby: Standby, stopped: CancellationToken) {
    let Standby { listener, answers, tls } = standby;
    match tokio::net::TcpListener::from_std(listener) {
        Ok(listener) => http::server::serve(listener, answers, &Limits::default(), tls, stopped).await,
        Err(problem) => tracing::error!(%problem, "nobody is told that this coordinator stands by"),
    }
}
