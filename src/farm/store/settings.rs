//! Numbers that belong to the whole store.

use sqlx::any::AnyArguments;
use sqlx::query::Query;
use sqlx::{Any, Row};

use super::error::StoreError;

/// How often the store was opened; on PostgreSQL this is also the number of the leader's term.
pub(super) const EPOCH: &str = "epoch";

/// A number that belongs to the whole store.
pub(super) async fn meta<'e>(
    executor: impl sqlx::Executor<'e, Database = sqlx::Any>,
    name: &str,
) -> Result<Option<i64>, StoreError> {
    let query = sqlx::query("SELECT value FROM meta WHERE name = $1").bind(name.to_owned());
    let row = query.fetch_optional(executor).await?;
    Ok(row.map(|row| row.try_get("value")).transpose()?)
}

pub(super) async fn set_meta<'e>(
    executor: impl sqlx::Executor<'e, Database = sqlx::Any>,
    name: &str,
    value: i64,
) -> Result<(), StoreError> {
    setting(name, value).execute(executor).await?;
    Ok(())
}

/// The statement that sets a number that belongs to the whole store.
pub(super) fn setting<'q>(name: &str, value: i64) -> Query<'q, Any, AnyArguments> {
    let query =
        "INSERT INTO meta (name, value) VALUES ($1, $2) ON CONFLICT (name) DO UPDATE SET value = excluded.value";
    sqlx::query(query).bind(name.to_owned()).bind(value)
}
