//! What can go wrong with a store, and what follows from it.

use std::error::Error;
use std::io::ErrorKind;

/// A store that does not do what it was asked.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// It cannot be opened.
    #[error("the store {place} cannot be opened: {problem}; {remedy}")]
    Open {
        /// Where it is.
        place: String,
        /// What is wrong.
        problem: String,
        /// What the user can do.
        remedy: String,
    },
    /// Another coordinator uses it.
    #[error("the store {place} is used by another coordinator; stop that one, or give this one another store")]
    InUse {
        /// Where it is.
        place: String,
    },
    /// Another coordinator leads since. Nothing was written.
    #[error("another coordinator leads now; this one has to stop, and may stand by")]
    Deposed,
    /// It was written by a newer program. Nothing was changed.
    #[error("the store is of version {found}, this program knows versions up to {known}; use the newer program")]
    Newer {
        /// The store's version.
        found: i64,
        /// The newest version that this program knows.
        known: i64,
    },
    /// The database does not do it.
    #[error("the database fails: {0}")]
    Records(#[from] sqlx::Error),
    /// Blobs cannot be read or written.
    #[error("the blob store fails: {0}")]
    Blobs(#[from] object_store::Error),
    /// A blob is not what was stored.
    #[error("blob {name} is damaged: its bytes do not have its hash")]
    Damaged {
        /// The blob.
        name: String,
    },
    /// A record is not what was stored.
    #[error("a record of {what} cannot be read: {problem}")]
    BadRecord {
        /// What of.
        what: String,
        /// What is wrong.
        problem: String,
    },
    /// A file that is exported to, or read from, fails.
    #[error("{file}: {problem}")]
    File {
        /// The file.
        file: String,
        /// What the system says.
        problem: String,
    },
}

impl StoreError {
    /// Whether there is no room, or nothing may be written: it may get better when somebody makes room.
    pub fn is_full(&self) -> bool {
        match self {
            // SQLITE_READONLY, SQLITE_IOERR, SQLITE_FULL and SQLITE_CANTOPEN; PostgreSQL: class 53, insufficient resources.
            Self::Records(sqlx::Error::Database(error)) => error.code().is_some_and(|code| {
                sqlite_code(&code).is_some_and(|code| matches!(code, 8 | 10 | 13 | 14)) || code.starts_with("53")
            }),
            Self::Blobs(error) => chain_has(error, is_full_kind),
            Self::Records(error) => chain_has(error, is_full_kind),
            _ => false,
        }
    }

    /// Whether another coordinator leads.
    pub fn is_deposed(&self) -> bool {
        matches!(self, Self::Deposed)
    }

    /// Whether something is gone that no waiting brings back.
    pub fn is_for_good(&self) -> bool {
        matches!(
            self,
            Self::Damaged { .. } | Self::BadRecord { .. } | Self::Blobs(object_store::Error::NotFound { .. })
        )
    }

    /// Whether the same may succeed later without anybody's help, for example because a server restarts.
    pub fn is_temporary(&self) -> bool {
        match self {
            Self::Records(error) => {
                matches!(
                    error,
                    sqlx::Error::Io(_) | sqlx::Error::PoolTimedOut | sqlx::Error::Protocol(_) | sqlx::Error::Tls(_)
                ) || matches!(error, sqlx::Error::Database(error) if error.code().is_some_and(|code| {
                    // SQLITE_BUSY and SQLITE_LOCKED; PostgreSQL: connection exceptions, and administrator shutdown.
                    sqlite_code(&code).is_some_and(|code| matches!(code, 5 | 6))
                        || code.starts_with("08") || code.starts_with("57P")
                }))
            }
            Self::Blobs(object_store::Error::Generic { .. }) => true,
            _ => false,
        }
    }
}

/// The basic code of SQLite, which it extends by higher bytes; `None` for PostgreSQL's, which have five characters.
fn sqlite_code(code: &str) -> Option<u32> {
    if code.len() < 5 { code.parse::<u32>().ok().map(|code| code & 0xff) } else { None }
}

fn is_full_kind(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::StorageFull | ErrorKind::ReadOnlyFilesystem | ErrorKind::QuotaExceeded)
}

fn chain_has(error: &(dyn Error + 'static), is_kind: fn(ErrorKind) -> bool) -> bool {
    let mut next = Some(error);
    while let Some(error) = next {
        if error.downcast_ref::<std::io::Error>().is_some_and(|error| is_kind(error.kind())) {
            return true;
        }
        next = error.source();
    }
    false
}
