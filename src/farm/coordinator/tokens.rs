//! Tokens: each is stored, then taken.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::CoordinatorHandle;
use super::shared::Shared;
use crate::farm::access::caller::{Caller, Denied};
use crate::farm::access::scope::Scope;
use crate::farm::access::secret::{Secret, SecretHash};
use crate::farm::access::token::{Token, TokenView};
use crate::farm::access::user::{User, UserName};
use crate::farm::error::FarmError;
use crate::farm::locks::lock;
use crate::farm::login::provider::Provider;
use crate::farm::text::is_hidden;

const DAY: i64 = 86_400_000;
/// What tokens are for that pages got by a login at the provider.
const PROVIDER_LABEL: &str = "page, by the provider";
/// Pages on which a user is logged in by the provider at the same time; the oldest login ends with one more.
const LOGINS: usize = 10;

/// A token to be made.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TokenRequest {
    /// Whose it shall be; the caller's own when it is left out. Tokens for workers are nobody's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub user: Option<UserName>,
    /// What it is for, in words; at most 200 bytes.
    #[serde(default)]
    pub label: String,
    /// What it shall allow; what the user's role allows when it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scope: Option<Scope>,
    /// Days after which it is not taken any more, 1 to 3650; never when it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 3650)]
    pub days: Option<u16>,
}

/// Days of a token at most.
const MOST_DAYS: u16 = 3650;

/// A new token. Its secret is shown this once.
#[derive(Clone, Debug)]
pub struct NewToken {
    /// What to send.
    pub secret: Secret,
    /// What is known of it.
    pub token: Token,
}

impl CoordinatorHandle {
    /// The tokens that a caller may see, oldest first: their own, or all.
    pub fn tokens(&self, caller: &Caller) -> Vec<TokenView> {
        let now = self.shared.clock.unix_milliseconds();
        let register = lock(&self.shared.register);
        let mut tokens: Vec<&Token> =
            register.tokens().filter(|token| token.is_valid(now) && may_see(caller, token)).collect();
        tokens.sort_by_key(|token| (token.created, token.hash.digits()));
        tokens.into_iter().map(Token::view).collect()
    }

    /// Makes a token that a caller asks for. It allows no more than the caller's own.
    pub async fn issue_token(&self, caller: &Caller, wanted: TokenRequest) -> Result<NewToken, FarmError> {
        let new = self.shared.issue_token(caller, wanted).await?;
        self.shared.record_deed(caller, &format!("{} was made", shown(&new.token)));
        Ok(new)
    }

    /// Makes a token for a page on which the caller logs in. It ends with the caller's own.
    pub async fn log_in(&self, caller: &Caller, days: u16) -> Result<NewToken, FarmError> {
        let new = self.shared.log_in(caller, days).await?;
        self.shared.record_deed(caller, &format!("{} was made for a page", shown(&new.token)));
        Ok(new)
    }

    /// At whose page people may log in.
    pub fn login_provider(&self) -> Option<&Provider> {
        self.shared.options.login.as_deref()
    }

    /// Makes a token for a page on which somebody logged in at the provider, who calls them `name`.
    pub async fn log_in_as(&self, name: &str, days: u16) -> Result<NewToken, FarmError> {
        let user = self.shared.user_of_provider(name).await?;
        let new = self.shared.token_for_page(user, days).await?;
        self.shared.record_deed_of("the provider of logins", &format!("{} was made for a page", shown(&new.token)));
        Ok(new)
    }

    /// Ends the session of a caller who logged in to a page.
    pub async fn log_out(&self, caller: &Caller) -> Result<(), FarmError> {
        self.shared.log_out(caller).await
    }

    /// Revokes a token that the caller may see, with those that came from it.
    pub async fn revoke_token(&self, caller: &Caller, id: &str) -> Result<(), FarmError> {
        let token = self.shared.revoke_token(caller, id).await?;
        self.shared.record_deed(caller, &format!("{} was revoked", shown(&token)));
        Ok(())
    }
}

