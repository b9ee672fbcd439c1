//! Path, query and body of a request. They do what axum's extractors of similar names do, and answer errors as
//! [`Problem`]s.

use axum::body::Bytes;
use axum::extract::{FromRequest, FromRequestParts, Path, Query, Request};
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::http::request::Parts;
use serde::de::DeserializeOwned;

use super::problem::Problem;
use super::unique_keys::UniqueKeys;
use crate::farm::ids::{BadJobId, BadSequenceId, JobId, SequenceId};

/// A JSON body.
pub(crate) struct JsonBody<T>(pub T);

/// Any body as it came.
pub(crate) struct RawBody(pub Bytes);

/// A value in the address.
pub(crate) struct PathValue<T>(pub T);

/// The values after the `?`.
pub(crate) struct QueryValues<T>(pub T);

// Not by way of axum's `Json`, whose errors do not give the line and the column.
impl<S: Send + Sync, T: DeserializeOwned> FromRequest<S> for JsonBody<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, state: &S) -> Result<Self, Problem> {
        let content_type = request.headers().get(CONTENT_TYPE).and_then(|value| value.to_str().ok()).unwrap_or("");
        let media_type = content_type.split(';').next().unwrap_or("").trim();
        if !media_type.eq_ignore_ascii_case("application/json") {
            return Err(Problem::unsupported_media_type(media_type));
        }
        let RawBody(bytes) = RawBody::from_request(request, state).await?;
        // Derived readers take lists for structures, too.
        if bytes.iter().find(|byte| !byte.is_ascii_whitespace()).is_some_and(|byte| b"[\"".contains(byte)) {
            let detail = "the body is a JSON list or text where an object is expected";
            return Err(Problem::new(StatusCode::BAD_REQUEST, "bad-json", detail).remedy("send {\"name\": value, …}"));
        }
        serde_json::from_slice::<UniqueKeys>(&bytes).map_err(|error| match error.is_data() {
            true => Problem::from(error).remedy("give it once"),
            false => Problem::from(error),
        })?;
        Ok(Self(serde_json::from_slice(&bytes).map_err(Problem::from)?))
    }
}

impl<S: Send + Sync> FromRequest<S> for RawBody {
    type Rejection = Problem;

    async fn from_request(request: Request, state: &S) -> Result<Self, Problem> {
        Ok(Self(Bytes::from_request(request, state).await?))
    }
}

impl<S: Send + Sync, T: DeserializeOwned + Send> FromRequestParts<S> for PathValue<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        Ok(Self(Path::from_request_parts(parts, state).await?.0))
    }
}

impl<S: Send + Sync, T: DeserializeOwned> FromRequestParts<S> for QueryValues<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        Ok(Self(Query::from_request_parts(parts, state).await?.0))
    }
}

/// A job's id in the address; a text that cannot be one is no job.
#[expect(clippy::result_large_err, reason = "made at most once a request")]
pub(crate) fn parse_job(text: &str) -> Result<JobId, Problem> {
    text.parse().map_err(|BadJobId(text)| Problem::unknown_job(&text))
}

/// A sequence's id in the address or in a query.
#[expect(clippy::result_large_err, reason = "made at most once a request")]
pub(crate) fn parse_sequence(text: &str) -> Result<SequenceId, Problem> {
    text.parse().map_err(|problem: BadSequenceId| {
        Problem::new(StatusCode::NOT_FOUND, "unknown-sequence", format!("there is no sequence \"{}\"", problem.0))
            .remedy("see GET /v1/sequences for those there are")
    })
}
