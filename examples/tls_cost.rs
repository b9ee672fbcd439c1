//! What encryption costs: bodies as large as the tally of a 1080p picture go from a worker's connection to a coordinator's server, both in this
//! process, plain and encrypted in turns. `cargo run --release --example tls_cost`; about ten seconds. Figures stand in `docs/measured/PERFORMANCE.md`.

use std::sync::Arc;
use std::time::Instant;

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{Request, Uri};
use axum::routing::post;
use hyper_util::client::legacy;
use hyper_util::rt::TokioExecutor;
use photonfarm::farm::Limits;
use photonfarm::farm::dial::Dialer;
use photonfarm::farm::http::server::serve;
use photonfarm::farm::tls::client::{Trust, configure};
use photonfarm::farm::tls::server::ServerTls;
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

const BODY: usize = 52_000_000;
const BODIES: usize = 20;
const TURNS: usize = 3;
/// The rate for which the share of a processor is told, bytes a second.
const RATE: f64 = 200e6;

#[tokio::main]
async fn main() -> Fallible<()> {
    let body: bytes::Bytes = (0..BODY).map(|index| (index * 2_654_435_761) as u8).collect::<Vec<u8>>().into();
    println!("{:>9} {:>8} {:>14}", "", "MB/s", "processor s/GB");
    for _ in 0..TURNS {
        let plain = cost(None, &body).await?;
        let encrypted = cost(Some(ServerTls::automatic(None, &["localhost".to_owned()], None)?), &body).await?;
        let gigabytes = (BODY * BODIES) as f64 / 1e9;
        for (name, cost) in [("plain", plain), ("encrypted", encrypted)] {
            println!("{name:>9} {:>8.0} {:>14.2}", gigabytes * 1e3 / cost.seconds, cost.processor / gigabytes);
        }
        let further = (encrypted.processor - plain.processor) / gigabytes * RATE / 1e9;
        println!("at 200 MB/s both ends together take {:.1} % of one processor more", 100.0 * further);
    }
    Ok(())
}

#[derive(Clone, Copy)]
struct Cost {
    seconds: f64,
    processor: f64,
}

async fn cost(tls: Option<ServerTls>, body: &bytes::Bytes) -> Fallible<Cost> {
    let listener = TcpListener::bind("127.0.0.1:0").await?;
    let address = listener.local_addr()?;
    let scheme = if tls.is_some() { "https" } else { "http" };
    let trusted = tls.as_ref().map(|tls| configure(&Trust::Pinned(tls.fingerprint()), None)).transpose()?;
    let sink =
        |body: Body| async move { to_bytes(body, BODY).await.map(|bytes| bytes.len().to_string()).unwrap_or_default() };
    let application = Router::new().route("/", post(sink));
    let stopped = CancellationToken::new();
    let ended = stopped.clone();
    let server = tokio::spawn(async move { serve(listener, application, &Limits::default(), tls, ended).await });
    let client = legacy::Client::builder(TokioExecutor::new()).build::<_, Body>(Dialer::tcp(trusted.map(Arc::new)));
    let uri: Uri = format!("{scheme}://{address}/").parse()?;
    let (start, before) = (Instant::now(), processor_seconds()?);
    for _ in 0..BODIES {
        let request = Request::post(uri.clone()).body(Body::from(body.clone()))?;
        let answer = to_bytes(Body::new(client.request(request).await?.into_body()), 100).await?;
        assert_eq!(answer, BODY.to_string());
    }
    let cost = Cost { seconds: start.elapsed().as_secs_f64(), processor: processor_seconds()? - before };
    drop(client);
    stopped.cancel();
    server.await?;
    Ok(cost)
}

/// Processor time of this process so far, in user and system mode; the system counts it in hundredths of a second.
fn processor_seconds() -> Fallible<f64> {
    let text = std::fs::read_to_string("/proc/self/stat")?;
    let fields: Vec<&str> = text.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks: Vec<u64> = [11, 12].iter().filter_map(|index| fields.get(*index)?.parse().ok()).collect();
    Ok(ticks.iter().sum::<u64>() as f64 / 100.0)
}
