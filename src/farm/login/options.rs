//! Which provider, and who its people are here.

use std::fmt;

use crate::farm::access::scope::Role;

/// What the provider says of somebody that is their name here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NameClaim {
    /// `preferred_username`.
    #[default]
    PreferredUsername,
    /// `email`, where the provider says that it was verified.
    Email,
    /// `sub`: the provider's own number of them.
    Subject,
}

impl NameClaim {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::PreferredUsername, Self::Email, Self::Subject];

    /// Its name in the provider's answers.
    pub const fn name(self) -> &'static str {
        match self {
            Self::PreferredUsername => "preferred_username",
            Self::Email => "email",
            Self::Subject => "sub",
        }
    }
}

/// A password that the provider gave this coordinator. It is never printed.
#[derive(Clone, PartialEq, Eq)]
pub struct ClientPassword(pub String);

impl fmt::Debug for ClientPassword {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("ClientPassword(…)")
    }
}

/// Which provider, and who its people are here.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProviderOptions {
    /// The provider's address, under which it describes itself (OpenID Connect Discovery 1.0).
    pub issuer: String,
    /// What this coordinator is called there.
    pub client: String,
    /// Its password there, if it has one.
    pub password: Option<ClientPassword>,
    /// The address under which browsers reach this coordinator, without a path.
    pub public_address: String,
    /// Who somebody is here.
    pub name: NameClaim,
    /// The role of people that come for the first time; they are refused where it is `None`.
    pub new_users: Option<Role>,
}
