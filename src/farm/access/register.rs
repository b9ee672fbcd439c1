//! All users and tokens, in memory: every request asks.

use std::collections::{BTreeMap, HashMap};

use super::caller::{Caller, Denied};
use super::scope::{Role, Scope};
use super::secret::SecretHash;
use super::token::Token;
use super::user::{User, UserName};

/// All users and tokens.
#[derive(Clone, Debug, Default)]
pub struct Register {
    users: BTreeMap<UserName, User>,
    tokens: HashMap<SecretHash, Token>,
    /// Tokens that the coordinator was started with. They are not stored, nobody can revoke them, and they end with the process.
    given: HashMap<SecretHash, Token>,
}

/// The token with which somebody logged in first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// The token.
    pub token: Token,
    /// Whether it outlives the process.
    pub is_stored: bool,
}

impl Register {
    /// Those that are stored.
    pub fn new(users: Vec<User>, tokens: Vec<Token>) -> Self {
        Self {
            users: users.into_iter().map(|user| (user.name.clone(), user)).collect(),
            tokens: tokens.into_iter().map(|token| (token.hash, token)).collect(),
            given: HashMap::new(),
        }
    }

    /// Whether anyone may do everything, because there are no users.
    pub fn is_open(&self) -> bool {
        self.users.is_empty()
    }

    /// Who sends a request with the token `bearer` at `now`, milliseconds since 1970.
    pub fn caller(&self, bearer: Option<&str>, now: i64) -> Result<Caller, Denied> {
        let hash = match bearer {
            Some(text) => SecretHash::of(text),
            None if self.is_open() => return Ok(Caller::Anyone),
            None => return Err(Denied::NoToken),
        };
        match self.valid(&hash, now) {
            Some(token) => self.caller_with(token).ok_or(Denied::UnknownToken),
            None if self.is_open() => Ok(Caller::Anyone),
            None => Err(Denied::UnknownToken),
        }
    }

    fn caller_with(&self, token: &Token) -> Option<Caller> {
        let hash = token.hash;
        let Some(name) = &token.user else {
            return (token.scope == Scope::Worker).then_some(Caller::Joining { token: hash });
        };
        let role = self.users.get(name)?.role;
        Some(Caller::User { name: name.clone(), scope: token.scope.at_most(role.scope()), token: hash })
    }

    /// A token that is taken at `now`.
    pub fn valid(&self, hash: &SecretHash, now: i64) -> Option<&Token> {
        self.tokens.get(hash).or_else(|| self.given.get(hash)).filter(|token| token.is_valid(now))
    }

    /// The token that `hash` came from by logging in, or that itself, if both are taken at `now`.
    pub fn origin(&self, hash: &SecretHash, now: i64) -> Option<Origin> {
        let token = self.valid(hash, now)?;
        let first = token.parent.unwrap_or(*hash);
        Some(Origin { token: self.valid(&first, now)?.clone(), is_stored: self.tokens.contains_key(&first) })
    }

    /// A user.
    pub fn user(&self, name: &UserName) -> Option<&User> {
        self.users.get(name)
    }

    /// All users, by name.
    pub fn users(&self) -> impl Iterator<Item = &User> {
        self.users.values()
    }

    /// All tokens that are stored.
    pub fn tokens(&self) -> impl Iterator<Item = &Token> {
        self.tokens.values()
    }

    /// Adds a user, or gives them another role.
    pub fn put_user(&mut self, user: User) {
        self.users.insert(user.name.clone(), user);
    }

    /// Takes a user away with their tokens.
    pub fn remove_user(&mut self, name: &UserName) {
        self.users.remove(name);
        self.tokens.retain(|_, token| token.user.as_ref() != Some(name));
    }

    /// Adds a token.
    pub fn put_token(&mut self, token: Token) {
        self.tokens.insert(token.hash, token);
    }

    /// Adds a token that is not stored.
    pub fn give_token(&mut self, token: Token) {
        self.given.insert(token.hash, token);
    }

    /// Takes a token away, with those that somebody got by logging in with it.
    pub fn remove_token(&mut self, hash: &SecretHash) {
        self.tokens.retain(|known, token| known != hash && token.parent.as_ref() != Some(hash));
        self.given.retain(|_, token| token.parent.is_none() || token.hash != *hash);
    }

