//! The HTTP client of tests.

use std::time::Duration;

/// A client that gives up after `patience`.
pub(crate) fn http_client(patience: Duration) -> reqwest::Client {
    photonfarm::farm::tls::use_ring();
    reqwest::Client::builder().no_proxy().timeout(patience).build().expect("a client")
}
