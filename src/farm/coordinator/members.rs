//! Users: each change is stored, then holds.

use super::CoordinatorHandle;
use super::shared::Shared;
use super::tokens::NewToken;
use crate::farm::access::caller::{Caller, Denied};
use crate::farm::access::register::Register;
use crate::farm::access::scope::{Role, Scope};
use crate::farm::access::secret::Secret;
use crate::farm::access::token::Token;
use crate::farm::access::user::{BadUserName, User, UserName};
use crate::farm::error::FarmError;
use crate::farm::ids::{JobId, SequenceId, WorkerId};
use crate::farm::locks::lock;
use crate::farm::store::{Store, StoreError};

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
            Caller::User { token, name, .. } => {
                register.user(name).is_some() && register.valid(token, self.shared.clock.unix_milliseconds()).is_some()
            }
            Caller::Joining { token } => register.valid(token, self.shared.clock.unix_milliseconds()).is_some(),
        }
    }

    /// Lets pass whoever may change a job.
    pub fn check_owner(&self, caller: &Caller, id: JobId) -> Result<(), FarmError> {
        let owner = self.shared.job(id)?.owner();
        Ok(caller.require_owner(owner.as_ref(), || format!("job {id}"))?)
    }

    /// Lets pass whoever may change a sequence.
    pub fn check_sequence_owner(&self, caller: &Caller, id: SequenceId) -> Result<(), FarmError> {
        let owner = self.sequence(id)?.owner;
        Ok(caller.require_owner(owner.as_ref(), || format!("sequence {id}"))?)
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
    pub async fn add_user(&self, caller: &Caller, name: UserName, role: Role) -> Result<(User, NewToken), FarmError> {
        let added = self.shared.add_user(name, role).await?;
        self.shared.record_deed(caller, &format!("user {} was added as {}", added.0.name, role.name()));
        Ok(added)
    }

    /// Gives a user another role. Their tokens allow no more than that from now on.
    pub async fn change_role(&self, caller: &Caller, name: &UserName, role: Role) -> Result<User, FarmError> {
        let user = self.shared.change_role(name, role).await?;
        self.shared.record_deed(caller, &format!("user {name} was made {}", role.name()));
        Ok(user)
    }

    /// Deletes a user with all tokens. Their jobs stay.
    pub async fn delete_user(&self, caller: &Caller, name: &UserName) -> Result<(), FarmError> {
        self.shared.delete_user(name).await?;
        self.shared.record_deed(caller, &format!("user {name} was deleted"));
        Ok(())
    }
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
        *lock(&self.webhooks) = self.store.webhooks().await?;
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

    /// The user whom the provider of logins calls `name`; added where that is agreed.
    pub(super) async fn user_of_provider(&self, name: &str) -> Result<User, FarmError> {
        // Letters of other scripts are no letters of a name here: some of them become plain ones when they are made small.
        let called = name.to_ascii_lowercase();
        if called == UserName::operator().as_str() {
            return Err(Denied::UnknownAccount { name: called }.into());
        }
        let _turn = self.members.take().await?;
        let (known, is_open, count) = {
            let register = lock(&self.register);
            let known = called.parse().ok().and_then(|name| register.user(&name).cloned());
            (known, register.is_open(), register.users().count())
        };
        if let Some(user) = known {
            return Ok(user);
        }
        if is_open {
            let problem = "only users log in, and there are none".to_owned();
            return Err(FarmError::BadRequest { problem, remedy: "go on without".to_owned() });
        }
        let new_users = self.options.login.as_ref().and_then(|provider| provider.options().new_users);
        let unknown = |_| Denied::UnknownAccount { name: called.clone() };
        let name: UserName = called.parse().map_err(unknown)?;
        let role = new_users.filter(|_| count < self.options.limits.users).ok_or(BadUserName).map_err(unknown)?;
        let user = User { name, role, created: self.clock.unix_milliseconds() };
        self.store.put_user(&user).await?;
        lock(&self.register).put_user(user.clone());
        self.record_deed_of("the provider of logins", &format!("user {} was added as {}", user.name, role.name()));
        Ok(user)
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
pub(crate) async fn make_admin(store: &Store, name: UserName) -> Result<Secret, FarmError> {
    let now = super::clock::Clock::start().unix_milliseconds();
    let (_, new) = store_new_user(store, name, Role::Admin, now).await?;
    Ok(new.secret)
}
