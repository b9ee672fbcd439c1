//! Names of users.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::scope::Role;

/// Bytes of a name at most.
const LONGEST: usize = 64;

/// A user's name: 1 to 64 small letters, digits and `.`, `_`, `-`, `@`, of which the first is a letter or digit, so that names that look alike are alike.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema)]
#[serde(try_from = "String", into = "String")]
#[schema(value_type = String, pattern = "^[a-z0-9][a-z0-9._@-]{0,63}$")]
pub struct UserName(String);

/// A text that is not a user's name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a user's name is 1 to {LONGEST} small letters, digits, dots, dashes, underscores and @, and begins with a letter or digit"
)]
pub struct BadUserName;

impl UserName {
    /// The admin whose token a coordinator was started with.
    pub fn operator() -> Self {
        Self("operator".to_owned())
    }

    /// The name.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl FromStr for UserName {
    type Err = BadUserName;

    fn from_str(text: &str) -> Result<Self, BadUserName> {
        let is_plain = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || b"._-@".contains(&byte);
        // `.` and `..` mean something else in addresses.
        let begins_well = text.bytes().next().is_some_and(|byte| byte.is_ascii_alphanumeric());
        if begins_well && text.len() <= LONGEST && text.bytes().all(is_plain) {
            Ok(Self(text.to_owned()))
        } else {
            Err(BadUserName)
        }
    }
}

impl TryFrom<String> for UserName {
    type Error = BadUserName;

    fn try_from(text: String) -> Result<Self, BadUserName> {
        text.parse()
    }
}

impl From<UserName> for String {
    fn from(name: UserName) -> Self {
        name.0
    }
}

impl fmt::Display for UserName {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(out)
    }
}

/// A user.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct User {
    /// How they are called.
    pub name: UserName,
    /// What they are.
    pub role: Role,
    /// When they were added, milliseconds since 1970.
    pub created: i64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_plain() {
        for name in ["a", "anna", "a.b-c_d@studio.example", "0"] {
            assert_eq!(name.parse::<UserName>().map(String::from).as_deref(), Ok(name));
        }
        for name in ["", ".", "..", "-a", "Anna", "a b", "a/b", "ä", "a\n", &"a".repeat(LONGEST + 1)] {
            assert_eq!(name.parse::<UserName>(), Err(BadUserName), "{name}");
        }
    }
}
