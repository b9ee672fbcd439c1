//! The two steps of logging in: send a browser to the provider, and read what it brings back.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use openidconnect::core::{
    CoreAuthenticationFlow, CoreClient, CoreIdTokenClaims, CoreProviderMetadata, CoreUserInfoClaims,
};
use openidconnect::{
    AuthorizationCode, ClientId, ClientSecret, CsrfToken, EndUserEmail, EndUserUsername, EndpointMaybeSet,
    EndpointNotSet, EndpointSet, IssuerUrl, Nonce, OAuth2TokenResponse, PkceCodeChallenge, RedirectUrl, Scope,
    SubjectIdentifier, TokenResponse,
};

use tokio::sync::Semaphore;

use super::options::{NameClaim, ProviderOptions};
use super::pending::PendingLogins;
use super::requests::{Requests, in_full};
use crate::farm::locks::lock;

/// For how long what the provider says of itself is believed without asking again, when a login begins.
const KEPT: Duration = Duration::from_secs(60);
/// Logins that ask the provider at the same time.
const MOST_ASKING: usize = 16;

/// Where a browser comes back to, below the public address.
pub(crate) const RETURN_PATH: &str = "/v1/session/provider/return";

/// Why somebody is not logged in.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LoginError {
    /// An address that is none.
    #[error("{address} is not an address: {problem}")]
    BadAddress {
        /// What was given.
        address: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The provider does not answer as it should.
    #[error("the provider cannot be asked: {0}")]
    Provider(String),
    /// Too many log in at the same time.
    #[error("too many log in at the same time")]
    Busy,
    /// The browser was not sent there from here, or long ago, or it came back before.
    #[error("this login was not begun here, or it took too long")]
    NotBegun,
    /// The provider did not let somebody in, or says something that cannot be trusted.
    #[error("the provider's answer is not taken: {0}")]
    Refused(String),
    /// The provider does not say what somebody is called.
    #[error("the provider says no {claim} of this account", claim = .0.name())]
    NoName(NameClaim),
}

/// Where to send a browser.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Departure {
    /// The provider's page.
    pub address: String,
    /// What the browser brings back, and has to know by itself, too.
    pub state: String,
}

/// A client that knows where to send browsers, and may know where to redeem codes.
type Client =
    CoreClient<EndpointSet, EndpointNotSet, EndpointNotSet, EndpointNotSet, EndpointMaybeSet, EndpointMaybeSet>;

/// A provider of logins.
pub struct Provider {
    options: ProviderOptions,
    issuer: IssuerUrl,
    return_address: RedirectUrl,
    requests: Requests,
    pending: Mutex<PendingLogins>,
    /// What the provider said of itself last, and when.
    known: Mutex<Option<(Instant, CoreProviderMetadata)>>,
    /// Logins that ask the provider at the same time.
    asking: Semaphore,
}

impl Provider {
    /// A provider that nobody has asked yet.
    ///
    /// # Errors
    /// Where issuer or public address are no addresses.
    pub fn new(options: ProviderOptions) -> Result<Self, LoginError> {
        let bad = |address: &str, problem: String| LoginError::BadAddress { address: address.to_owned(), problem };
        let issuer =
            IssuerUrl::new(options.issuer.clone()).map_err(|problem| bad(&options.issuer, problem.to_string()))?;
        let return_address = format!("{}{RETURN_PATH}", options.public_address.trim_end_matches('/'));
        let return_address =
            RedirectUrl::new(return_address).map_err(|problem| bad(&options.public_address, problem.to_string()))?;
        Ok(Self {
            options,
            issuer,
            return_address,
            requests: Requests::new(),
            pending: Mutex::default(),
            known: Mutex::default(),
            asking: Semaphore::new(MOST_ASKING),
        })
    }

    /// What was agreed with it.
    pub fn options(&self) -> &ProviderOptions {
        &self.options
    }

