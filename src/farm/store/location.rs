//! Where a store is.

use std::fs::{File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};
use std::time::Duration;

use sqlx::any::{AnyPoolOptions, install_default_drivers};
use sqlx::{AnyConnection, AnyPool};

use super::error::StoreError;
use super::leadership;
use crate::farm::access::secret::random_bytes;

/// Connections to a database that serves several.
const CONNECTIONS: u32 = 8;
/// How long a query waits for a connection.
const PATIENCE: Duration = Duration::from_secs(20);

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

    /// A number that is kept in the folder, and by which coordinators that share a database tell each other apart.
    pub(super) fn holder(&self) -> Result<i64, StoreError> {
        let file = self.folder.join("holder");
        let failed = |problem: String| StoreError::Open {
            place: file.display().to_string(),
            problem,
            remedy: "give a folder that can be written with --data".to_owned(),
        };
        if let Some(known) = std::fs::read_to_string(&file).ok().and_then(|text| text.trim().parse().ok()) {
            return Ok(known);
        }
        let mut bytes = [0; 8];
        bytes.copy_from_slice(&random_bytes().map_err(|problem| failed(problem.to_string()))?[..8]);
        let holder = i64::from_le_bytes(bytes);
        std::fs::write(&file, format!("{holder}\n")).map_err(|problem| failed(problem.to_string()))?;
        Ok(holder)
    }

    /// Makes the folder and locks it.
    pub(super) fn lock(&self) -> Result<Option<File>, StoreError> {
        let place = self.folder.display().to_string();
        let cannot_open = |problem: std::io::Error| StoreError::Open {
            place: place.clone(),
            problem: problem.to_string(),
            remedy: "give a folder that can be written with --data".to_owned(),
        };
        make_private(&self.folder).map_err(cannot_open)?;
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
            Self::Postgres(address) => {
                return self.opened(postgres_options(options).connect(address).await);
            }
        };
        self.opened(pool.await)
    }

    /// Whether several coordinators may share it, of which one leads.
    pub fn is_shared(&self) -> bool {
        matches!(self, Self::Postgres(_))
    }

    /// Locks a database that several coordinators may share, while it is opened.
    ///
    /// # Errors
    /// Another one leads.
    pub(super) async fn lock_opening(&self, holder: i64) -> Result<Option<AnyConnection>, StoreError> {
        let Self::Postgres(address) = self else { return Ok(None) };
        install_default_drivers();
        let mut connection = self.opened(leadership::lock_opening(address).await)?;
        leadership::refuse_while_led(&mut connection, &self.name(), holder).await?;
        Ok(Some(connection))
    }

    pub(super) fn opened<T>(&self, result: Result<T, sqlx::Error>) -> Result<T, StoreError> {
        result.map_err(|problem| StoreError::Open {
            place: self.name(),
            problem: problem.to_string(),
            remedy: "check that it can be reached and written".to_owned(),
        })
    }
}

/// Makes a folder that only this user looks into; one that is there stays as it is.
fn make_private(folder: &Path) -> std::io::Result<()> {
    let mut builder = std::fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)
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

/// A coordinator that stops in the middle of a write, and does not go on, lets go of what it holds: another one may lead soon.
fn postgres_options(options: AnyPoolOptions) -> AnyPoolOptions {
    options.max_connections(CONNECTIONS).after_connect(|connection, _| {
        Box::pin(async move {
            sqlx::query("SET idle_in_transaction_session_timeout = '5s'").execute(&mut *connection).await?;
            Ok(())
        })
    })
}