/// A token in words.
fn shown(token: &Token) -> String {
    let whose = token.user.as_ref().map_or_else(|| "nobody".to_owned(), ToString::to_string);
    format!("token {} ({}) of {whose}", token.hash.id(), token.scope.name())
}

fn may_see(caller: &Caller, token: &Token) -> bool {
    caller.require(Scope::Admin).is_ok() || caller.name().is_some_and(|name| token.user.as_ref() == Some(name))
}

impl Shared {
    async fn issue_token(&self, caller: &Caller, wanted: TokenRequest) -> Result<NewToken, FarmError> {
        let TokenRequest { user, label, scope, days } = wanted;
        self.check_label(&label, days)?;
        let now = self.clock.unix_milliseconds();
        let expires = days.map(|days| now + i64::from(days) * DAY);
        if scope == Some(Scope::Worker) {
            caller.require(Scope::Admin)?;
            if let Some(user) = user {
                let problem = format!("a token for workers is nobody's, and {user} is named");
                return Err(FarmError::BadRequest { problem, remedy: "leave the user out".to_owned() });
            }
            return self.store_token(Wanted { user: None, label, scope: Scope::Worker, expires }, None).await;
        }
        if user.is_some() && user.as_ref() != caller.name() {
            caller.require(Scope::Admin)?;
        }
        let Some(name) = user.or_else(|| caller.name().cloned()) else {
            let problem = "the token has no user".to_owned();
            return Err(FarmError::BadRequest { problem, remedy: "name one, or give the scope worker".to_owned() });
        };
        let role =
            lock(&self.register).user(&name).ok_or_else(|| FarmError::UnknownMember(format!("user \"{name}\"")))?.role;
        let scope = scope.unwrap_or_else(|| role.scope().at_most(caller.scope()));
        if !role.scope().includes(scope) {
            let problem = format!("{name} is {}, who may not have the scope {}", role.name(), scope.name());
            return Err(FarmError::BadRequest {
                problem,
                remedy: "give another scope, or another role first".to_owned(),
            });
        }
        caller.require(scope)?;
        // Nobody makes a short-lived token last by making another of it.
        let own = match caller {
            Caller::User { token, .. } if caller.name() == Some(&name) => {
                lock(&self.register).valid(token, now).cloned()
            }
            _ => None,
        };
        let expires = earlier(expires, own.and_then(|token| token.expires));
        self.store_token(Wanted { user: Some(name), label, scope, expires }, None).await
    }

    fn check_label(&self, label: &str, days: Option<u16>) -> Result<(), FarmError> {
        let longest = self.options.limits.name_bytes;
        if label.len() > longest || label.chars().any(is_hidden) {
            let problem = "the label is too long or holds control characters".to_owned();
            return Err(FarmError::BadRequest { problem, remedy: format!("give at most {longest} plain bytes") });
        }
        if days.is_some_and(|days| !(1..=MOST_DAYS).contains(&days)) {
            let problem = format!("days is {}", days.unwrap_or_default());
            return Err(FarmError::BadRequest { problem, remedy: format!("give 1 to {MOST_DAYS}") });
        }
        Ok(())
    }

    async fn log_in(&self, caller: &Caller, days: u16) -> Result<NewToken, FarmError> {
        let Caller::User { name, scope, token } = caller else {
            let problem = "only users log in".to_owned();
            return Err(FarmError::BadRequest { problem, remedy: "go on without".to_owned() });
        };
        let now = self.clock.unix_milliseconds();
        let known = lock(&self.register).origin(token, now).ok_or(Denied::UnknownToken)?;
        let expires = earlier(Some(now + i64::from(days) * DAY), known.token.expires);
        let wanted = Wanted { user: Some(name.clone()), label: "page".to_owned(), scope: *scope, expires };
        if known.is_stored {
            return self.store_token(wanted, Some(known.token.hash)).await;
        }
        // A token that was given at start ends with the process, and so does what comes from it.
        let secret = Secret::new()?;
        let token = wanted.token(&secret, now, Some(known.token.hash));
        lock(&self.register).give_token(token.clone());
        Ok(NewToken { secret, token })
    }

