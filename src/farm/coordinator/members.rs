//! Users and tokens: each change is stored, then holds.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::CoordinatorHandle;
use super::shared::Shared;
use crate::farm::access::caller::{Caller, Denied};
use crate::farm::access::register::Register;
use crate::farm::access::scope::{Role, Scope};
use crate::farm::access::secret::{Secret, SecretHash};
use crate::farm::access::token::{Token, TokenView};
use crate::farm::access::user::{User, UserName};
use crate::farm::error::FarmError;
use crate::farm::ids::{JobId, WorkerId};
use crate::farm::locks::lock;
use crate::farm::store::{Store, StoreError};

const DAY: i64 = 86_400_000;

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
    /// Whether anyone may do everything, because there are no users.
    pub fn is_open(&self) -> bool {
        lock(&self.shared.register).is_open()
    }

    /// Who sends a request with the token `bearer`.
    pub fn caller(&self, bearer: Option<&str>) -> Result<Caller, Denied> {
        lock(&self.shared.register).caller(bearer, self.shared.clock.unix_milliseconds())
    }

    /// Whether a caller who was known before is known still.
    pub fn knows(&self, caller: &Caller) -> bool {
        let register = lock(&self.shared.register);
        match caller {
            Caller::Anyone => register.is_open(),
            Caller::User { token, .. } | Caller::Joining { token } => {
                register.valid(token, self.shared.clock.unix_milliseconds()).is_some()
            }
        }
    }

    /// Lets pass whoever may change a job.
    pub fn check_owner(&self, caller: &Caller, id: JobId) -> Result<(), FarmError> {
        let owner = self.shared.job(id)?.owner();
        Ok(caller.require_owner(owner.as_ref(), || format!("job {id}"))?)
    }

    /// Lets pass whoever may delete a scene.
    pub fn check_scene_owner(&self, caller: &Caller, hash: &str) -> Result<(), FarmError> {
        let owner = self.scene(hash)?.owner;
        Ok(caller.require_owner(owner.as_ref(), || format!("scene {hash}"))?)
    }

    /// All users, by name.
    pub fn users(&self) -> Vec<User> {
        lock(&self.shared.register).users().cloned().collect()
    }

    /// Adds a user with a first token.
    pub async fn add_user(&self, name: UserName, role: Role) -> Result<(User, NewToken), FarmError> {
        self.shared.add_user(name, role).await
    }

    /// Gives a user another role. Their tokens allow no more than that from now on.
    pub async fn change_role(&self, name: &UserName, role: Role) -> Result<User, FarmError> {
        self.shared.change_role(name, role).await
    }

    /// Deletes a user with all tokens. Their jobs stay.
    pub async fn delete_user(&self, name: &UserName) -> Result<(), FarmError> {
        self.shared.delete_user(name).await
    }

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
        self.shared.issue_token(caller, wanted).await
    }

    /// Makes a token for a page on which the caller logs in. It ends with the caller's own.
    pub async fn log_in(&self, caller: &Caller, days: u16) -> Result<NewToken, FarmError> {
        self.shared.log_in(caller, days).await
    }

    /// Revokes a token that the caller may see, with those that came from it.
    pub async fn revoke_token(&self, caller: &Caller, id: &str) -> Result<(), FarmError> {
        self.shared.revoke_token(caller, id).await
    }
}

fn may_see(caller: &Caller, token: &Token) -> bool {
    caller.require(Scope::Admin).is_ok() || caller.name().is_some_and(|name| token.user.as_ref() == Some(name))
}

fn unknown_user(name: &UserName) -> FarmError {
    FarmError::UnknownMember(format!("user \"{name}\""))
}

impl Shared {
    /// Takes over the users and tokens that the store has.
    pub(super) async fn take_over_members(&self) -> Result<(), StoreError> {
        let (users, tokens) =
            (self.store.users().await?, self.store.valid_tokens(self.clock.unix_milliseconds()).await?);
        *lock(&self.register) = Register::new(users, tokens);
        if let Some(secret) = &self.options.worker_token {
            self.give_token(secret, None, Scope::Worker);
        }
        if let Some(secret) = &self.options.admin_token {
            let name = UserName::operator();
            let user = User { name: name.clone(), role: Role::Admin, created: self.clock.unix_milliseconds() };
            // The operator's further tokens outlive this process, and so does the operator.
            self.store.put_user(&user).await?;
            lock(&self.register).put_user(user);
            self.give_token(secret, Some(name), Scope::Admin);
        }
        Ok(())
    }

