//! The cryptography of TLS.

/// Makes ring the cryptography of this process, which every HTTP client needs before it is built, even one of plain HTTP.
///
/// aws-lc, which the HTTP client would bring by default, takes far longer to build.
pub fn use_ring() {
    // Whoever comes second finds it done.
    let _ = rustls::crypto::ring::default_provider().install_default();
}
