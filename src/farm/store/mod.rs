//! What a farm keeps: records in SQL, blobs in folders or buckets.
//!
//! | file | what |
//! |---|---|
//! | `location` | where it is |
//! | `settings` | numbers that belong to the whole store |
//! | `schema` | tables, and how older stores become newer ones |
//! | [`jobs`], [`sequences`], [`scenes`], [`members`], [`webhooks`], [`journal`] | records; durable when a call returns |
//! | [`leadership`] | which coordinator may write, where several share a database |
//! | [`blobs`] | scenes and snapshots: large, named by their hash, checked when read |
//! | [`maintenance`] | check, export, clean up |
//!
//! Whatever changes records while a coordinator runs is one statement, and goes by way of `Store::write`: a transaction on SQLite that a full disk
//! ends in the middle stays open on its connection, with the lock for writing (sqlx 0.9: it rolls back to a savepoint where SQLite has rolled
//! back all).
//!
//! One set of queries serves SQLite and PostgreSQL, one port serves folders, S3 and memory: a coordinator without a data folder uses
//! the same code on a database in memory.

pub(crate) mod blobs;
mod error;
pub mod jobs;
pub mod journal;
pub(crate) mod leadership;
mod location;
pub(crate) mod maintenance;
pub(crate) mod members;
pub mod scenes;
mod schema;
pub mod sequences;
mod settings;
pub(crate) mod webhooks;

use std::fs::File;
use std::sync::Arc;

use leadership::Term;
use sqlx::{AnyPool, Connection};

pub use blobs::{BlobName, Blobs, Upload};
pub use error::StoreError;
pub use location::{BlobsLocation, RecordsLocation, StoreLocation};

/// An open store. Cheap to clone; all clones are the same one.
#[derive(Clone)]
pub struct Store {
    pool: AnyPool,
    blobs: Blobs,
    epoch: u64,
    is_durable: bool,
    /// Held as long as the store is open, so that no second coordinator writes into the same folder …
    _lock: Option<Arc<File>>,
    /// … or, where several share a database, looked at with every write.
    term: Option<Term>,
}

impl Store {
    /// Opens a store; makes it if there is none, brings an older one up to date, and refuses a newer one without touching it.
    ///
    /// # Errors
    /// [`StoreError::InUse`] while another coordinator uses it: with an SQLite file as long as that runs, with PostgreSQL as long as it leads.
    pub async fn open(location: &StoreLocation) -> Result<Self, StoreError> {
        let lock = location.lock()?.map(Arc::new);
        schema::refuse_newer(&location.records).await?;
        let holder = location.holder()?;
        let opening = location.records.lock_opening(holder).await?;
        let pool = location.records.connect().await?;
        let blobs = Blobs::open(&location.blobs)?;
        blobs.check().await?;
        schema::migrate(&pool, &blobs).await?;
        let (epoch, term) = match opening {
            None => (schema::count_opening(&pool).await?, None),
            Some(opening) => {
                let term = leadership::take_term(&pool, holder).await?;
                opening.close().await?;
                (term.epoch, Some(term))
            }
        };
        Ok(Self { pool, blobs, epoch: epoch as u64, is_durable: true, _lock: lock, term })
    }

    /// A store in memory: it ends with the process.
    pub async fn in_memory() -> Result<Self, StoreError> {
        let pool = RecordsLocation::Memory.connect().await?;
        let blobs = Blobs::in_memory();
        schema::migrate(&pool, &blobs).await?;
        let epoch = schema::count_opening(&pool).await? as u64;
        Ok(Self { pool, blobs, epoch, is_durable: false, _lock: None, term: None })
    }

    /// How often this store was opened, this time included.
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// Whether it outlives the process.
    pub fn is_durable(&self) -> bool {
        self.is_durable
    }

    /// The blobs.
    pub fn blobs(&self) -> &Blobs {
        &self.blobs
    }

    /// Closes all connections.
    pub async fn close(&self) {
        self.resign().await;
        self.pool.close().await;
    }
}
