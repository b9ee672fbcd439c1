//! Records of jobs.

use sqlx::Row;
use sqlx::any::AnyRow;

use super::blobs::BlobName;
use super::settings::{meta, setting};
use super::{Store, StoreError};
use crate::farm::ids::JobId;
use crate::farm::job::JobState;

/// The largest id ever used: ids are not used twice, even if jobs are deleted and the clock goes back.
const LAST_JOB: &str = "last_job";

/// A stored job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JobRow {
    /// Its id.
    pub id: JobId,
    /// What it is doing.
    pub state: JobState,
    /// Hash of its scene.
    pub scene: String,
    /// When it was submitted, milliseconds since 1970.
    pub created: i64,
    /// When it ended.
    pub ended: Option<i64>,
    /// Everything else, as JSON.
    pub record: String,
    /// Blobs of its merged state.
    pub snapshots: Snapshots,
}

/// Blobs of a job's merged state.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Snapshots {
    /// The newest one; of an ended job the last.
    pub newest: Option<BlobName>,
    /// The one before, in case the newest is damaged.
    pub earlier: Option<BlobName>,
    /// The one from which an ended job can be continued, where that is not the newest.
    pub resume: Option<BlobName>,
}

impl Snapshots {
    /// All of them, best first.
    pub fn all(&self) -> impl Iterator<Item = &BlobName> {
        [&self.newest, &self.earlier, &self.resume].into_iter().flatten()
    }
}

const COLUMNS: &str = "id, state, scene, created, ended, record, snapshot, earlier_snapshot, resume_snapshot";

impl Store {
    /// The largest job id ever used.
    pub async fn last_job(&self) -> Result<Option<JobId>, StoreError> {
        Ok(meta(&self.pool, LAST_JOB).await?.map(|number| JobId::new(number as u64)))
    }

    /// Stores a new job.
    pub async fn insert_job(&self, job: &JobRow) -> Result<(), StoreError> {
        // The mark comes first: an id that was not used in the end is no harm, one that is used twice is.
        self.write(setting(LAST_JOB, job.id.number() as i64)).await?;
        let query = format!("INSERT INTO jobs ({COLUMNS}) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9)");
        let query = sqlx::query(sqlx::AssertSqlSafe(query));
        let query = query.bind(job.id.number() as i64).bind(job.state.name()).bind(job.scene.clone());
        let query = query.bind(job.created).bind(job.ended).bind(job.record.clone());
        let [newest, earlier, resume] = texts(&job.snapshots);
        self.write(query.bind(newest).bind(earlier).bind(resume)).await
    }

    /// Stores what has changed of a job; nothing when it was deleted meanwhile.
    pub async fn update_job(&self, job: &JobRow) -> Result<(), StoreError> {
        let query = "UPDATE jobs SET state = $2, ended = $3, record = $4, snapshot = $5, earlier_snapshot = $6, \
                     resume_snapshot = $7 WHERE id = $1";
        let [newest, earlier, resume] = texts(&job.snapshots);
        let query = sqlx::query(query).bind(job.id.number() as i64).bind(job.state.name()).bind(job.ended);
        self.write(query.bind(job.record.clone()).bind(newest).bind(earlier).bind(resume)).await
    }

    /// Deletes a job's record. Its blobs are the caller's, or those of the next clean-up.
    pub async fn delete_job(&self, id: JobId) -> Result<(), StoreError> {
        self.write(sqlx::query("DELETE FROM jobs WHERE id = $1").bind(id.number() as i64)).await
    }

    /// A job.
    pub async fn job_row(&self, id: JobId) -> Result<Option<JobRow>, StoreError> {
        let query = format!("SELECT {COLUMNS} FROM jobs WHERE id = $1");
        let query = sqlx::query(sqlx::AssertSqlSafe(query)).bind(id.number() as i64);
        query.fetch_optional(&self.pool).await?.map(|row| read(&row)).transpose()
    }

    /// All jobs, oldest first.
    pub async fn job_rows(&self) -> Result<Vec<JobRow>, StoreError> {
        let query = format!("SELECT {COLUMNS} FROM jobs ORDER BY id");
        let rows = sqlx::query(sqlx::AssertSqlSafe(query)).fetch_all(&self.pool).await?;
        rows.iter().map(read).collect()
    }
}

fn texts(snapshots: &Snapshots) -> [Option<String>; 3] {
    [&snapshots.newest, &snapshots.earlier, &snapshots.resume].map(|name| name.as_ref().map(ToString::to_string))
}

fn read(row: &AnyRow) -> Result<JobRow, StoreError> {
    let id = JobId::new(row.try_get::<i64, _>("id")? as u64);
    let bad = |problem: String| StoreError::BadRecord { what: format!("job {id}"), problem };
    let state: String = row.try_get("state")?;
    let state = JobState::ALL.into_iter().find(|known| known.name() == state);
    let state = state.ok_or_else(|| bad("its state is unknown".to_owned()))?;
    let blob = |column: &str| -> Result<Option<BlobName>, StoreError> {
        Ok(row.try_get::<Option<String>, _>(column)?.map(BlobName::from))
    };
    Ok(JobRow {
        id,
        state,
        scene: row.try_get("scene")?,
        created: row.try_get("created")?,
        ended: row.try_get("ended")?,
        record: row.try_get("record")?,
        snapshots: Snapshots {
            newest: blob("snapshot")?,
            earlier: blob("earlier_snapshot")?,
            resume: blob("resume_snapshot")?,
        },
    })
}
