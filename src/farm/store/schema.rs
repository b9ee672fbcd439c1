//! The tables, and how older stores become newer ones: one step a version, each in a transaction.

use sqlx::AnyPool;

use super::blobs::Blobs;
use super::error::StoreError;
use super::location::{RecordsLocation, sqlite_address};
use super::settings::{EPOCH, meta, set_meta};

/// Steps from no tables to the newest version; a released one never changes. Both databases understand them.
const MIGRATIONS: &[&[&str]] = &[FARM, ACCESS, WEBHOOKS, SEQUENCES];

const FARM: &[&str] = &[
    "CREATE TABLE scenes (hash TEXT PRIMARY KEY, bytes BIGINT NOT NULL, created BIGINT NOT NULL, record TEXT NOT NULL)",
    "CREATE TABLE jobs (id BIGINT PRIMARY KEY, state TEXT NOT NULL, scene TEXT NOT NULL REFERENCES scenes (hash), \
     created BIGINT NOT NULL, ended BIGINT, record TEXT NOT NULL, snapshot TEXT, earlier_snapshot TEXT, \
     resume_snapshot TEXT)",
    "CREATE INDEX jobs_by_state ON jobs (state)",
    "CREATE TABLE events (sequence BIGINT PRIMARY KEY, time BIGINT NOT NULL, job BIGINT, worker TEXT, text TEXT NOT NULL)",
    "CREATE INDEX events_by_job ON events (job)",
    "CREATE TABLE workers (name TEXT PRIMARY KEY, threads BIGINT NOT NULL, first_seen BIGINT NOT NULL, \
     last_seen BIGINT NOT NULL)",
];

const ACCESS: &[&str] = &[
    "CREATE TABLE users (name TEXT PRIMARY KEY, role TEXT NOT NULL, created BIGINT NOT NULL)",
    "CREATE TABLE tokens (hash TEXT PRIMARY KEY, user_name TEXT REFERENCES users (name) ON DELETE CASCADE, \
     label TEXT NOT NULL, scope TEXT NOT NULL, created BIGINT NOT NULL, expires BIGINT, \
     parent TEXT REFERENCES tokens (hash) ON DELETE CASCADE)",
    "CREATE INDEX tokens_by_user ON tokens (user_name)",
    "CREATE INDEX tokens_by_parent ON tokens (parent)",
];

const WEBHOOKS: &[&str] = &[
    "CREATE TABLE webhooks (id TEXT PRIMARY KEY, url TEXT NOT NULL, signing_key TEXT NOT NULL, created BIGINT NOT NULL)",
    "CREATE TABLE messages (id TEXT PRIMARY KEY, webhook TEXT NOT NULL REFERENCES webhooks (id) ON DELETE CASCADE, \
     body TEXT NOT NULL, attempt BIGINT NOT NULL, due BIGINT NOT NULL)",
    "CREATE INDEX messages_by_time ON messages (due)",
    "CREATE INDEX messages_by_webhook ON messages (webhook)",
];

const SEQUENCES: &[&str] =
    &["CREATE TABLE sequences (id BIGINT PRIMARY KEY, created BIGINT NOT NULL, record TEXT NOT NULL)"];

/// The newest version that this program knows.
pub(super) const VERSION: i64 = MIGRATIONS.len() as i64;

/// Looks at an SQLite file without writing to it.
pub(super) async fn refuse_newer(records: &RecordsLocation) -> Result<(), StoreError> {
    let RecordsLocation::Sqlite(file) = records else { return Ok(()) };
    if !file.exists() {
        return Ok(());
    }
    sqlx::any::install_default_drivers();
    let options = sqlx::any::AnyPoolOptions::new().max_connections(1);
    let pool = records.opened(options.connect(&sqlite_address(file, "ro")).await)?;
    let readable = sqlx::query("SELECT COUNT(*) FROM sqlite_master").execute(&pool).await;
    let found = version(&pool).await;
    pool.close().await;
    readable.map_err(|problem| {
        let problem = StoreError::from(problem);
        let (what, remedy) = if problem.is_full() || problem.is_temporary() {
            ("it cannot be read or written", "make room on its disk and look at its permissions")
        } else {
            ("it is damaged", "restore it from a backup, or give another folder with --data")
        };
        let problem = format!("{what} ({problem})");
        StoreError::Open { place: file.display().to_string(), problem, remedy: remedy.to_owned() }
    })?;
    refuse(found?)
}

fn refuse(found: i64) -> Result<(), StoreError> {
    if found > VERSION { Err(StoreError::Newer { found, known: VERSION }) } else { Ok(()) }
}

/// Brings the tables up to date.
///
/// # Errors
/// It is new, but `blobs` are there: those of records that are lost.
pub(super) async fn migrate(pool: &AnyPool, blobs: &Blobs) -> Result<(), StoreError> {
    let found = version(pool).await?;
    refuse(found)?;
    if found == 0 && !blobs.list().await?.is_empty() {
        return Err(StoreError::Open {
            place: "of these blobs".to_owned(),
            problem: "scenes and snapshots are there, but no record of them".to_owned(),
            remedy: "restore the database from a backup, or give another place for one of them".to_owned(),
        });
    }
    if found == 0 {
        create_meta(pool).await?;
    }
    for (index, steps) in MIGRATIONS.iter().enumerate().skip(found as usize) {
        step(pool, index as i64, steps).await?;
    }
    Ok(())
}

/// The table that holds the version, 0 at first.
async fn create_meta(pool: &AnyPool) -> Result<(), StoreError> {
    let create = "CREATE TABLE IF NOT EXISTS meta (name TEXT PRIMARY KEY, value BIGINT NOT NULL)";
    if let Err(problem) = sqlx::query(create).execute(pool).await {
        // PostgreSQL answers one of two who create a table at once with an error.
        meta(pool, "version").await.map_err(|_| StoreError::from(problem))?;
    }
    sqlx::query("INSERT INTO meta (name, value) VALUES ('version', 0) ON CONFLICT (name) DO NOTHING")
        .execute(pool)
        .await?;
    Ok(())
}

/// Makes version `from` + 1 of version `from`, unless somebody who opened the store at the same time did it meanwhile.
async fn step(pool: &AnyPool, from: i64, statements: &[&'static str]) -> Result<(), StoreError> {
    let mut transaction = pool.begin().await?;
    // The first statement takes the row, so that others wait here.
    let raised =
        sqlx::query("UPDATE meta SET value = $1 WHERE name = 'version' AND value = $2").bind(from + 1).bind(from);
    if raised.execute(&mut *transaction).await?.rows_affected() == 1 {
        for statement in statements {
            sqlx::query(*statement).execute(&mut *transaction).await?;
        }
    }
    Ok(transaction.commit().await?)
}

/// Counts that the store is opened; answers how often it was, this time included.
pub(super) async fn count_opening(pool: &AnyPool) -> Result<i64, StoreError> {
    let epoch = meta(pool, EPOCH).await?.unwrap_or(0) + 1;
    set_meta(pool, EPOCH, epoch).await?;
    Ok(epoch)
}

/// The version of the tables; 0 where there are none.
async fn version(pool: &AnyPool) -> Result<i64, StoreError> {
    match meta(pool, "version").await {
        Ok(version) => Ok(version.unwrap_or(0)),
        // No table: a new database.
        Err(StoreError::Records(sqlx::Error::Database(_))) => Ok(0),
        Err(problem) => Err(problem),
    }
}
