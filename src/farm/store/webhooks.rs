//! Records of webhooks, and of messages that were not taken yet.

use sqlx::Row;
use sqlx::any::AnyRow;

use super::{Store, StoreError};
use crate::farm::webhooks::signature::{key_of, key_text};
use crate::farm::webhooks::webhook::{Message, Webhook};

impl Store {
    /// Stores a new webhook.
    pub async fn insert_webhook(&self, webhook: &Webhook) -> Result<(), StoreError> {
        let query = sqlx::query("INSERT INTO webhooks (id, url, signing_key, created) VALUES ($1, $2, $3, $4)");
        let query = query.bind(webhook.id.clone()).bind(webhook.url.clone()).bind(key_text(&webhook.key));
        self.write(query.bind(webhook.created)).await
    }

    /// Deletes a webhook with all messages on their way to it.
    pub async fn delete_webhook(&self, id: &str) -> Result<(), StoreError> {
        self.write(sqlx::query("DELETE FROM webhooks WHERE id = $1").bind(id.to_owned())).await
    }

    /// All webhooks, oldest first.
    pub async fn webhooks(&self) -> Result<Vec<Webhook>, StoreError> {
        let query = sqlx::query("SELECT id, url, signing_key, created FROM webhooks ORDER BY created, id");
        let read = |row: &AnyRow| -> Result<Webhook, StoreError> {
            let id: String = row.try_get("id")?;
            let text: String = row.try_get("signing_key")?;
            let bad = || StoreError::BadRecord { what: format!("webhook {id}"), problem: "its key is none".to_owned() };
            Ok(Webhook {
                key: key_of(&text).ok_or_else(bad)?,
                id: id.clone(),
                url: row.try_get("url")?,
                created: row.try_get("created")?,
            })
        };
        query.fetch_all(&self.pool).await?.iter().map(read).collect()
    }

    /// Stores a message, or its next attempt.
    pub async fn put_message(&self, message: &Message) -> Result<(), StoreError> {
        let query = "INSERT INTO messages (id, webhook, body, attempt, due) \
                     SELECT $1, $2, $3, $4, $5 WHERE EXISTS (SELECT 1 FROM webhooks WHERE id = $2) \
                     ON CONFLICT (id) DO UPDATE SET attempt = excluded.attempt, due = excluded.due";
        let query = sqlx::query(query).bind(message.id.clone()).bind(message.webhook.clone());
        let query = query.bind(message.body.clone()).bind(i64::from(message.attempt)).bind(message.due);
        self.write(query).await
    }

    /// Deletes a message.
    pub async fn delete_message(&self, id: &str) -> Result<(), StoreError> {
        self.write(sqlx::query("DELETE FROM messages WHERE id = $1").bind(id.to_owned())).await
    }

    /// At most `limit` messages that are due at `now`, milliseconds since 1970, the longest waiting first.
    pub async fn due_messages(&self, now: i64, limit: i64) -> Result<Vec<Message>, StoreError> {
        let query = "SELECT id, webhook, body, attempt, due FROM messages WHERE due <= $1 ORDER BY due, id LIMIT $2";
        let read = |row: &AnyRow| -> Result<Message, StoreError> {
            Ok(Message {
                id: row.try_get("id")?,
                webhook: row.try_get("webhook")?,
                body: row.try_get("body")?,
                attempt: row.try_get::<i64, _>("attempt")? as u32,
                due: row.try_get("due")?,
            })
        };
        sqlx::query(query).bind(now).bind(limit).fetch_all(&self.pool).await?.iter().map(read).collect()
    }
}
