//! Who sent a request, and what follows.

use super::scope::Scope;
use super::secret::SecretHash;
use super::user::UserName;

/// Who sent a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Caller {
    /// Somebody, on a farm without users. They may do everything.
    Anyone,
    /// A user.
    User {
        /// Their name.
        name: UserName,
        /// What their token and their role both allow.
        scope: Scope,
        /// The token that they sent.
        token: SecretHash,
    },
    /// Somebody who may join as a worker.
    Joining {
        /// The token that they sent.
        token: SecretHash,
    },
}

/// Why a request is not taken.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Denied {
    /// It has no token, and there are users.
    #[error("this coordinator answers users only, and the request has no token")]
    NoToken,
    /// Nobody has its token.
    #[error("the request's token is unknown, revoked or expired")]
    UnknownToken,
    /// Its token does not allow that.
    #[error("that needs a token of the scope {}", .needed.name())]
    Scope {
        /// What it would take.
        needed: Scope,
    },
    /// Somebody logged in at the provider whom nobody knows here.
    #[error("nobody here is called \"{name}\"")]
    UnknownAccount {
        /// As the provider calls them.
        name: String,
    },
    /// It is somebody else's.
    #[error("{what} belongs to {}", .owner.as_ref().map_or("nobody", UserName::as_str))]
    NotYours {
        /// What it is, as "job 0tkx42se".
        what: String,
        /// Whose it is.
        owner: Option<UserName>,
    },
}

impl Denied {
    /// What to do about it.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::NoToken => {
                "send `Authorization: Bearer TOKEN`; on the command line, set PHOTONFARM_TOKEN or give --token-file"
            }
            Self::UnknownToken => "ask an admin of the farm for a token",
            Self::Scope { .. } => "ask an admin of the farm for such a token",
            Self::UnknownAccount { .. } => "ask an admin of the farm to add a user of this name",
            Self::NotYours { .. } => "ask its owner or an admin of the farm",
        }
    }
}

impl Caller {
    /// The caller's name, where there are users.
    pub fn name(&self) -> Option<&UserName> {
        match self {
            Self::User { name, .. } => Some(name),
            Self::Anyone | Self::Joining { .. } => None,
        }
    }

    /// Who the caller is, in words.
    pub fn shown(&self) -> &str {
        match self {
            Self::User { name, .. } => name.as_str(),
            Self::Anyone => "anyone",
            Self::Joining { .. } => "a worker",
        }
    }

    /// What the caller may do.
    pub fn scope(&self) -> Scope {
        match self {
            Self::Anyone => Scope::Admin,
            Self::User { scope, .. } => *scope,
            Self::Joining { .. } => Scope::Worker,
        }
    }

    /// Lets pass whoever may do what `needed` allows.
    pub fn require(&self, needed: Scope) -> Result<(), Denied> {
        let may = self.scope().includes(needed);
        if may { Ok(()) } else { Err(Denied::Scope { needed }) }
    }

    /// Lets pass whoever may join as a worker; answers the token by which they do.
    pub fn token_to_join(&self) -> Result<Option<SecretHash>, Denied> {
        match self {
            Self::Anyone => Ok(None),
            Self::Joining { token } => Ok(Some(*token)),
            Self::User { .. } => Err(Denied::Scope { needed: Scope::Worker }),
        }
    }

    /// Lets pass whoever may change what belongs to `owner`; `what` says what it is.
    pub fn require_owner(&self, owner: Option<&UserName>, what: impl FnOnce() -> String) -> Result<(), Denied> {
        self.require(Scope::Submit)?;
        let is_own = owner.is_some() && owner == self.name();
        let may = is_own || self.scope() == Scope::Admin;
        if may { Ok(()) } else { Err(Denied::NotYours { what: what(), owner: owner.cloned() }) }
    }
}
