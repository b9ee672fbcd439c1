//! TLS: certificates of coordinators, and whom their clients trust.
//!
//! | file | what |
//! |---|---|
//! | [`fingerprint`] | by what people compare certificates |
//! | [`files`] | certificates and keys in PEM files |
//! | [`server`] | a coordinator's own certificate, given or made here |
//! | [`client`] | what workers and the command line trust |

pub mod client;
mod error;
pub mod files;
pub mod fingerprint;
pub mod server;

pub use error::TlsError;

/// Makes ring the cryptography of this process, which every HTTP client needs before it is built, even one of plain HTTP.
///
/// aws-lc, which the HTTP client would bring by default, takes far longer to build.
pub fn use_ring() {
    // Whoever comes second finds it done.
    let _ = rustls::crypto::ring::default_provider().install_default();
}