    fn give_token(&self, secret: &Secret, user: Option<UserName>, scope: Scope) {
        let created = self.clock.unix_milliseconds();
        let label = "given at start".to_owned();
        let token = Token { hash: secret.hash(), user, label, scope, created, expires: None, parent: None };
        lock(&self.register).give_token(token);
    }

    /// A token by which workers of this process join. It ends with the process.
    pub(in crate::farm) fn give_own_workers_token(&self) -> Result<Secret, FarmError> {
        let secret = Secret::new()?;
        self.give_token(&secret, None, Scope::Worker);
        Ok(secret)
    }

    /// The worker whose secret this is, if it may still work here.
    pub(in crate::farm) fn worker_with(&self, secret: &str) -> Option<WorkerId> {
        let shown = self.worker_secrets.check(secret)?;
        let register = lock(&self.register);
        let is_let_in = match shown.token {
            Some(token) => register.valid(&token, self.clock.unix_milliseconds()).is_some(),
            None => register.is_open(),
        };
        is_let_in.then_some(shown.worker)
    }

    async fn add_user(&self, name: UserName, role: Role) -> Result<(User, NewToken), FarmError> {
        let _turn = self.members.take().await?;
        {
            let register = lock(&self.register);
            if register.user(&name).is_some() {
                let problem = format!("there is a user \"{name}\" already");
                return Err(FarmError::Conflict {
                    problem,
                    remedy: "choose another name, or change the role".to_owned(),
                });
            }
            if register.is_open() && role != Role::Admin {
                let problem = "the first user has to be an admin: nobody could add further ones".to_owned();
                return Err(FarmError::Conflict { problem, remedy: "add an admin first".to_owned() });
            }
            if register.users().count() >= self.options.limits.users {
                let problem = format!("there are {} users already", self.options.limits.users);
                return Err(FarmError::Conflict { problem, remedy: "delete one first".to_owned() });
            }
        }
        let stored = store_new_user(&self.store, name.clone(), role, self.clock.unix_milliseconds()).await;
        let (user, new) = match stored {
            Ok(stored) => stored,
            Err(problem) => {
                // What was refused must not come back with the next start.
                self.store.delete_user(&name).await?;
                return Err(problem);
            }
        };
        let mut register = lock(&self.register);
        // With the first user nobody is let in without a token, so both come at once.
        register.put_token(new.token.clone());
        register.put_user(user.clone());
        Ok((user, new))
    }

    async fn change_role(&self, name: &UserName, role: Role) -> Result<User, FarmError> {
        let _turn = self.members.take().await?;
        let user = lock(&self.register).user(name).cloned().ok_or_else(|| unknown_user(name))?;
        if role != Role::Admin {
            self.check_not_last_admin(name)?;
        }
        let user = User { role, ..user };
        self.store.put_user(&user).await?;
        lock(&self.register).put_user(user.clone());
        Ok(user)
    }

    async fn delete_user(&self, name: &UserName) -> Result<(), FarmError> {
        let _turn = self.members.take().await?;
        lock(&self.register).user(name).ok_or_else(|| unknown_user(name))?;
        self.check_not_last_admin(name)?;
        self.store.delete_user(name).await?;
        lock(&self.register).remove_user(name);
        Ok(())
    }

    fn check_not_last_admin(&self, name: &UserName) -> Result<(), FarmError> {
        if !lock(&self.register).is_last_admin(name) {
            return Ok(());
        }
        let problem = format!("{name} is the only admin");
        Err(FarmError::Conflict { problem, remedy: "make somebody else an admin first".to_owned() })
    }

