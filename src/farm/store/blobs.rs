//! Blobs: scenes and snapshots. A name ends with the BLAKE3 hash of the bytes, so a torn or damaged one is told from a good one.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use bytes::Bytes;
use futures_util::StreamExt;
use object_store::aws::AmazonS3Builder;
use object_store::local::LocalFileSystem;
use object_store::memory::InMemory;
use object_store::path::Path;
use object_store::{ObjectStore, ObjectStoreExt, WriteMultipart};

use super::error::StoreError;
use super::location::BlobsLocation;
use crate::farm::ids::JobId;
use crate::farm::tls;

/// Parts of an upload that may be under way at the same time.
const PARTS_AT_ONCE: usize = 4;

/// Where scenes are until all their bytes have come.
const UPLOADS: &str = "uploads";

/// The name of a blob.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(transparent)]
pub struct BlobName(String);

impl BlobName {
    /// The bytes of a scene.
    pub fn of_scene(hash: &str) -> Self {
        Self(format!("scenes/{hash}"))
    }

    /// A job's merged state after so many shards.
    pub fn of_snapshot(job: JobId, shards: u64, bytes: &[u8]) -> Self {
        Self(format!("snapshots/{job}/{shards:012}-{}", blake3::hash(bytes).to_hex()))
    }

    /// The hash that its bytes must have.
    fn hash(&self) -> &str {
        self.0.rsplit(['/', '-']).next().unwrap_or_default()
    }
}

impl From<String> for BlobName {
    fn from(name: String) -> Self {
        Self(name)
    }
}

impl fmt::Display for BlobName {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.0)
    }
}

/// A blob that is there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlobEntry {
    /// Its name.
    pub name: BlobName,
    /// Its size.
    pub bytes: u64,
}

/// All blobs. Cheap to clone.
#[derive(Clone)]
pub struct Blobs {
    store: Arc<dyn ObjectStore>,
    prefix: Path,
    uploads: Arc<AtomicU64>,
}

impl Blobs {
    /// Looks whether they can be reached at all.
    pub(super) async fn check(&self) -> Result<(), StoreError> {
        let Some(Err(problem)) = self.store.list(Some(&self.prefix)).next().await else { return Ok(()) };
        Err(StoreError::Open {
            place: "of the blobs".to_owned(),
            problem: problem.to_string(),
            remedy: "check --blobs, its keys and its endpoint".to_owned(),
        })
    }

    pub(super) fn open(location: &BlobsLocation) -> Result<Self, StoreError> {
        match location {
            BlobsLocation::Folder(folder) => {
                let cannot_open = |problem: String| StoreError::Open {
                    place: folder.display().to_string(),
                    problem,
                    remedy: "give a folder that can be written".to_owned(),
                };
                std::fs::create_dir_all(folder).map_err(|problem| cannot_open(problem.to_string()))?;
                // What a coordinator that was killed had not finished. The store is locked: nobody else writes there.
                let unfinished = folder.join(UPLOADS);
                if unfinished.exists() {
                    std::fs::remove_dir_all(&unfinished).map_err(|problem| cannot_open(problem.to_string()))?;
                }
                let store = LocalFileSystem::new_with_prefix(folder);
                // A record must not name a blob that a power failure can take away.
                let store = store.map_err(|problem| cannot_open(problem.to_string()))?.with_fsync(true);
                Ok(Self::new(Arc::new(store), Path::default()))
            }
            BlobsLocation::S3(address) => {
                let rest = address.strip_prefix("s3://").unwrap_or(address);
                let (bucket, prefix) = rest.split_once('/').unwrap_or((rest, ""));
                tls::use_ring();
                let store = AmazonS3Builder::from_env().with_bucket_name(bucket).build()?;
                Ok(Self::new(Arc::new(store), Path::from(prefix)))
            }
        }
    }

    pub(super) fn in_memory() -> Self {
        Self::new(Arc::new(InMemory::new()), Path::default())
    }

    fn new(store: Arc<dyn ObjectStore>, prefix: Path) -> Self {
        Self { store, prefix, uploads: Arc::default() }
    }

