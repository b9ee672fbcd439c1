//! Certificates and keys in PEM files.

use std::path::{Path, PathBuf};

use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};

use super::TlsError;

/// A certificate with its chain, and its key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IdentityFiles {
    /// The certificate, then those that signed it.
    pub certificate: PathBuf,
    /// Its private key.
    pub key: PathBuf,
}

/// All certificates of a file, at least one.
pub(super) fn certificates(file: &Path) -> Result<Vec<CertificateDer<'static>>, TlsError> {
    let bad = |problem: String| bad_file(file, problem, "give a readable file of certificates in PEM");
    let found = CertificateDer::pem_file_iter(file).map_err(|problem| bad(problem.to_string()))?;
    let found: Vec<_> = found.collect::<Result<_, _>>().map_err(|problem| bad(problem.to_string()))?;
    if found.is_empty() { Err(bad("it holds no certificate".to_owned())) } else { Ok(found) }
}

/// The private key of a file.
pub(super) fn key(file: &Path) -> Result<PrivateKeyDer<'static>, TlsError> {
    PrivateKeyDer::from_pem_file(file)
        .map_err(|problem| bad_file(file, problem.to_string(), "give a readable file with one private key in PEM"))
}

/// What is wrong with a file.
pub(super) fn bad_file(file: &Path, problem: String, remedy: &'static str) -> TlsError {
    TlsError::File { file: file.display().to_string(), problem, remedy }
}