    async fn issue_token(&self, caller: &Caller, wanted: TokenRequest) -> Result<NewToken, FarmError> {
        let TokenRequest { user, label, scope, days } = wanted;
        self.check_label(&label, days)?;
        if scope == Some(Scope::Worker) {
            caller.require(Scope::Admin)?;
            if let Some(user) = user {
                let problem = format!("a token for workers is nobody's, and {user} is named");
                return Err(FarmError::BadRequest { problem, remedy: "leave the user out".to_owned() });
            }
            return self.store_token(None, label, Scope::Worker, days, None).await;
        }
        if user.is_some() && user.as_ref() != caller.name() {
            caller.require(Scope::Admin)?;
        }
        let Some(name) = user.or_else(|| caller.name().cloned()) else {
            let problem = "the token has no user".to_owned();
            return Err(FarmError::BadRequest { problem, remedy: "name one, or give the scope worker".to_owned() });
        };
        let role = lock(&self.register).user(&name).ok_or_else(|| unknown_user(&name))?.role;
        let scope = scope.unwrap_or_else(|| role.scope().at_most(caller.scope()));
        if !role.scope().includes(scope) {
            let problem = format!("{name} is {}, who may not have the scope {}", role.name(), scope.name());
            return Err(FarmError::BadRequest {
                problem,
                remedy: "give another scope, or another role first".to_owned(),
            });
        }
        caller.require(scope)?;
        self.store_token(Some(name), label, scope, days, None).await
    }

    fn check_label(&self, label: &str, days: Option<u16>) -> Result<(), FarmError> {
        let longest = self.options.limits.name_bytes;
        if label.len() > longest || label.chars().any(char::is_control) {
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
        self.store_token(Some(name.clone()), "page".to_owned(), *scope, Some(days), Some(*token)).await
    }

    async fn store_token(
        &self,
        user: Option<UserName>,
        label: String,
        scope: Scope,
        days: Option<u16>,
        parent: Option<SecretHash>,
    ) -> Result<NewToken, FarmError> {
        let _turn = self.members.take().await?;
        let created = self.clock.unix_milliseconds();
        let most = self.options.limits.tokens;
        if lock(&self.register).tokens().filter(|token| token.user == user && token.is_valid(created)).count() >= most {
            let whose = user.map_or_else(|| "workers have".to_owned(), |user| format!("{user} has"));
            let problem = format!("{whose} {most} tokens already");
            return Err(FarmError::Conflict { problem, remedy: "revoke one first".to_owned() });
        }
        let secret = Secret::new()?;
        let expires = days.map(|days| created + i64::from(days) * DAY);
        let token = Token { hash: secret.hash(), user, label, scope, created, expires, parent };
        self.store.insert_token(&token).await?;
        lock(&self.register).put_token(token.clone());
        Ok(NewToken { secret, token })
    }

    async fn revoke_token(&self, caller: &Caller, id: &str) -> Result<(), FarmError> {
        let _turn = self.members.take().await?;
        let found = {
            let register = lock(&self.register);
            register.tokens().find(|token| token.hash.id() == id && may_see(caller, token)).map(|token| token.hash)
        };
        let hash = found.ok_or_else(|| FarmError::UnknownMember(format!("token \"{id}\"")))?;
        self.store.delete_token(&hash).await?;
        lock(&self.register).remove_token(&hash);
        Ok(())
    }
}

/// Stores a user and a first token of everything that the role allows.
async fn store_new_user(store: &Store, name: UserName, role: Role, now: i64) -> Result<(User, NewToken), FarmError> {
    let user = User { name: name.clone(), role, created: now };
    let secret = Secret::new()?;
    let (hash, scope) = (secret.hash(), role.scope());
    let token =
        Token { hash, user: Some(name), label: "first".to_owned(), scope, created: now, expires: None, parent: None };
    store.put_user(&user).await?;
    store.insert_token(&token).await?;
    Ok((user, NewToken { secret, token }))
}

/// Makes an admin, or a further token of one, in a store that no coordinator uses.
pub async fn make_admin(store: &Store, name: UserName) -> Result<Secret, FarmError> {
    let now = super::clock::Clock::start().unix_milliseconds();
    let (_, new) = store_new_user(store, name, Role::Admin, now).await?;
    Ok(new.secret)
}
