//! `store`: looks after what a coordinator keeps.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::exit_code::CliError;
use super::store_options::StoreOptions;
use super::terminal;
use crate::farm::access::user::UserName;
use crate::farm::coordinator::members::make_admin;

/// Look after a coordinator's store.
///
/// The coordinator must not run meanwhile.
#[derive(Clone, Debug, Args)]
pub(super) struct Store {
    #[command(subcommand)]
    task: Task,
}

#[derive(Clone, Debug, Subcommand)]
enum Task {
    /// Read everything, and say what is missing or damaged.
    Check {
        #[command(flatten)]
        store: StoreOptions,
    },
    /// Write all records and blobs into a zip archive.
    Export {
        /// The archive to write.
        file: PathBuf,
        #[command(flatten)]
        store: StoreOptions,
    },
    /// Add an admin, or give one a further token, and print it: so a coordinator gets its first user, and one that lost all tokens a new one.
    AddAdmin {
        /// 1 to 64 small letters, digits, dots, dashes, underscores and @.
        name: UserName,
        #[command(flatten)]
        store: StoreOptions,
    },
    /// Delete blobs that no record names.
    Gc {
        #[command(flatten)]
        store: StoreOptions,
    },
}

impl Store {
    pub(super) async fn run(self) -> Result<(), CliError> {
        match self.task {
            Task::Check { store } => {
                let store = store.open_existing().await?;
                let report = store.check().await;
                store.close().await;
                let report = report?;
                terminal::json(&report)?;
                match report.problems.len() {
                    0 => Ok(()),
                    count => Err(CliError::File(format!("{count} blobs are missing or damaged"))),
                }
            }
            Task::Export { file, store } => {
                let store = store.open_existing().await?;
                let exported = store.export(&file).await;
                store.close().await;
                Ok(exported?)
            }
            Task::AddAdmin { name, store } => {
                let store = store.open().await?;
                let secret = make_admin(&store, name.clone()).await;
                store.close().await;
                let secret = secret.map_err(|problem| CliError::File(problem.to_string()))?;
                terminal::note(&format!(
                    "this token is {name}'s; it is shown this once, and is as good as a password:"
                ));
                terminal::result(secret.reveal())
            }
            Task::Gc { store } => {
                let store = store.open_existing().await?;
                let report = store.clean_up().await;
                store.close().await;
                terminal::json(&report?)
            }
        }
    }
}