    /// Whether `name` is the only admin.
    pub fn is_last_admin(&self, name: &UserName) -> bool {
        let mut admins = self.users.values().filter(|user| user.role == Role::Admin).map(|user| &user.name);
        admins.next() == Some(name) && admins.next().is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: i64 = 1000;

    fn name(text: &str) -> UserName {
        text.parse().expect("a name")
    }

    fn token(text: &str, user: Option<&str>, scope: Scope) -> Token {
        let (hash, user) = (SecretHash::of(text), user.map(name));
        Token { hash, user, label: String::new(), scope, created: 0, expires: None, parent: None }
    }

    fn register() -> Register {
        let user = |text: &str, role| User { name: name(text), role, created: 0 };
        let users = vec![user("anna", Role::Admin), user("ben", Role::Artist), user("vera", Role::Viewer)];
        let short = Token { expires: Some(NOW), ..token("short", Some("ben"), Scope::Submit) };
        let session = Token { parent: Some(SecretHash::of("ben")), ..token("page", Some("ben"), Scope::Submit) };
        let tokens = vec![
            token("anna", Some("anna"), Scope::Admin),
            token("ben", Some("ben"), Scope::Submit),
            // More than the role allows, as after the user lost a role.
            token("vera", Some("vera"), Scope::Admin),
            token("join", None, Scope::Worker),
            short,
            session,
        ];
        Register::new(users, tokens)
    }

    fn scope(register: &Register, text: &str) -> Result<Scope, Denied> {
        register.caller(Some(text), NOW).map(|caller| caller.scope())
    }

    #[test]
    fn tokens_allow_what_they_and_the_role_allow() {
        let register = register();
        assert_eq!(scope(&register, "anna"), Ok(Scope::Admin));
        assert_eq!(scope(&register, "ben"), Ok(Scope::Submit));
        assert_eq!(scope(&register, "vera"), Ok(Scope::Read));
        assert_eq!(scope(&register, "join"), Ok(Scope::Worker));
        assert_eq!(scope(&register, "short"), Err(Denied::UnknownToken));
        assert_eq!(scope(&register, "nobody"), Err(Denied::UnknownToken));
        assert_eq!(register.caller(None, NOW), Err(Denied::NoToken));
    }

    #[test]
    fn nobody_is_asked_while_there_are_no_users() {
        let mut register = Register::default();
        assert_eq!(register.caller(None, NOW), Ok(Caller::Anyone));
        assert_eq!(register.caller(Some("anything"), NOW), Ok(Caller::Anyone));
        register.put_user(User { name: name("anna"), role: Role::Admin, created: 0 });
        assert_eq!(register.caller(None, NOW), Err(Denied::NoToken));
    }

    #[test]
    fn tokens_end_with_their_user_and_with_the_token_they_came_from() {
        let mut register = register();
        register.remove_token(&SecretHash::of("ben"));
        assert_eq!(scope(&register, "page"), Err(Denied::UnknownToken));
        register.remove_user(&name("anna"));
        assert_eq!(scope(&register, "anna"), Err(Denied::UnknownToken));
        assert_eq!(scope(&register, "join"), Ok(Scope::Worker));
    }

    #[test]
    fn owners_and_admins_may_change_what_is_owned() {
        let register = register();
        let may = |text: &str, owner: Option<&str>| {
            let caller = register.caller(Some(text), NOW).expect("a caller");
            caller.require_owner(owner.map(name).as_ref(), || "job 1".to_owned()).is_ok()
        };
        assert!(may("ben", Some("ben")) && may("anna", Some("ben")) && may("anna", None));
        assert!(!may("ben", Some("anna")) && !may("ben", None) && !may("vera", Some("vera")) && !may("join", None));
    }

    #[test]
    fn the_last_admin_is_known() {
        let mut register = register();
        assert!(register.is_last_admin(&name("anna")));
        assert!(!register.is_last_admin(&name("ben")));
        register.put_user(User { name: name("ben"), role: Role::Admin, created: 0 });
        assert!(!register.is_last_admin(&name("anna")));
    }
}
