//! How a worker reaches its coordinator, and a coordinator those that it tells of jobs: over TCP, or over what a test puts in its place.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::http::Uri;
use axum::http::uri::Scheme;
use futures_util::future::BoxFuture;
use hyper_util::client::legacy::connect::{Connected, Connection, HttpConnector};
use hyper_util::rt::TokioIo;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_rustls::TlsConnector;
pub use tokio_rustls::rustls::ClientConfig as TlsSettings;
use tokio_rustls::rustls::pki_types::ServerName;
use tower_service::Service;

use crate::farm::tls::client::{Trust, configure};

/// How long it may take to open a stream.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);
/// How long sent bytes may be unacknowledged: a host that lost its power does not say so.
const SILENCE: Duration = Duration::from_secs(30);

/// A stream of bytes in both directions.
pub trait ByteStream: AsyncRead + AsyncWrite + Send {}

impl<T: AsyncRead + AsyncWrite + Send> ByteStream for T {}

/// Opens byte streams to the host of an address.
#[derive(Clone)]
pub struct Dialer {
    dial: Arc<dyn Fn(Uri) -> BoxFuture<'static, io::Result<Dialed>> + Send + Sync>,
}

impl Dialer {
    /// TCP, without Nagle's delay; encrypted where an address begins with `https`, for which `tls` has to be there.
    pub fn tcp(tls: Option<Arc<TlsSettings>>) -> Self {
        let mut connector = HttpConnector::new();
        #[cfg(target_os = "linux")]
        connector.set_tcp_user_timeout(Some(SILENCE));
        connector.set_keepalive(Some(SILENCE));
        connector.set_nodelay(true);
        connector.enforce_http(false);
        let tls = tls.map(TlsConnector::from);
        Self::new(move |address| {
            let (connected, tls) = (connector.clone().call(address.clone()), tls.clone());
            async move {
                let stream = connected.await.map_err(io::Error::other)?.into_inner();
                if address.scheme() == Some(&Scheme::HTTPS) {
                    encrypted(stream, &address, tls).await
                } else {
                    Ok(Box::pin(stream) as Pin<Box<dyn ByteStream>>)
                }
            }
        })
    }

    /// TCP to those whom this system trusts. Where that cannot be found out, the log says what cannot be done: `loss`.
    pub fn trusting_system(loss: &'static str) -> Self {
        let tls = configure(&Trust::System, None).map_err(|problem| tracing::warn!(%problem, "{loss}"));
        Self::tcp(tls.ok().map(Arc::new))
    }

    /// Whatever `dial` opens.
    pub fn new<Opening, Stream>(dial: impl Fn(Uri) -> Opening + Send + Sync + 'static) -> Self
    where
        Opening: Future<Output = io::Result<Stream>> + Send + 'static,
        Stream: ByteStream + 'static,
    {
        let dial = move |address| -> BoxFuture<'static, io::Result<Dialed>> {
            let opening = timeout(CONNECT_TIMEOUT, dial(address));
            Box::pin(async move { Ok(Dialed(Box::pin(opening.await??))) })
        };
        Self { dial: Arc::new(dial) }
    }
}

/// The stream once both sides agreed on keys, and this one trusts the other.
async fn encrypted(
    stream: TcpStream,
    address: &Uri,
    tls: Option<TlsConnector>,
) -> io::Result<Pin<Box<dyn ByteStream>>> {
    let tls = tls.ok_or_else(|| io::Error::other("nobody says whose certificates are trusted"))?;
    let host = address.host().unwrap_or_default().trim_start_matches('[').trim_end_matches(']').to_owned();
    let name = ServerName::try_from(host).map_err(io::Error::other)?;
    Ok(Box::pin(tls.connect(name, stream).await?))
}

impl Service<Uri> for Dialer {
    type Response = TokioIo<Dialed>;
    type Error = io::Error;
    type Future = BoxFuture<'static, io::Result<TokioIo<Dialed>>>;

    fn poll_ready(&mut self, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    fn call(&mut self, address: Uri) -> Self::Future {
        let opening = (self.dial)(address);
        Box::pin(async move { opening.await.map(TokioIo::new) })
    }
}

/// An open stream.
pub struct Dialed(Pin<Box<dyn ByteStream>>);

impl Connection for Dialed {
    fn connected(&self) -> Connected {
        Connected::new()
    }
}

impl AsyncRead for Dialed {
    fn poll_read(self: Pin<&mut Self>, context: &mut Context<'_>, buffer: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        self.get_mut().0.as_mut().poll_read(context, buffer)
    }
}

impl AsyncWrite for Dialed {
    fn poll_write(self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        self.get_mut().0.as_mut().poll_write(context, bytes)
    }

    fn poll_flush(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.get_mut().0.as_mut().poll_flush(context)
    }

    fn poll_shutdown(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.get_mut().0.as_mut().poll_shutdown(context)
    }

    fn poll_write_vectored(
        self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        self.get_mut().0.as_mut().poll_write_vectored(context, parts)
    }

    fn is_write_vectored(&self) -> bool {
        self.0.is_write_vectored()
    }
}
