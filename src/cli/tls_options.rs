//! How a coordinator encrypts.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::exit_code::CliError;
use crate::farm::tls::files::IdentityFiles;
use crate::farm::tls::server::ServerTls;

/// Where a certificate comes from that nobody gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Tls {
    /// It is made here, and kept in the folder of --data.
    Auto,
}

/// How a coordinator encrypts.
#[derive(Clone, Debug, Args)]
pub(super) struct TlsOptions {
    /// Encrypt connections with a certificate that is made here; clients trust it by the fingerprint that is printed.
    #[arg(long, value_enum, conflicts_with = "tls_certificate")]
    tls: Option<Tls>,
    /// Encrypt connections with this certificate and its chain, PEM.
    #[arg(long, env = "PHOTONFARM_TLS_CERTIFICATE", value_name = "FILE", requires = "tls_key")]
    tls_certificate: Option<PathBuf>,
    /// Private key of that certificate, PEM.
    #[arg(long, env = "PHOTONFARM_TLS_KEY", value_name = "FILE", requires = "tls_certificate")]
    tls_key: Option<PathBuf>,
    /// Refuse connections without a certificate that was signed by an authority in this file, PEM; also those of browsers.
    #[arg(long, value_name = "FILE")]
    client_authorities: Option<PathBuf>,
}

impl TlsOptions {
    /// The coordinator's certificate, if connections are to be encrypted; `folder` keeps one that is made here.
    pub(super) fn server(&self, folder: Option<&Path>, names: &[String]) -> Result<Option<ServerTls>, CliError> {
        let clients = self.client_authorities.as_deref();
        let given = self.tls_certificate.clone().zip(self.tls_key.clone());
        match (given, self.tls) {
            (Some((certificate, key)), _) => {
                Ok(Some(ServerTls::from_files(&IdentityFiles { certificate, key }, clients)?))
            }
            (None, Some(Tls::Auto)) => {
                let folder = folder.map(|folder| folder.join("tls"));
                Ok(Some(ServerTls::automatic(folder.as_deref(), names, clients)?))
            }
            (None, None) if clients.is_some() => {
                let text = "--client-authorities needs encrypted connections; add --tls auto, or give a certificate";
                Err(CliError::Usage(text.to_owned()))
            }
            (None, None) => Ok(None),
        }
    }
}
