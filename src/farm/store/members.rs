//! Records of users and tokens. Of a token only a hash is stored.

use sqlx::Row;
use sqlx::any::AnyRow;

use super::{Store, StoreError};
use crate::farm::access::scope::{Role, Scope};
use crate::farm::access::secret::SecretHash;
use crate::farm::access::token::Token;
use crate::farm::access::user::{User, UserName};

impl Store {
    /// Stores a user, or the new role of one.
    pub async fn put_user(&self, user: &User) -> Result<(), StoreError> {
        let query = "INSERT INTO users (name, role, created) VALUES ($1, $2, $3) \
                     ON CONFLICT (name) DO UPDATE SET role = excluded.role";
        let query = sqlx::query(query).bind(user.name.to_string()).bind(user.role.name()).bind(user.created);
        self.write(query).await
    }

    /// Deletes a user with all tokens.
    pub async fn delete_user(&self, name: &UserName) -> Result<(), StoreError> {
        self.write(sqlx::query("DELETE FROM users WHERE name = $1").bind(name.to_string())).await
    }

    /// All users, by name.
    pub async fn users(&self) -> Result<Vec<User>, StoreError> {
        let rows = sqlx::query("SELECT name, role, created FROM users ORDER BY name").fetch_all(&self.pool).await?;
        rows.iter().map(read_user).collect()
    }

    /// Stores a new token.
    pub async fn insert_token(&self, token: &Token) -> Result<(), StoreError> {
        let query = "INSERT INTO tokens (hash, user_name, label, scope, created, expires, parent) \
                     VALUES ($1, $2, $3, $4, $5, $6, $7)";
        let query = sqlx::query(query).bind(token.hash.digits()).bind(token.user.as_ref().map(ToString::to_string));
        let query = query.bind(token.label.clone()).bind(token.scope.name()).bind(token.created).bind(token.expires);
        self.write(query.bind(token.parent.map(|parent| parent.digits()))).await
    }

    /// Deletes a token with those that came from it.
    pub async fn delete_token(&self, hash: &SecretHash) -> Result<(), StoreError> {
        self.write(sqlx::query("DELETE FROM tokens WHERE hash = $1").bind(hash.digits())).await
    }

    /// All tokens that are valid at `now`, milliseconds since 1970. Others are deleted.
    pub async fn valid_tokens(&self, now: i64) -> Result<Vec<Token>, StoreError> {
        self.write(sqlx::query("DELETE FROM tokens WHERE expires <= $1").bind(now)).await?;
        let query = "SELECT hash, user_name, label, scope, created, expires, parent FROM tokens ORDER BY hash";
        sqlx::query(query).fetch_all(&self.pool).await?.iter().map(read_token).collect()
    }
}

fn read_user(row: &AnyRow) -> Result<User, StoreError> {
    let name: String = row.try_get("name")?;
    let role: String = row.try_get("role")?;
    let bad = |problem: &str| StoreError::BadRecord { what: format!("user {name}"), problem: problem.to_owned() };
    Ok(User {
        name: name.parse().map_err(|_| bad("it is no user's name"))?,
        role: Role::ALL.into_iter().find(|known| known.name() == role).ok_or_else(|| bad("the role is unknown"))?,
        created: row.try_get("created")?,
    })
}

fn read_token(row: &AnyRow) -> Result<Token, StoreError> {
    let digits: String = row.try_get("hash")?;
    let bad = |problem: &str| StoreError::BadRecord { what: "a token".to_owned(), problem: problem.to_owned() };
    let hash = |digits: &str| SecretHash::from_digits(digits).ok_or_else(|| bad("its hash is none"));
    let user: Option<String> = row.try_get("user_name")?;
    let scope: String = row.try_get("scope")?;
    let parent: Option<String> = row.try_get("parent")?;
    Ok(Token {
        hash: hash(&digits)?,
        user: user.map(|name| name.parse()).transpose().map_err(|_| bad("its user has no name"))?,
        label: row.try_get("label")?,
        scope: Scope::ALL.into_iter().find(|known| known.name() == scope).ok_or_else(|| bad("its scope is unknown"))?,
        created: row.try_get("created")?,
        expires: row.try_get("expires")?,
        parent: parent.map(|digits| hash(&digits)).transpose()?,
    })
}