    fn path(&self, name: &str) -> Path {
        Path::from_iter(self.prefix.parts().chain(Path::from(name).parts()))
    }

    /// Stores a blob: all of it, or nothing.
    pub async fn put(&self, name: &BlobName, bytes: Vec<u8>) -> Result<(), StoreError> {
        self.store.put(&self.path(&name.0), Bytes::from(bytes).into()).await?;
        Ok(())
    }

    /// Reads a blob and checks its hash.
    pub async fn get(&self, name: &BlobName) -> Result<Bytes, StoreError> {
        let bytes = self.store.get(&self.path(&name.0)).await?.bytes().await?;
        if blake3::hash(&bytes).to_hex().as_str() != name.hash() {
            return Err(StoreError::Damaged { name: name.to_string() });
        }
        Ok(bytes)
    }

    /// Deletes a blob; one that is not there is deleted already.
    pub async fn delete(&self, name: &BlobName) -> Result<(), StoreError> {
        match self.store.delete(&self.path(&name.0)).await {
            Ok(()) | Err(object_store::Error::NotFound { .. }) => Ok(()),
            Err(problem) => Err(problem.into()),
        }
    }

    /// All blobs.
    pub async fn list(&self) -> Result<Vec<BlobEntry>, StoreError> {
        let mut entries = Vec::new();
        let mut found = self.store.list(Some(&self.prefix));
        let skipped = self.prefix.parts().count();
        while let Some(entry) = found.next().await {
            let entry = entry?;
            let name = Path::from_iter(entry.location.parts().skip(skipped)).to_string();
            entries.push(BlobEntry { name: BlobName(name), bytes: entry.size });
        }
        entries.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(entries)
    }

    /// Begins a scene whose bytes come bit by bit.
    pub async fn begin_scene(&self) -> Result<Upload, StoreError> {
        let number = self.uploads.fetch_add(1, Ordering::Relaxed);
        let place = self.path(&format!("{UPLOADS}/{}-{number}", std::process::id()));
        let writer = WriteMultipart::new(self.store.put_multipart(&place).await?);
        Ok(Upload { blobs: self.clone(), place, writer, hasher: blake3::Hasher::new(), bytes: 0 })
    }
}

/// A scene on its way: written to the store while it is hashed, never whole in memory.
pub struct Upload {
    blobs: Blobs,
    place: Path,
    writer: WriteMultipart,
    hasher: blake3::Hasher,
    bytes: u64,
}

impl Upload {
    /// Takes the next bytes.
    pub async fn write(&mut self, bytes: &[u8]) -> Result<(), StoreError> {
        self.writer.wait_for_capacity(PARTS_AT_ONCE).await?;
        self.hasher.update(bytes);
        self.bytes += bytes.len() as u64;
        self.writer.write(bytes);
        Ok(())
    }

    /// How many bytes came so far.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// All bytes came.
    pub async fn finish(self) -> Result<Uploaded, StoreError> {
        let Self { blobs, place, writer, hasher, bytes } = self;
        writer.finish().await?;
        Ok(Uploaded { hash: hasher.finalize().to_hex().to_string(), bytes, blobs, place })
    }

    /// Nothing of it stays.
    pub async fn abort(self) -> Result<(), StoreError> {
        Ok(self.writer.abort().await?)
    }
}

/// A scene that came whole. It has a place of its own until it is kept.
pub struct Uploaded {
    /// BLAKE3 of its bytes.
    pub hash: String,
    /// How many bytes.
    pub bytes: u64,
    blobs: Blobs,
    place: Path,
}

impl Uploaded {
    /// Its bytes.
    pub async fn read(&self) -> Result<Bytes, StoreError> {
        Ok(self.blobs.store.get(&self.place).await?.bytes().await?)
    }

    /// It has its name from now on.
    pub async fn keep(&self) -> Result<(), StoreError> {
        let name = self.blobs.path(&BlobName::of_scene(&self.hash).0);
        Ok(self.blobs.store.rename(&self.place, &name).await?)
    }

    /// Nothing of it stays.
    pub async fn discard(&self) -> Result<(), StoreError> {
        Ok(self.blobs.store.delete(&self.place).await?)
    }
}
