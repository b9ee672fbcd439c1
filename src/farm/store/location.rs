//! Where a store is.

use std::fs::{File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};
use std::time::Duration;

use sqlx::any::{AnyPoolOptions, install_default_drivers};
use sqlx::{AnyConnection, AnyPool, Connection, Row};
use tokio::time::sleep;

use super::error::StoreError;

/// Connections to a database that serves several.
const CONNECTIONS: u32 = 8;
/// How long a query waits for a connection.
const PATIENCE: Duration = Duration::from_secs(20);

/// The number of the lock by which a coordinator claims a PostgreSQL database: "photon" in ASCII.
const CLAIM: i64 = 0x7068_6f74_6f6e;
const CLAIM_ATTEMPTS: u32 = 10;
const CLAIM_PAUSE: Duration = Duration::from_millis(500);

/// Where the records are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecordsLocation {
    /// In memory.
    Memory,
    /// In an SQLite file.
    Sqlite(PathBuf),
    /// In a PostgreSQL database, `postgres://…`.
    Postgres(String),
}

/// Where the blobs are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BlobsLocation {
    /// In a folder.
    Folder(PathBuf),
    /// In a bucket, `s3://BUCKET/PREFIX`; keys and endpoint come from the usual `AWS_…` variables of the environment.
    S3(String),
}

/// Where a store is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoreLocation {
    /// The records.
    pub records: RecordsLocation,
    /// The blobs.
    pub blobs: BlobsLocation,
    /// The folder that is locked, so that one coordinator at a time uses it.
    pub folder: PathBuf,
}

impl StoreLocation {
    /// Everything in one folder.
    pub fn folder(folder: impl Into<PathBuf>) -> Self {
        let folder = folder.into();
        Self {
            records: RecordsLocation::Sqlite(folder.join("photonfarm.sqlite")),
            blobs: BlobsLocation::Folder(folder.join("blobs")),
            folder,
        }
    }

    /// Makes the folder and locks it.
    pub(super) fn lock(&self) -> Result<Option<File>, StoreError> {
        let place = self.folder.display().to_string();
        let cannot_open = |problem: std::io::Error| StoreError::Open {
            place: place.clone(),
            problem: problem.to_string(),
            remedy: "give a folder that can be written with --data".to_owned(),
        };
        std::fs::create_dir_all(&self.folder).map_err(cannot_open)?;
        let file = self.folder.join("lock");
        let file = OpenOptions::new().create(true).truncate(false).write(true).open(file).map_err(cannot_open)?;
        match file.try_lock() {
            Ok(()) => Ok(Some(file)),
            Err(TryLockError::WouldBlock) => Err(StoreError::InUse { place }),
            // Some network file systems have no locks; whoever uses one has to take care.
            Err(TryLockError::Error(problem)) if problem.kind() == std::io::ErrorKind::Unsupported => Ok(None),
            Err(TryLockError::Error(problem)) => Err(cannot_open(problem)),
        }
    }
}

impl RecordsLocation {
    /// The place in words, without passwords.
    pub(super) fn name(&self) -> String {
        match self {
            Self::Memory => "in memory".to_owned(),
            Self::Sqlite(file) => file.display().to_string(),
            Self::Postgres(address) => address.rsplit('@').next().unwrap_or_default().to_owned(),
        }
    }

    pub(super) async fn connect(&self) -> Result<AnyPool, StoreError> {
        install_default_drivers();
        let options = AnyPoolOptions::new().acquire_timeout(PATIENCE);
        let pool = match self {
            // One connection, for ever: a second one would see another database.
            Self::Memory => options.max_connections(1).idle_timeout(None).max_lifetime(None).connect("sqlite::memory:"),
            Self::Sqlite(file) => {
                let address = sqlite_address(file, "rwc");
                return self.opened(sqlite_options(options).connect(&address).await);
            }
            Self::Postgres(address) => options.max_connections(CONNECTIONS).connect(address),
        };
        self.opened(pool.await)
    }

    /// Claims a database that several machines can reach, as long as the answer lives and its connection does not break.
    ///
    /// # Errors
    /// Another coordinator uses it, and goes on to for some seconds: that of one that was killed may take a moment to go.
    pub(super) async fn claim(&self) -> Result<Option<AnyConnection>, StoreError> {
        let Self::Postgres(address) = self else { return Ok(None) };
        let mut connection = self.opened(AnyConnection::connect(address).await)?;
        for _ in 0..CLAIM_ATTEMPTS {
            let row = sqlx::query("SELECT pg_try_advisory_lock($1) AS claimed")
                .bind(CLAIM)
                .fetch_one(&mut connection)
                .await?;
            if row.try_get("claimed")? {
                return Ok(Some(connection));
            }
            sleep(CLAIM_PAUSE).await;
        }
        Err(StoreError::InUse { place: self.name() })
    }

    pub(super) fn opened<T>(&self, result: Result<T, sqlx::Error>) -> Result<T, StoreError> {
        result.map_err(|problem| StoreError::Open {
            place: self.name(),
            problem: problem.to_string(),
            remedy: "check that it can be reached and written".to_owned(),
        })
    }
}

/// How sqlx names an SQLite file.
pub(super) fn sqlite_address(file: &Path, mode: &str) -> String {
    let escaped = file.to_string_lossy().replace('%', "%25").replace('?', "%3f").replace('#', "%23");
    format!("sqlite://{escaped}?mode={mode}")
}

/// Records are durable when a call returns; readers do not wait for writers.
fn sqlite_options(options: AnyPoolOptions) -> AnyPoolOptions {
    options.max_connections(4).after_connect(|connection, _| {
        Box::pin(async move {
            for pragma in ["journal_mode = WAL", "synchronous = FULL", "busy_timeout = 10000", "foreign_keys = ON"] {
                sqlx::query(sqlx::AssertSqlSafe(format!("PRAGMA {pragma}"))).execute(&mut *connection).await?;
            }
            Ok(())
        })
    })
}