    async fn token_for_page(&self, user: User, days: u16) -> Result<NewToken, FarmError> {
        self.end_oldest_logins(&user).await?;
        let expires = Some(self.clock.unix_milliseconds() + i64::from(days) * DAY);
        let (scope, label) = (user.role.scope(), PROVIDER_LABEL.to_owned());
        self.store_token(Wanted { user: Some(user.name), label, scope, expires }, None).await
    }

    /// Makes room for one more login of a user at the provider: nobody is kept out by having come too often.
    async fn end_oldest_logins(&self, user: &User) -> Result<(), FarmError> {
        let _turn = self.members.take().await?;
        let mut logins: Vec<(i64, SecretHash)> = lock(&self.register)
            .tokens()
            .filter(|token| token.user.as_ref() == Some(&user.name) && token.label == PROVIDER_LABEL)
            .map(|token| (token.created, token.hash))
            .collect();
        logins.sort_by_key(|(created, _)| *created);
        let superfluous = (logins.len() + 1).saturating_sub(LOGINS);
        for (_, hash) in logins.into_iter().take(superfluous) {
            self.store.delete_token(&hash).await?;
            lock(&self.register).remove_token(&hash);
        }
        Ok(())
    }

    async fn log_out(&self, caller: &Caller) -> Result<(), FarmError> {
        let Caller::User { token, .. } = caller else { return Ok(()) };
        let _turn = self.members.take().await?;
        let known = lock(&self.register).valid(token, self.clock.unix_milliseconds()).cloned();
        // Only what came from logging in ends with logging out.
        if known.is_some_and(|known| known.parent.is_some() || known.label == PROVIDER_LABEL) {
            // One that is not stored is not found there, which is no error.
            self.store.delete_token(token).await?;
            lock(&self.register).remove_token(token);
        }
        Ok(())
    }

    async fn store_token(&self, wanted: Wanted, parent: Option<SecretHash>) -> Result<NewToken, FarmError> {
        let _turn = self.members.take().await?;
        let created = self.clock.unix_milliseconds();
        let most = self.options.limits.tokens;
        let user = &wanted.user;
        if lock(&self.register).tokens().filter(|token| token.user == *user && token.is_valid(created)).count() >= most
        {
            let whose = user.as_ref().map_or_else(|| "workers have".to_owned(), |user| format!("{user} has"));
            let problem = format!("{whose} {most} tokens already");
            return Err(FarmError::Conflict { problem, remedy: "revoke one first".to_owned() });
        }
        let secret = Secret::new()?;
        let token = wanted.token(&secret, created, parent);
        self.store.insert_token(&token).await?;
        lock(&self.register).put_token(token.clone());
        Ok(NewToken { secret, token })
    }

    async fn revoke_token(&self, caller: &Caller, id: &str) -> Result<Token, FarmError> {
        let _turn = self.members.take().await?;
        let found = {
            let register = lock(&self.register);
            register.tokens().find(|token| token.hash.id() == id && may_see(caller, token)).cloned()
        };
        let token = found.ok_or_else(|| FarmError::UnknownMember(format!("token \"{id}\"")))?;
        self.store.delete_token(&token.hash).await?;
        lock(&self.register).remove_token(&token.hash);
        Ok(token)
    }
}

/// A token that is about to be made.
struct Wanted {
    user: Option<UserName>,
    label: String,
    scope: Scope,
    /// Milliseconds since 1970.
    expires: Option<i64>,
}

impl Wanted {
    fn token(self, secret: &Secret, created: i64, parent: Option<SecretHash>) -> Token {
        let Self { user, label, scope, expires } = self;
        Token { hash: secret.hash(), user, label, scope, created, expires, parent }
    }
}

/// The earlier of two ends, of which there may be none.
fn earlier(one: Option<i64>, other: Option<i64>) -> Option<i64> {
    one.into_iter().chain(other).min()
}
