//! A proxy between workers and a coordinator that can be cut: connections break and none is accepted until it is mended.

use std::net::SocketAddr;
use std::sync::Arc;

use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;

/// A running proxy.
pub(crate) struct FaultProxy {
    address: SocketAddr,
    is_cut: Arc<watch::Sender<bool>>,
}

impl FaultProxy {
    /// Forwards to `target` from a free port.
    pub(crate) async fn start(target: SocketAddr) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.expect("a free port");
        let address = listener.local_addr().expect("bound");
        let is_cut = Arc::new(watch::Sender::new(false));
        let cut = is_cut.clone();
        tokio::spawn(async move {
            while let Ok((stream, _)) = listener.accept().await {
                let mut broken = cut.subscribe();
                tokio::spawn(async move {
                    tokio::select! {
                        _ = forward(stream, target) => {}
                        _ = broken.wait_for(|is_cut| *is_cut) => {}
                    }
                });
            }
        });
        Self { address, is_cut }
    }

    /// Where it listens, as a coordinator's address.
    pub(crate) fn url(&self) -> String {
        format!("http://{}", self.address)
    }

    /// Breaks all connections, or lets new ones through again.
    pub(crate) fn cut(&self, is_cut: bool) {
        self.is_cut.send_replace(is_cut);
    }
}

async fn forward(mut from: TcpStream, target: SocketAddr) -> std::io::Result<()> {
    let mut to = TcpStream::connect(target).await?;
    tokio::io::copy_bidirectional(&mut from, &mut to).await?;
    Ok(())
}
