//! A coordinator's own certificate, given or made here.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use rcgen::{CertificateParams, DistinguishedName, DnType, KeyPair};
use rustls::pki_types::{CertificateDer, PrivateKeyDer, PrivatePkcs8KeyDer};
use rustls::server::WebPkiClientVerifier;
use rustls::{RootCertStore, ServerConfig};

use super::files::{self, IdentityFiles, bad_file};
use super::fingerprint::Fingerprint;
use super::{TlsError, use_ring};

/// How a coordinator encrypts.
#[derive(Clone)]
pub struct ServerTls {
    config: Arc<ServerConfig>,
    fingerprint: Fingerprint,
}

impl ServerTls {
    /// With a certificate that somebody else made. Clients need certificates of their own that one of the `clients` authorities signed,
    /// if that is given.
    pub fn from_files(identity: &IdentityFiles, clients: Option<&Path>) -> Result<Self, TlsError> {
        Self::new(files::certificates(&identity.certificate)?, files::key(&identity.key)?, clients)
    }

    /// With a certificate that is made here for `names`, and kept in `folder` so that its fingerprint stays.
    pub fn automatic(folder: Option<&Path>, names: &[String], clients: Option<&Path>) -> Result<Self, TlsError> {
        let Some(folder) = folder else {
            let made = make(names)?;
            let key = PrivatePkcs8KeyDer::from(made.key.serialize_der());
            return Self::new(vec![made.certificate.der().clone()], key.into(), clients);
        };
        let identity = IdentityFiles { certificate: folder.join("certificate.pem"), key: folder.join("key.pem") };
        if !identity.certificate.exists() {
            let made = make(names)?;
            fs::create_dir_all(folder).map_err(|problem| unwritable(folder, &problem))?;
            write_new(&identity.key, &made.key.serialize_pem(), 0o600)?;
            write_new(&identity.certificate, &made.certificate.pem(), 0o644)?;
        }
        Self::from_files(&identity, clients)
    }

    fn new(
        chain: Vec<CertificateDer<'static>>,
        key: PrivateKeyDer<'static>,
        clients: Option<&Path>,
    ) -> Result<Self, TlsError> {
        use_ring();
        let fingerprint = chain.first().map(Fingerprint::of).ok_or(rustls::Error::NoCertificatesPresented)?;
        let builder = ServerConfig::builder();
        let builder = match clients {
            None => builder.with_no_client_auth(),
            Some(file) => {
                let mut authorities = RootCertStore::empty();
                for authority in files::certificates(file)? {
                    authorities.add(authority)?;
                }
                let verifier = WebPkiClientVerifier::builder(Arc::new(authorities)).build();
                builder.with_client_cert_verifier(verifier.map_err(|problem| TlsError::Clients(problem.to_string()))?)
            }
        };
        let mut config = builder.with_single_cert(chain, key)?;
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(Self { config: Arc::new(config), fingerprint })
    }

    /// By what clients know the certificate.
    pub fn fingerprint(&self) -> Fingerprint {
        self.fingerprint
    }

    /// The same for connections.
    pub fn config(&self) -> Arc<ServerConfig> {
        self.config.clone()
    }
}

struct Made {
    certificate: rcgen::Certificate,
    key: KeyPair,
}

fn make(names: &[String]) -> Result<Made, TlsError> {
    let key = KeyPair::generate()?;
    let mut parameters = CertificateParams::new(names.to_vec())?;
    parameters.distinguished_name = DistinguishedName::new();
    parameters.distinguished_name.push(DnType::CommonName, "photonfarm coordinator");
    Ok(Made { certificate: parameters.self_signed(&key)?, key })
}

/// Writes a file of such permissions, whole or not at all. What stood there before, also a link, is replaced.
fn write_new(file: &Path, text: &str, permissions: u32) -> Result<(), TlsError> {
    let partial = file.with_extension("partial");
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(not(unix))]
    let _ = permissions;
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, permissions);
    // Of an attempt that was broken off.
    let _ = fs::remove_file(&partial);
    let written = options.open(&partial).and_then(|mut file| file.write_all(text.as_bytes()));
    written.and_then(|()| fs::rename(&partial, file)).map_err(|problem| unwritable(file, &problem))
}

fn unwritable(place: &Path, problem: &std::io::Error) -> TlsError {
    bad_file(place, problem.to_string(), "give a folder that can be written with --data")
}
