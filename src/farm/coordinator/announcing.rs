//! Tells webhooks when jobs change their state. What is to be told is stored first, so it is told also after a restart.

use std::sync::{Arc, Weak};
use std::time::Duration;

use futures_util::future::join_all;
use serde_json::json;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;
use tokio::time::sleep;
use tokio_util::sync::CancellationToken;

use super::CoordinatorHandle;
use super::shared::Shared;
use crate::farm::access::secret::random_bytes;
use crate::farm::error::FarmError;
use crate::farm::ids::JobId;
use crate::farm::job::JobState;
use crate::farm::locks::lock;
use crate::farm::store::StoreError;
use crate::farm::webhooks::sender::{Sender, Sent};
use crate::farm::webhooks::webhook::{Message, Webhook};

/// How often it is looked whether a message is due.
const LOOK: Duration = Duration::from_millis(500);
/// Messages on their way at the same time.
const AT_ONCE: i64 = 16;

impl CoordinatorHandle {
    /// All webhooks, oldest first.
    pub fn webhooks(&self) -> Vec<Webhook> {
        lock(&self.shared.webhooks).clone()
    }

    /// Adds a webhook with a new key.
    pub async fn add_webhook(&self, url: String) -> Result<Webhook, FarmError> {
        let shared = &self.shared;
        let _turn = shared.members.take().await?;
        let most = shared.options.limits.webhooks;
        if lock(&shared.webhooks).len() >= most {
            let problem = format!("there are {most} webhooks already");
            return Err(FarmError::Conflict { problem, remedy: "delete one first".to_owned() });
        }
        let id = name("wh")?;
        let webhook = Webhook { id, url, key: random_bytes()?.to_vec(), created: shared.clock.unix_milliseconds() };
        shared.store.insert_webhook(&webhook).await?;
        lock(&shared.webhooks).push(webhook.clone());
        Ok(webhook)
    }

    /// Deletes a webhook with all messages on their way to it.
    pub async fn delete_webhook(&self, id: &str) -> Result<(), FarmError> {
        let _turn = self.shared.members.take().await?;
        if !lock(&self.shared.webhooks).iter().any(|webhook| webhook.id == id) {
            return Err(FarmError::UnknownMember(format!("webhook \"{id}\"")));
        }
        Ok(self.shared.forget_webhook(id).await?)
    }
}

/// A name that no other thing has.
fn name(kind: &str) -> Result<String, FarmError> {
    let bytes = random_bytes()?;
    let digits: String = bytes[..12].iter().map(|byte| format!("{byte:02x}")).collect();
    Ok(format!("{kind}_{digits}"))
}

impl Shared {
    /// Stores what webhooks are to be told of a job that is in a new state.
    pub(super) async fn announce(&self, id: JobId, state: JobState) -> Result<(), StoreError> {
        let webhooks = lock(&self.webhooks).clone();
        let Ok(job) = self.job(id).map(|job| self.lock().status(&job, &self.clock)) else { return Ok(()) };
        let due = self.clock.unix_milliseconds();
        let body =
            json!({ "type": format!("job.{}", state.name()), "timestamp": rfc3339(due), "data": job }).to_string();
        for webhook in webhooks {
            let Ok(id) = name("msg") else { return Ok(()) };
            let message = Message { id, webhook: webhook.id, body: body.clone(), attempt: 0, due };
            self.store.put_message(&message).await?;
        }
        Ok(())
    }

    async fn forget_webhook(&self, id: &str) -> Result<(), StoreError> {
        self.store.delete_webhook(id).await?;
        lock(&self.webhooks).retain(|webhook| webhook.id != id);
        Ok(())
    }

    /// Sends a message, and stores what became of it.
    async fn deliver_message(&self, sender: &Sender, mut message: Message) -> Result<(), StoreError> {
        let webhook = lock(&self.webhooks).iter().find(|webhook| webhook.id == message.webhook).cloned();
        let Some(webhook) = webhook else { return self.store.delete_message(&message.id).await };
        match sender.send(&webhook, &message, self.clock.unix_milliseconds() / 1000).await {
            Sent::Taken => self.store.delete_message(&message.id).await,
            Sent::Gone => {
                tracing::info!(webhook = webhook.id, "nobody wants messages there any more");
                self.forget_webhook(&webhook.id).await
            }
            Sent::Failed(problem) => {
                tracing::debug!(webhook = webhook.id, problem, attempt = message.attempt, "a message was not taken");
                let Some(pause) = message.pause() else {
                    tracing::warn!(webhook = webhook.id, problem, "a message is given up");
                    return self.store.delete_message(&message.id).await;
                };
                message.attempt += 1;
                message.due = self.clock.unix_milliseconds() + pause.as_millis() as i64;
                self.store.put_message(&message).await
            }
        }
    }
}

/// Milliseconds since 1970 as people and programs read them.
fn rfc3339(milliseconds: i64) -> String {
    let time = OffsetDateTime::from_unix_timestamp(milliseconds / 1000).unwrap_or(OffsetDateTime::UNIX_EPOCH);
    time.format(&Rfc3339).unwrap_or_default()
}

/// Sends what is due, until the coordinator is stopped or dropped.
pub(super) async fn keep_announcing(shared: Weak<Shared>, stopped: CancellationToken) {
    let mut sender = None;
    while stopped.run_until_cancelled(sleep(LOOK)).await.is_some() {
        let Some(shared) = shared.upgrade() else { return };
        if lock(&shared.webhooks).is_empty() || shared.deposed.is_cancelled() {
            continue;
        }
        let due = shared.store.due_messages(shared.clock.unix_milliseconds(), AT_ONCE).await;
        let sender = sender.get_or_insert_with(Sender::new);
        let sent = due.map(|messages| messages.into_iter().map(|message| shared.deliver_message(sender, message)));
        let results = match sent {
            Ok(sent) => join_all(sent).await,
            Err(problem) => vec![Err(problem)],
        };
        for problem in results.into_iter().filter_map(Result::err) {
            tracing::debug!(%problem, "what became of a message cannot be stored");
        }
        drop::<Arc<Shared>>(shared);
    }
}
