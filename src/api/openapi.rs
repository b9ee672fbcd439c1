//! The OpenAPI description, generated from the handlers.

use std::sync::Arc;

use axum::http::header;
use axum::routing::get;
use axum::{Router, response::IntoResponse};
use utoipa::OpenApi;

/// What the handlers themselves cannot say.
#[derive(OpenApi)]
#[openapi(info(
    title = "photonfarm",
    description = "A distributed progressive-photon-mapping render service. Errors are application/problem+json.",
))]
pub struct Description;

/// Serves `description` at `/openapi.json` and `/v1/openapi.json`.
pub fn routes(description: utoipa::openapi::OpenApi) -> Router {
    let text: Arc<str> = serde_json::to_string_pretty(&description).unwrap_or_default().into();
    let answer = move || {
        let text = text.to_string();
        async move { ([(header::CONTENT_TYPE, "application/json")], text).into_response() }
    };
    Router::new().route("/openapi.json", get(answer.clone())).route("/v1/openapi.json", get(answer))
}
