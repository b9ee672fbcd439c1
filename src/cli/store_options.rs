//! Where a coordinator keeps what it must not lose.

use std::path::PathBuf;

use clap::Args;

use super::exit_code::CliError;
use crate::farm::store::{BlobsLocation, RecordsLocation, Store, StoreError, StoreLocation};

/// Where a coordinator keeps scenes, jobs and pictures.
#[derive(Clone, Debug, Args)]
pub(super) struct StoreOptions {
    /// Folder for scenes, jobs and pictures; `none` keeps all in memory [default: photonfarm in the user's data folder].
    #[arg(long, env = "PHOTONFARM_DATA", value_name = "DIR")]
    data: Option<PathBuf>,
    /// Records in this PostgreSQL database, postgres://USER:PASSWORD@HOST/NAME, instead of SQLite in the folder.
    #[arg(long, env = "PHOTONFARM_DATABASE", hide_env_values = true, value_name = "URL")]
    database: Option<String>,
    /// Blobs in this bucket, s3://BUCKET/PREFIX, instead of the folder. Keys and endpoint come from AWS_ACCESS_KEY_ID,
    /// AWS_SECRET_ACCESS_KEY, AWS_REGION, AWS_ENDPOINT.
    #[arg(long, env = "PHOTONFARM_BLOBS", value_name = "URL")]
    blobs: Option<String>,
}

impl StoreOptions {
    /// Where the store is; `None` for memory.
    pub(super) fn location(&self) -> Result<Option<StoreLocation>, CliError> {
        if self.data.as_deref().is_some_and(|data| data.as_os_str() == "none") {
            if self.database.is_some() || self.blobs.is_some() {
                let text = "--data none keeps all in memory; leave --database and --blobs out, or give a folder";
                return Err(CliError::Usage(text.to_owned()));
            }
            return Ok(None);
        }
        let folder = match self.data.clone().or_else(default_folder) {
            Some(folder) => folder,
            None => {
                let text = "no folder for data is known here; give one with --data, or --data none";
                return Err(CliError::Usage(text.to_owned()));
            }
        };
        let mut location = StoreLocation::folder(folder);
        if let Some(database) = &self.database {
            if !database.starts_with("postgres://") && !database.starts_with("postgresql://") {
                let text = "--database is not the address of a PostgreSQL database; write postgres://…";
                return Err(CliError::Usage(text.to_owned()));
            }
            location.records = RecordsLocation::Postgres(database.clone());
        }
        if let Some(blobs) = &self.blobs {
            if !blobs.starts_with("s3://") {
                return Err(CliError::Usage(format!("--blobs is \"{blobs}\"; write s3://BUCKET/PREFIX")));
            }
            location.blobs = BlobsLocation::S3(blobs.clone());
        }
        Ok(Some(location))
    }

    /// Opens a store that is there.
    pub(super) async fn open_existing(&self) -> Result<Store, CliError> {
        let missing = self.location()?.map(|location| location.folder).filter(|folder| !folder.exists());
        if let Some(folder) = missing {
            let text = format!("there is no store in {}; give its folder with --data", folder.display());
            return Err(CliError::File(text));
        }
        self.open().await
    }

    /// Opens the store, a new one where there is none.
    pub(super) async fn open(&self) -> Result<Store, CliError> {
        Ok(match self.location()? {
            Some(location) => Store::open(&location).await?,
            None => Store::in_memory().await?,
        })
    }
}

impl From<StoreError> for CliError {
    fn from(error: StoreError) -> Self {
        Self::File(error.to_string())
    }
}

/// Where programs of this user keep data on this platform.
fn default_folder() -> Option<PathBuf> {
    let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let base = if cfg!(windows) {
        variable("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        variable("HOME").map(|home| home.join("Library/Application Support"))
    } else {
        variable("XDG_DATA_HOME").or_else(|| variable("HOME").map(|home| home.join(".local/share")))
    };
    base.map(|base| base.join("photonfarm"))
}
