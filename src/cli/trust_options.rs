//! Which coordinator a command trusts when it is reached by https.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::exit_code::CliError;
use crate::farm::dial::TlsSettings;
use crate::farm::tls::TlsError;
use crate::farm::tls::client::{self, Trust};
use crate::farm::tls::files::IdentityFiles;
use crate::farm::tls::fingerprint::Fingerprint;

/// Which coordinator a command trusts when it is reached by https.
#[derive(Clone, Debug, Args)]
pub(super) struct TrustOptions {
    /// Trust the coordinator with this certificate, as it printed it, and no other [default: those whose certificates this system trusts].
    #[arg(long, env = "PHOTONFARM_FINGERPRINT", value_name = "sha256:…", conflicts_with = "authorities")]
    fingerprint: Option<Fingerprint>,
    /// Trust coordinators whose certificates were signed by an authority in this file, PEM.
    #[arg(long, env = "PHOTONFARM_AUTHORITIES", value_name = "FILE")]
    authorities: Option<PathBuf>,
    /// Certificate to show to a coordinator that asks for one, PEM.
    #[arg(long, env = "PHOTONFARM_CLIENT_CERTIFICATE", value_name = "FILE", requires = "client_key")]
    client_certificate: Option<PathBuf>,
    /// Private key of that certificate, PEM.
    #[arg(long, env = "PHOTONFARM_CLIENT_KEY", value_name = "FILE", requires = "client_certificate")]
    client_key: Option<PathBuf>,
}

impl TrustOptions {
    /// How to encrypt when `address` asks for it.
    pub(super) fn settings(&self, address: &str) -> Result<Option<Arc<TlsSettings>>, CliError> {
        if !address.split(',').any(|address| address.trim().starts_with("https://")) {
            return if self.is_given() { Err(unencrypted(address)) } else { Ok(None) };
        }
        let trust = match (&self.fingerprint, &self.authorities) {
            (Some(fingerprint), _) => Trust::Pinned(*fingerprint),
            (None, Some(file)) => Trust::Authorities(file.clone()),
            (None, None) => Trust::System,
        };
        let identity = self.client_certificate.clone().zip(self.client_key.clone());
        let identity = identity.map(|(certificate, key)| IdentityFiles { certificate, key });
        Ok(Some(Arc::new(client::configure(&trust, identity.as_ref())?)))
    }

    fn is_given(&self) -> bool {
        self.fingerprint.is_some() || self.authorities.is_some() || self.client_certificate.is_some()
    }
}

fn unencrypted(address: &str) -> CliError {
    CliError::Usage(format!("{address} is not encrypted, but it is said whom to trust; write https://"))
}

impl From<TlsError> for CliError {
    fn from(error: TlsError) -> Self {
        match error {
            TlsError::File { .. } => Self::File(error.to_string()),
            _ => Self::BadInput(error.to_string()),
        }
    }
}
