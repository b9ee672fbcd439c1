//! The coordinator's server: so many connections at a time, and none that says nothing.

use std::future::ready;
use std::io;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::Request;
use axum::middleware::map_request;
use futures_util::{StreamExt, stream};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use hyper_util::service::TowerToHyperService;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Semaphore;
use tokio::time::{sleep, timeout};
use tokio_rustls::TlsAcceptor;
use tokio_util::sync::CancellationToken;

use super::patient_stream::PatientStream;
use crate::farm::coordinator::Limits;
use crate::farm::tls::server::ServerTls;

/// The pause after a connection could not be accepted, for example because the process has no file descriptor left.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// What a connection is read from and written to.
trait Stream: AsyncRead + AsyncWrite + Send + Unpin {}

impl<T: AsyncRead + AsyncWrite + Send + Unpin> Stream for T {}

/// Serves until `stopped`, then lets open requests end. A connection is closed when no request or no further byte of one comes for
/// [`Limits::silence`], or nothing of an answer is read for as long. Encrypted connections only, where `tls` is given.
pub async fn serve(
    listener: TcpListener,
    application: Router,
    limits: &Limits,
    tls: Option<ServerTls>,
    stopped: CancellationToken,
) {
    let tls = tls.map(|tls| TlsAcceptor::from(tls.config()));
    let silence = Duration::from_secs(limits.silence);
    let application = application.layer(map_request(move |request| ready(with_patience(request, silence))));
    let slots = Arc::new(Semaphore::new(limits.connections));
    let open = GracefulShutdown::new();
    let mut server = http1::Builder::new();
    server.timer(TokioTimer::new()).header_read_timeout(silence);
    loop {
        let next = async { (slots.clone().acquire_owned().await, listener.accept().await) };
        let Some((slot, accepted)) = stopped.run_until_cancelled(next).await else { break };
        let stream = match accepted {
            Ok((stream, _)) => stream,
            Err(problem) => {
                tracing::warn!(%problem, "a connection could not be accepted");
                sleep(ACCEPT_PAUSE).await;
                continue;
            }
        };
        // Without it, small answers wait for acknowledgements.
        if let Err(problem) = stream.set_nodelay(true) {
            tracing::debug!(%problem, "a connection is gone already");
        }
        let service = TowerToHyperService::new(application.clone());
        let (server, watcher, tls) = (server.clone(), open.watcher(), tls.clone());
        tokio::spawn(async move {
            let ended = match timeout(silence, encrypted(stream, tls)).await {
                Ok(Ok(stream)) => {
                    let stream = PatientStream::new(stream, silence);
                    let connection = server.serve_connection(TokioIo::new(stream), service);
                    watcher.watch(connection).await.map_err(io::Error::other)
                }
                Ok(Err(problem)) => Err(problem),
                Err(_) => Err(io::ErrorKind::TimedOut.into()),
            };
            if let Err(problem) = ended {
                tracing::debug!(%problem, "a connection ended early");
            }
            drop(slot);
        });
    }
    drop(listener);
    open.shutdown().await;
}

/// The stream itself, or what it is once both sides agreed on keys.
async fn encrypted(stream: TcpStream, tls: Option<TlsAcceptor>) -> io::Result<Box<dyn Stream>> {
    Ok(match tls {
        Some(tls) => Box::new(tls.accept(stream).await?),
        None => Box::new(stream),
    })
}

/// The same request; its body fails with [`io::ErrorKind::TimedOut`] when it falls silent.
fn with_patience(request: Request, silence: Duration) -> Request {
    request.map(|body| Body::from_stream(patient(body, silence)))
}

fn patient(body: Body, silence: Duration) -> impl futures_util::Stream<Item = io::Result<Bytes>> {
    stream::unfold(Some(body.into_data_stream()), move |chunks| async move {
        let mut chunks = chunks?;
        match timeout(silence, chunks.next()).await {
            Ok(next) => Some((next?.map_err(io::Error::other), Some(chunks))),
            Err(_) => {
                let text = format!("no byte came for {} s", silence.as_secs());
                Some((Err(io::Error::new(io::ErrorKind::TimedOut, text)), None))
            }
        }
    })
}

/// Whether a body failed because it fell silent.
pub fn fell_silent(problem: &(dyn std::error::Error + 'static)) -> bool {
    let mut cause = Some(problem);
    while let Some(problem) = cause {
        if problem.downcast_ref::<io::Error>().is_some_and(|problem| problem.kind() == io::ErrorKind::TimedOut) {
            return true;
        }
        cause = problem.source();
    }
    false
}
