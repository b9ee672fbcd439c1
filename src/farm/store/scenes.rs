//! Records of scenes. Their bytes are blobs.

use sqlx::Row;
use sqlx::any::AnyRow;

use super::{Store, StoreError};

/// A stored scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneRow {
    /// BLAKE3 of its bytes, 64 hexadecimal digits.
    pub hash: String,
    /// How many bytes.
    pub bytes: i64,
    /// When it was uploaded first, milliseconds since 1970.
    pub created: i64,
    /// Everything else, as JSON.
    pub record: String,
}

impl Store {
    /// Stores a scene; one that is there already stays.
    pub async fn insert_scene(&self, scene: &SceneRow) -> Result<(), StoreError> {
        let query =
            "INSERT INTO scenes (hash, bytes, created, record) VALUES ($1, $2, $3, $4) ON CONFLICT (hash) DO NOTHING";
        let query = sqlx::query(query).bind(scene.hash.clone()).bind(scene.bytes).bind(scene.created);
        self.write(query.bind(scene.record.clone())).await
    }

    /// All scenes, by hash.
    pub async fn scene_rows(&self) -> Result<Vec<SceneRow>, StoreError> {
        let rows = sqlx::query("SELECT hash, bytes, created, record FROM scenes ORDER BY hash").fetch_all(&self.pool);
        rows.await?.iter().map(read).collect()
    }

    /// Deletes a scene's record. Fails while a job refers to it.
    pub async fn delete_scene(&self, hash: &str) -> Result<(), StoreError> {
        self.write(sqlx::query("DELETE FROM scenes WHERE hash = $1").bind(hash.to_owned())).await
    }
}

fn read(row: &AnyRow) -> Result<SceneRow, StoreError> {
    Ok(SceneRow {
        hash: row.try_get("hash")?,
        bytes: row.try_get("bytes")?,
        created: row.try_get("created")?,
        record: row.try_get("record")?,
    })
}
