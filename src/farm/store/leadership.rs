//! Who leads, of all coordinators on one PostgreSQL database: the one that took the last term.
//!
//! A term has a number, the epoch, and an end, which the leader moves on while it lives. When it is over, another coordinator may take the
//! next. Every write looks whether its epoch is still the newest and keeps it so until it is done, so a leader that was thought dead changes
//! nothing. All times are the database's.
//!
//! An SQLite file has one coordinator at a time, held by a lock in its folder, and needs none of this.

use std::time::Duration;

use sqlx::any::AnyArguments;
use sqlx::query::Query;
use sqlx::{Any, AnyConnection, AnyPool, Connection, Row};

use super::error::StoreError;
use super::settings::{EPOCH, meta, set_meta};

/// How long a leader leads after it was heard of last.
const TERM: Duration = Duration::from_secs(10);
/// How often it says that it lives.
pub(crate) const RENEWAL: Duration = Duration::from_secs(3);

/// When the term ends, milliseconds since 1970 by the database's clock.
const UNTIL: &str = "leader_until";
/// By which folder the leader is known: whoever holds the lock of the same folder knows that it is dead.
const HOLDER: &str = "leader_holder";

const NOW: &str = "(EXTRACT(EPOCH FROM clock_timestamp()) * 1000)::BIGINT";

/// A coordinator's term.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Term {
    pub(super) epoch: i64,
}

/// Fails while another coordinator leads.
pub(super) async fn refuse_while_led(
    connection: &mut AnyConnection,
    place: &str,
    holder: i64,
) -> Result<(), StoreError> {
    let query = format!(
        "SELECT 1 FROM meta AS term WHERE term.name = '{UNTIL}' AND term.value > {NOW} \
         AND NOT EXISTS (SELECT 1 FROM meta WHERE name = '{HOLDER}' AND value = $1)"
    );
    match sqlx::query(sqlx::AssertSqlSafe(query)).bind(holder).fetch_optional(connection).await {
        Ok(None) => Ok(()),
        Ok(Some(_)) => Err(StoreError::InUse { place: place.to_owned() }),
        // No table: a new database.
        Err(sqlx::Error::Database(problem)) if problem.code().is_some_and(|code| code == "42P01") => Ok(()),
        Err(problem) => Err(problem.into()),
    }
}

/// Takes the next term. Whoever calls holds the database's lock, and has looked that nobody leads.
pub(super) async fn take_term(pool: &AnyPool, holder: i64) -> Result<Term, StoreError> {
    let mut transaction = pool.begin().await?;
    // Writes of the last leader end before, or see the new epoch.
    sqlx::query(sqlx::AssertSqlSafe(format!("SELECT value FROM meta WHERE name = '{EPOCH}' FOR UPDATE")))
        .fetch_optional(&mut *transaction)
        .await?;
    let epoch = meta(&mut *transaction, EPOCH).await?.unwrap_or(0) + 1;
    set_meta(&mut *transaction, EPOCH, epoch).await?;
    set_meta(&mut *transaction, HOLDER, holder).await?;
    set_meta(&mut *transaction, UNTIL, 0).await?;
    sqlx::query(sqlx::AssertSqlSafe(prolongation())).execute(&mut *transaction).await?;
    transaction.commit().await?;
    Ok(Term { epoch })
}

fn prolongation() -> String {
    format!("UPDATE meta SET value = {NOW} + {} WHERE name = '{UNTIL}'", TERM.as_millis())
}

impl super::Store {
    /// Changes records, if this coordinator still leads.
    pub(super) async fn write(&self, query: Query<'_, Any, AnyArguments>) -> Result<(), StoreError> {
        let Some(Term { epoch }) = self.term else {
            query.execute(&self.pool).await?;
            return Ok(());
        };
        let mut transaction = self.pool.begin().await?;
        let shared = sqlx::AssertSqlSafe(format!("SELECT value FROM meta WHERE name = '{EPOCH}' FOR SHARE"));
        let newest: i64 = sqlx::query(shared).fetch_one(&mut *transaction).await?.try_get("value")?;
        if newest != epoch {
            return Err(StoreError::Deposed);
        }
        query.execute(&mut *transaction).await?;
        Ok(transaction.commit().await?)
    }

    /// Says that this coordinator lives.
    ///
    /// # Errors
    /// [`StoreError::Deposed`] when another one leads.
    pub async fn renew(&self) -> Result<(), StoreError> {
        if self.term.is_none() {
            return Ok(());
        }
        self.write(sqlx::query(sqlx::AssertSqlSafe(prolongation()))).await
    }

    /// Ends the term, so that nobody waits for its end.
    pub(super) async fn resign(&self) {
        if self.term.is_none() {
            return;
        }
        let ended = format!("UPDATE meta SET value = 0 WHERE name = '{UNTIL}'");
        if let Err(problem) = self.write(sqlx::query(sqlx::AssertSqlSafe(ended))).await {
            tracing::debug!(%problem, "a term ends by its time");
        }
    }
}

/// The number of the lock that is held while a database is opened: "photon" in ASCII.
const OPENING: i64 = 0x7068_6f74_6f6e;

/// One coordinator at a time looks who leads and changes the tables. The lock ends with the connection.
pub(super) async fn lock_opening(address: &str) -> Result<AnyConnection, sqlx::Error> {
    let mut connection = AnyConnection::connect(address).await?;
    sqlx::query("SET lock_timeout = '10s'").execute(&mut connection).await?;
    sqlx::query("SELECT pg_advisory_lock($1)").bind(OPENING).execute(&mut connection).await?;
    Ok(connection)
}
