//! The OpenAPI description, generated from the handlers.

use std::sync::Arc;

use axum::http::header;
use axum::routing::get;
use axum::{Router, response::IntoResponse};
use utoipa::OpenApi;
use utoipa::openapi::{ContentBuilder, Ref, ResponseBuilder};

/// What the handlers themselves cannot say.
#[derive(OpenApi)]
#[openapi(info(
    title = "photonfarm",
    description = "A distributed progressive-photon-mapping render service. Errors are application/problem+json.",
))]
pub(crate) struct Description;

/// Says of every endpoint that any other answer is a problem: a coordinator that stops, a store that is full, a fault of ours.
pub(crate) fn with_problems(mut description: utoipa::openapi::OpenApi) -> utoipa::openapi::OpenApi {
    let content = ContentBuilder::new().schema(Some(Ref::from_schema_name("Problem"))).build();
    let problem = ResponseBuilder::new()
        .description("Another problem: 429 and 503 with Retry-After when it may succeed later, 500 for a fault of the coordinator")
        .content("application/problem+json", content)
        .build();
    for item in description.paths.paths.values_mut() {
        let methods = [&mut item.get, &mut item.post, &mut item.patch, &mut item.delete, &mut item.put];
        for operation in methods.into_iter().flatten() {
            operation.responses.responses.insert("default".to_owned(), problem.clone().into());
        }
    }
    description
}

/// Serves `description` at `/openapi.json` and `/v1/openapi.json`.
pub(crate) fn routes(description: utoipa::openapi::OpenApi) -> Router {
    let text: Arc<str> = (serde_json::to_string_pretty(&description).unwrap_or_default() + "\n").into();
    let answer = move || {
        let text = text.to_string();
        async move { ([(header::CONTENT_TYPE, "application/json")], text).into_response() }
    };
    Router::new().route("/openapi.json", get(answer.clone())).route("/v1/openapi.json", get(answer))
}
