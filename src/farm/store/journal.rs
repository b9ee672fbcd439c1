//! What happened, for people: who joined and left, which job ended how.

use sqlx::Row;

use super::settings::meta;
use super::{Store, StoreError};
use crate::farm::ids::JobId;

/// Lines that are kept.
const KEPT: i64 = 100_000;

/// A line of the journal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JournalRow {
    /// Its place; later lines have larger ones.
    pub sequence: i64,
    /// When, milliseconds since 1970.
    pub time: i64,
    /// The job that it is about.
    pub job: Option<JobId>,
    /// The worker that it is about.
    pub worker: Option<String>,
    /// What happened.
    pub text: String,
}

impl Store {
    /// Adds lines; their sequence numbers are given here. Each is one statement: what is repeated after a failure may be there twice.
    pub async fn append_journal(&self, rows: &[JournalRow]) -> Result<(), StoreError> {
        for row in rows {
            let query = "INSERT INTO events (sequence, time, job, worker, text) \
                         SELECT COALESCE(MAX(sequence), 0) + 1, $1, $2, $3, $4 FROM events";
            let query = sqlx::query(query).bind(row.time).bind(row.job.map(|job| job.number() as i64));
            self.write(query.bind(row.worker.clone()).bind(row.text.clone())).await?;
        }
        let old = "DELETE FROM events WHERE sequence <= (SELECT MAX(sequence) FROM events) - $1";
        self.write(sqlx::query(old).bind(KEPT)).await
    }

    /// At most `limit` lines after line `after`, of one job or of all.
    pub async fn journal(&self, after: i64, job: Option<JobId>, limit: i64) -> Result<Vec<JournalRow>, StoreError> {
        let query = "SELECT sequence, time, job, worker, text FROM events WHERE sequence > $1 AND ($2 < 0 OR job = $2) \
                     ORDER BY sequence LIMIT $3";
        let job = job.map_or(-1, |job| job.number() as i64);
        let rows = sqlx::query(query).bind(after).bind(job).bind(limit).fetch_all(&self.pool).await?;
        let read = |row: &sqlx::any::AnyRow| -> Result<JournalRow, StoreError> {
            Ok(JournalRow {
                sequence: row.try_get("sequence")?,
                time: row.try_get("time")?,
                job: row.try_get::<Option<i64>, _>("job")?.map(|job| JobId::new(job as u64)),
                worker: row.try_get("worker")?,
                text: row.try_get("text")?,
            })
        };
        rows.iter().map(read).collect()
    }

    /// Records that a worker was there.
    pub async fn record_worker(&self, name: &str, threads: u32, time: i64) -> Result<(), StoreError> {
        let query = "INSERT INTO workers (name, threads, first_seen, last_seen) VALUES ($1, $2, $3, $3) \
                     ON CONFLICT (name) DO UPDATE SET threads = excluded.threads, last_seen = excluded.last_seen";
        let query = sqlx::query(query).bind(name.to_owned()).bind(i64::from(threads)).bind(time);
        self.write(query).await
    }

    /// The version of the tables.
    pub async fn version(&self) -> Result<i64, StoreError> {
        Ok(meta(&self.pool, "version").await?.unwrap_or(0))
    }
}
