//! What is known of a token.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::scope::Scope;
use super::secret::SecretHash;
use super::user::UserName;

/// A token without its secret.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Token {
    /// Hash of its secret.
    pub hash: SecretHash,
    /// Whose it is; nobody's where workers join by it.
    pub user: Option<UserName>,
    /// What it is for, in words.
    pub label: String,
    /// What it allows, if the user's role does.
    pub scope: Scope,
    /// When it was made, milliseconds since 1970.
    pub created: i64,
    /// From when on it is not taken any more.
    pub expires: Option<i64>,
    /// The token with which somebody logged in to get this one. It ends with that.
    pub parent: Option<SecretHash>,
}

/// A token as people see it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct TokenView {
    /// What to call it: twelve hexadecimal digits.
    pub id: String,
    /// Whose it is; nobody's where workers join by it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub user: Option<UserName>,
    /// What it is for, in words.
    pub label: String,
    /// What it allows.
    pub scope: Scope,
    /// When it was made, milliseconds since 1970.
    pub created: i64,
    /// From when on it is not taken any more; never when it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expires: Option<i64>,
}

impl Token {
    /// Whether it is taken at `now`, milliseconds since 1970.
    pub fn is_valid(&self, now: i64) -> bool {
        self.expires.is_none_or(|expires| now < expires)
    }

    /// What people see of it.
    pub fn view(&self) -> TokenView {
        let Self { hash, user, label, scope, created, expires, .. } = self.clone();
        TokenView { id: hash.id(), user, label, scope, created, expires }
    }
}
