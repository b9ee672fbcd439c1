//! The provider at whose page people log in.

use std::path::PathBuf;

use clap::Args;

use super::exit_code::CliError;
use super::named::named;
use crate::farm::access::scope::Role;
use crate::farm::login::options::{ClientPassword, NameClaim, ProviderOptions};
use crate::farm::login::provider::Provider;

/// Logins to the page by an OpenID Connect provider.
#[derive(Clone, Debug, Args)]
pub(super) struct LoginOptions {
    /// Address of an OpenID Connect provider at whose page people may log in.
    #[arg(long, env = "PHOTONFARM_OIDC_ISSUER", value_name = "URL", requires_all = ["oidc_client", "public_address"])]
    oidc_issuer: Option<String>,
    /// What this coordinator is called at the provider.
    #[arg(long, env = "PHOTONFARM_OIDC_CLIENT", value_name = "NAME")]
    oidc_client: Option<String>,
    /// File with this coordinator's password at the provider, if it has one.
    #[arg(long, env = "PHOTONFARM_OIDC_CLIENT_SECRET_FILE", value_name = "FILE")]
    oidc_client_secret_file: Option<PathBuf>,
    /// Address under which browsers reach this coordinator, as https://farm.example; the provider sends them back to /v1/session/provider/return there.
    #[arg(long, env = "PHOTONFARM_PUBLIC_ADDRESS", value_name = "URL")]
    public_address: Option<String>,
    /// What the provider says of people that is their name here.
    #[arg(long, default_value = NameClaim::default().name(), value_parser = named(NameClaim::ALL, NameClaim::name), value_name = "CLAIM")]
    oidc_name: NameClaim,
    /// Role of people that come from the provider for the first time [default: only users that an admin added are let in].
    #[arg(long, value_parser = named(Role::ALL, Role::name), value_name = "ROLE")]
    oidc_role: Option<Role>,
}

impl LoginOptions {
    /// The provider, if one was named.
    pub(super) fn provider(&self) -> Result<Option<Provider>, CliError> {
        let Some(((issuer, client), public_address)) =
            self.oidc_issuer.clone().zip(self.oidc_client.clone()).zip(self.public_address.clone())
        else {
            return Ok(None);
        };
        let password = self.oidc_client_secret_file.as_ref().map(|file| {
            let text = std::fs::read_to_string(file)
                .map_err(|problem| CliError::File(format!("{}: {problem}; give a readable file", file.display())))?;
            Ok::<_, CliError>(ClientPassword(text.trim().to_owned()))
        });
        let options = ProviderOptions {
            issuer,
            client,
            password: password.transpose()?,
            public_address,
            name: self.oidc_name,
            new_users: self.oidc_role,
        };
        Provider::new(options).map(Some).map_err(|problem| CliError::Usage(problem.to_string()))
    }
}
