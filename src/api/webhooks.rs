//! Webhooks: programs that are told when a job changes its state.

use axum::extract::State;
use axum::http::{StatusCode, Uri};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::ApiState;
use super::extract::{JsonBody, PathValue};
use super::json_answer::Json;
use super::problem::Problem;
use crate::farm::webhooks::signature::key_text;
use crate::farm::webhooks::webhook::Webhook;

/// Bytes of an address at most.
const LONGEST: usize = 2000;

/// A webhook to be added.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct NewWebhook {
    /// Where messages are sent by POST, `https://…` or `http://…`.
    pub url: String,
}

/// A webhook without its key.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub(crate) struct WebhookView {
    /// What to call it.
    pub id: String,
    /// Where messages are sent.
    pub url: String,
    /// When it was added, milliseconds since 1970.
    pub created: i64,
}

/// A new webhook. Its key is shown this once.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub(crate) struct AddedWebhook {
    /// What is known of it.
    #[serde(flatten)]
    pub webhook: WebhookView,
    /// Signs the messages, as Standard Webhooks write it.
    pub key: String,
}

/// All webhooks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub(crate) struct WebhookList {
    /// Oldest first.
    pub webhooks: Vec<WebhookView>,
}

impl From<Webhook> for WebhookView {
    fn from(webhook: Webhook) -> Self {
        let Webhook { id, url, created, .. } = webhook;
        Self { id, url, created }
    }
}

/// Lists all webhooks. For admins.
#[utoipa::path(
    get, path = "/webhooks", tag = "webhooks",
    responses((status = 200, description = "All webhooks, oldest first", body = WebhookList))
)]
pub(crate) async fn list_webhooks(State(state): State<ApiState>) -> Json<WebhookList> {
    Json(WebhookList { webhooks: state.coordinator.webhooks().into_iter().map(WebhookView::from).collect() })
}

/// Adds a webhook. It is told of every job that changes its state, by messages `job.STATE` with the job's status, signed as Standard Webhooks
/// describe it, and sent again for three days until they are taken. For admins: the coordinator sends requests to any address.
#[utoipa::path(
    post, path = "/webhooks", tag = "webhooks", request_body = NewWebhook,
    responses(
        (status = 201, description = "Added; the key is shown this once", body = AddedWebhook),
        (status = 400, description = "Not JSON", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "There are too many", body = Problem, content_type = "application/problem+json"),
        (status = 415, description = "Not said to be JSON", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Not an address", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn add_webhook(
    State(state): State<ApiState>,
    JsonBody(new): JsonBody<NewWebhook>,
) -> Result<(StatusCode, Json<AddedWebhook>), Problem> {
    let address = new.url.parse::<Uri>().ok().filter(|_| new.url.len() <= LONGEST);
    let is_address = address.is_some_and(|uri| {
        matches!(uri.scheme_str(), Some("http" | "https")) && uri.host().is_some_and(|host| !host.is_empty())
    });
    if !is_address {
        let detail = "url is not an address that messages can be sent to";
        return Err(Problem::bad_request(detail, "give http:// or https://, a host and a path"));
    }
    let webhook = state.coordinator.add_webhook(new.url).await?;
    let key = key_text(&webhook.key);
    Ok((StatusCode::CREATED, Json(AddedWebhook { webhook: webhook.into(), key })))
}

/// Deletes a webhook with all messages on their way to it. For admins.
#[utoipa::path(
    delete, path = "/webhooks/{id}", tag = "webhooks",
    params(("id" = String, Path, description = "The webhook's id")),
    responses(
        (status = 204, description = "It is told nothing any more"),
        (status = 404, description = "No such webhook", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn delete_webhook(
    State(state): State<ApiState>,
    PathValue(id): PathValue<String>,
) -> Result<StatusCode, Problem> {
    state.coordinator.delete_webhook(&id).await?;
    Ok(StatusCode::NO_CONTENT)
}