    /// Begins a login.
    pub async fn begin(&self) -> Result<Departure, LoginError> {
        let _place = self.asking.try_acquire().map_err(|_| LoginError::Busy)?;
        let known = lock(&self.known).clone().filter(|(asked, _)| asked.elapsed() < KEPT).map(|(_, known)| known);
        let client = match known {
            Some(known) => self.client_of(known),
            None => self.client().await?,
        };
        let (challenge, verifier) = PkceCodeChallenge::new_random_sha256();
        let request =
            client.authorize_url(CoreAuthenticationFlow::AuthorizationCode, CsrfToken::new_random, Nonce::new_random);
        let scopes: &[&str] = match self.options.name {
            NameClaim::PreferredUsername => &["profile"],
            NameClaim::Email => &["email"],
            NameClaim::Subject => &[],
        };
        let request = request.add_scopes(scopes.iter().map(|scope| Scope::new((*scope).to_owned())));
        let (address, state, nonce) = request.set_pkce_challenge(challenge).url();
        let state = state.into_secret();
        lock(&self.pending).add(state.clone(), nonce, verifier);
        Ok(Departure { address: address.into(), state })
    }

    /// Ends a login: who it is, as the provider calls them.
    pub async fn finish(&self, state: &str, code: String) -> Result<String, LoginError> {
        let _place = self.asking.try_acquire().map_err(|_| LoginError::Busy)?;
        let pending = lock(&self.pending).take(state).ok_or(LoginError::NotBegun)?;
        let client = self.client().await?;
        let exchange = client.exchange_code(AuthorizationCode::new(code));
        let exchange = exchange.map_err(|problem| LoginError::Provider(in_full(&problem)))?;
        let answer = exchange.set_pkce_verifier(pending.verifier).request_async(&self.requests).await;
        let answer = answer.map_err(|problem| LoginError::Refused(in_full(&problem)))?;
        let token = answer.id_token().ok_or_else(|| LoginError::Refused("it holds no ID token".to_owned()))?;
        let claims = token.claims(&client.id_token_verifier(), &pending.nonce);
        let claims = claims.map_err(|problem| LoginError::Refused(in_full(&problem)))?;
        let wanted = self.options.name;
        if let Some(name) = Said::in_token(claims).name(wanted) {
            return Ok(name);
        }
        // Where a code was redeemed, providers need not say more in the token than who it is (OpenID Connect Core 1.0, section 5.4).
        let request = client.user_info(answer.access_token().clone(), Some(claims.subject().clone()));
        let request = request.map_err(|_| LoginError::NoName(wanted))?;
        let claims: CoreUserInfoClaims =
            request.request_async(&self.requests).await.map_err(|problem| LoginError::Refused(in_full(&problem)))?;
        Said::as_information(&claims).name(wanted).ok_or(LoginError::NoName(wanted))
    }

    /// Asks the provider where it is and which keys it signs with: both may change.
    async fn client(&self) -> Result<Client, LoginError> {
        let description = CoreProviderMetadata::discover_async(self.issuer.clone(), &self.requests).await;
        let description = description.map_err(|problem| LoginError::Provider(in_full(&problem)))?;
        *lock(&self.known) = Some((Instant::now(), description.clone()));
        Ok(self.client_of(description))
    }

    fn client_of(&self, description: CoreProviderMetadata) -> Client {
        let ProviderOptions { client, password, .. } = &self.options;
        let password = password.as_ref().map(|password| ClientSecret::new(password.0.clone()));
        CoreClient::from_provider_metadata(description, ClientId::new(client.clone()), password)
            .set_redirect_uri(self.return_address.clone())
    }
}

/// What the provider says of somebody.
struct Said<'a> {
    username: Option<&'a EndUserUsername>,
    email: Option<&'a EndUserEmail>,
    is_email_verified: bool,
    subject: &'a SubjectIdentifier,
}

impl<'a> Said<'a> {
    fn in_token(claims: &'a CoreIdTokenClaims) -> Self {
        Self {
            username: claims.preferred_username(),
            email: claims.email(),
            is_email_verified: claims.email_verified() == Some(true),
            subject: claims.subject(),
        }
    }

    fn as_information(claims: &'a CoreUserInfoClaims) -> Self {
        Self {
            username: claims.preferred_username(),
            email: claims.email(),
            is_email_verified: claims.email_verified() == Some(true),
            subject: claims.subject(),
        }
    }

    fn name(&self, wanted: NameClaim) -> Option<String> {
        match wanted {
            NameClaim::PreferredUsername => self.username.map(|name| name.to_string()),
            // Whoever may write any address there could be anybody.
            NameClaim::Email => self.email.filter(|_| self.is_email_verified).map(|email| email.to_string()),
            NameClaim::Subject => Some(self.subject.to_string()),
        }
    }
}
