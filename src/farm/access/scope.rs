//! What a token allows, and what a role allows at most.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What a token allows. Each but `worker` includes those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scope {
    /// Look at everything but tokens of others.
    Read,
    /// Upload scenes, submit jobs, and do anything to one's own.
    Submit,
    /// Do anything to jobs of others, and say who may do what.
    Admin,
    /// Join as a worker, and nothing else.
    Worker,
}

impl Scope {
    /// All scopes.
    pub const ALL: [Self; 4] = [Self::Read, Self::Submit, Self::Admin, Self::Worker];

    /// Its name in JSON, tables and the store.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Submit => "submit",
            Self::Admin => "admin",
            Self::Worker => "worker",
        }
    }

    /// Whether whoever has this one may do what `needed` allows.
    pub const fn includes(self, needed: Self) -> bool {
        match (self, needed) {
            (Self::Worker, Self::Worker) => true,
            (Self::Worker, _) | (_, Self::Worker) => false,
            (Self::Admin, _) | (Self::Submit, Self::Read | Self::Submit) | (Self::Read, Self::Read) => true,
            (Self::Submit, Self::Admin) | (Self::Read, _) => false,
        }
    }

    /// The lesser of two, of which none is `worker`.
    pub const fn at_most(self, other: Self) -> Self {
        if self.includes(other) { other } else { self }
    }
}

/// What a user is to a farm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Looks at jobs and pictures.
    Viewer,
    /// Submits jobs, and does anything to their own.
    Artist,
    /// Does anything.
    Admin,
}

impl Role {
    /// All roles.
    pub const ALL: [Self; 3] = [Self::Viewer, Self::Artist, Self::Admin];

    /// Its name in JSON, tables and the store.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Viewer => "viewer",
            Self::Artist => "artist",
            Self::Admin => "admin",
        }
    }

    /// What a user's tokens allow at most.
    pub const fn scope(self) -> Scope {
        match self {
            Self::Viewer => Scope::Read,
            Self::Artist => Scope::Submit,
            Self::Admin => Scope::Admin,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scopes_include_lesser_ones_and_the_workers_stands_alone() {
        let included = |scope: Scope| Scope::ALL.map(|needed| scope.includes(needed));
        assert_eq!(included(Scope::Read), [true, false, false, false]);
        assert_eq!(included(Scope::Submit), [true, true, false, false]);
        assert_eq!(included(Scope::Admin), [true, true, true, false]);
        assert_eq!(included(Scope::Worker), [false, false, false, true]);
        assert_eq!(Scope::Admin.at_most(Scope::Read), Scope::Read);
        assert_eq!(Scope::Read.at_most(Scope::Admin), Scope::Read);
    }
}
