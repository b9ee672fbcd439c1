//! Records of sequences. Their frames are jobs.

use sqlx::Row;
use sqlx::any::AnyRow;

use super::{Store, StoreError};
use crate::farm::ids::{JobId, SequenceId};

/// A stored sequence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SequenceRow {
    /// Its id.
    pub id: SequenceId,
    /// When it was submitted, milliseconds since 1970.
    pub created: i64,
    /// Everything else, as JSON.
    pub record: String,
}

impl Store {
    /// Stores a sequence, new or changed.
    pub async fn put_sequence(&self, sequence: &SequenceRow) -> Result<(), StoreError> {
        let query = "INSERT INTO sequences (id, created, record) VALUES ($1, $2, $3) \
                     ON CONFLICT (id) DO UPDATE SET record = excluded.record";
        let query = sqlx::query(query).bind(sequence.id.number() as i64).bind(sequence.created);
        self.write(query.bind(sequence.record.clone())).await
    }

    /// All sequences, oldest first.
    pub async fn sequence_rows(&self) -> Result<Vec<SequenceRow>, StoreError> {
        let rows = sqlx::query("SELECT id, created, record FROM sequences ORDER BY id").fetch_all(&self.pool);
        rows.await?.iter().map(read).collect()
    }

    /// Deletes a sequence's record.
    pub async fn delete_sequence(&self, id: SequenceId) -> Result<(), StoreError> {
        self.write(sqlx::query("DELETE FROM sequences WHERE id = $1").bind(id.number() as i64)).await
    }
}

fn read(row: &AnyRow) -> Result<SequenceRow, StoreError> {
    let id = SequenceId::new(JobId::new(row.try_get::<i64, _>("id")? as u64));
    Ok(SequenceRow { id, created: row.try_get("created")?, record: row.try_get("record")? })
}
