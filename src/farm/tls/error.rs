//! Why there is no TLS.

/// A certificate, a key or a choice of them that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TlsError {
    /// A file cannot be read or written, or does not hold what it should.
    #[error("{file}: {problem}; {remedy}")]
    File {
        /// The file.
        file: String,
        /// What is wrong with it.
        problem: String,
        /// What the user can do.
        remedy: &'static str,
    },
    /// Certificates and keys do not go together.
    #[error(
        "this certificate cannot be used: {0}; give the certificate that belongs to the key, with its chain, in PEM"
    )]
    Unusable(#[from] rustls::Error),
    /// No certificate can be made here.
    #[error("no certificate can be made: {0}; give one with --tls-certificate and --tls-key")]
    Making(#[from] rcgen::Error),
    /// Those who sign for clients are not known.
    #[error("certificates of clients cannot be checked: {0}; give the authority that signed them, in PEM")]
    Clients(String),
}
