//! What workers and the command line trust.

use std::path::PathBuf;
use std::sync::Arc;

use rustls::client::danger::{HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier};
use rustls::crypto::{CryptoProvider, ring, verify_tls12_signature, verify_tls13_signature};
use rustls::pki_types::{CertificateDer, ServerName, UnixTime};
use rustls::{CertificateError, ClientConfig, DigitallySignedStruct, Error, RootCertStore, SignatureScheme};
use rustls_platform_verifier::BuilderVerifierExt;

use super::files::{self, IdentityFiles};
use super::fingerprint::Fingerprint;
use super::{TlsError, use_ring};

/// Which coordinators a client trusts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Trust {
    /// Those whose certificates this system trusts.
    #[default]
    System,
    /// Those whose certificates were signed by one of the authorities in a file.
    Authorities(PathBuf),
    /// The one with this certificate, whatever its name.
    Pinned(Fingerprint),
}

/// How a client encrypts: whom it trusts, and the certificate that it shows if it is asked for one.
pub fn configure(trust: &Trust, identity: Option<&IdentityFiles>) -> Result<ClientConfig, TlsError> {
    use_ring();
    let builder = ClientConfig::builder();
    let builder = match trust {
        Trust::System => builder.with_platform_verifier()?,
        Trust::Authorities(file) => {
            let mut authorities = RootCertStore::empty();
            for authority in files::certificates(file)? {
                authorities.add(authority)?;
            }
            builder.with_root_certificates(authorities)
        }
        Trust::Pinned(fingerprint) => {
            let provider = Arc::new(ring::default_provider());
            let pinned = Arc::new(Pinned { fingerprint: *fingerprint, provider });
            builder.dangerous().with_custom_certificate_verifier(pinned)
        }
    };
    Ok(match identity {
        None => builder.with_no_client_auth(),
        Some(identity) => {
            builder.with_client_auth_cert(files::certificates(&identity.certificate)?, files::key(&identity.key)?)?
        }
    })
}

/// Trusts one certificate. That the other side has its key is checked as always.
#[derive(Debug)]
struct Pinned {
    fingerprint: Fingerprint,
    provider: Arc<CryptoProvider>,
}

impl ServerCertVerifier for Pinned {
    fn verify_server_cert(
        &self,
        certificate: &CertificateDer<'_>,
        _intermediates: &[CertificateDer<'_>],
        _name: &ServerName<'_>,
        _ocsp: &[u8],
        _now: UnixTime,
    ) -> Result<ServerCertVerified, Error> {
        if Fingerprint::of(certificate) == self.fingerprint {
            Ok(ServerCertVerified::assertion())
        } else {
            Err(CertificateError::ApplicationVerificationFailure.into())
        }
    }

    fn verify_tls12_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        verify_tls12_signature(message, certificate, signed, &self.provider.signature_verification_algorithms)
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        verify_tls13_signature(message, certificate, signed, &self.provider.signature_verification_algorithms)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.provider.signature_verification_algorithms.supported_schemes()
    }
}
