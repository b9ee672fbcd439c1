//! Every error answer of the API: `application/problem+json` (RFC 9457) with the remedy and, where there is one, the
//! place in what the user sent.

use std::time::Duration;

use axum::extract::rejection::{BytesRejection, ExtensionRejection, PathRejection, QueryRejection};
use axum::http::{HeaderValue, Method, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::farm::FarmError;
use crate::farm::access::caller::Denied;
use crate::farm::http::server::fell_silent;
use crate::farm::http::visitor::Stranger;
use crate::method::MethodError;
use crate::scene::error::SceneError;

/// Why a request was not met.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub(crate) struct Problem {
    /// What kind of problem, as `urn:photonfarm:problem:…`; stays the same between versions.
    #[serde(rename = "type")]
    pub kind: String,
    /// The kind in words.
    pub title: String,
    /// The HTTP status.
    pub status: u16,
    /// What is wrong with this request.
    pub detail: String,
    /// What to do about it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
    /// Where it stands in what was sent: file, line and path of a scene, or line and column of a JSON body.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// Seconds after which the same request may succeed; also in the header `Retry-After`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub retry_after: Option<u64>,
}

impl Problem {
    /// A problem of the kind `urn:photonfarm:problem:{slug}`, titled by the slug's words.
    pub(crate) fn new(status: StatusCode, slug: &str, detail: impl Into<String>) -> Self {
        Self {
            kind: format!("urn:photonfarm:problem:{slug}"),
            title: slug.replace('-', " "),
            status: status.as_u16(),
            detail: detail.into(),
            remedy: None,
            place: None,
            retry_after: None,
        }
    }

    /// The same with a remedy; an empty one is none.
    pub(crate) fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = Some(remedy.into()).filter(|remedy| !remedy.is_empty());
        self
    }

    /// The same with a place.
    pub(crate) fn place(mut self, place: impl Into<String>) -> Self {
        self.place = Some(place.into()).filter(|place| !place.is_empty());
        self
    }

    /// Something in a request that has the right form but an impossible value.
    pub(crate) fn bad_request(detail: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, "bad-request", detail).remedy(remedy)
    }

    /// A body that ends too early, or whose bytes stopped coming.
    pub(crate) fn of_body(problem: &(dyn std::error::Error + 'static)) -> Self {
        let (status, slug) = if fell_silent(problem) {
            (StatusCode::REQUEST_TIMEOUT, "silent-body")
        } else {
            (StatusCode::BAD_REQUEST, "broken-body")
        };
        Self::new(status, slug, problem.to_string()).remedy("send the request again")
    }

    /// An endpoint that is not behind a guard, by a mistake of ours.
    pub(crate) fn of_extension(rejection: ExtensionRejection) -> Self {
        Self::from(FarmError::Internal(rejection.body_text()))
    }

    /// No job has this id.
    pub(crate) fn unknown_job(id: &str) -> Self {
        Self::new(StatusCode::NOT_FOUND, "unknown-job", format!("there is no job \"{id}\""))
            .remedy("see GET /v1/jobs for the jobs there are")
    }

    /// The same with the time after which the request may be repeated.
    pub(crate) fn retry_after(mut self, pause: Duration) -> Self {
        self.retry_after = Some(pause.as_secs().max(1));
        self
    }

    /// A body that should be JSON and is not said to be.
    pub(crate) fn unsupported_media_type(media_type: &str) -> Self {
        let detail = format!("the body is said to be \"{media_type}\" where JSON is expected");
        Self::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, "unsupported-media-type", detail)
            .remedy("send JSON with the header Content-Type: application/json")
    }

    /// The last word of the kind, for example `unknown-job`.
    pub(crate) fn slug(&self) -> &str {
        self.kind.rsplit(':').next().unwrap_or_default()
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let mut response = (status, super::json_answer::Json(&self)).into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        if status == StatusCode::UNAUTHORIZED {
            headers.insert(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"));
        }
        if let Some(seconds) = self.retry_after {
            headers.insert(header::RETRY_AFTER, HeaderValue::from(seconds));
        }
        response
    }
}

impl From<FarmError> for Problem {
    fn from(error: FarmError) -> Self {
        let detail = error.to_string();
        match error {
            FarmError::UnknownScene(_) => {
                Self::new(StatusCode::NOT_FOUND, "unknown-scene", detail).remedy("upload it with POST /v1/scenes")
            }
            FarmError::UnknownWorker(_) => Self::new(StatusCode::NOT_FOUND, "unknown-worker", detail)
                .remedy("see GET /v1/workers for the workers there are; one that came back has a new number"),
            FarmError::UnknownMember(_) => Self::new(StatusCode::NOT_FOUND, "unknown-member", detail)
                .remedy("list users, tokens or webhooks for those there are"),
            FarmError::Denied(denied) => denied.into(),
            FarmError::UnknownJob(id) => Self::unknown_job(&id.to_string()),
            FarmError::UnknownSequence(_) => Self::new(StatusCode::NOT_FOUND, "unknown-sequence", detail)
                .remedy("see GET /v1/sequences for those there are"),
            FarmError::BadFrames(problem) => Self::bad_request(problem.to_string(), problem.remedy()),
            FarmError::BadScene(error) => Self::from(error),
            FarmError::BadMethod(error) => Self::from(error),
            FarmError::BadRequest { problem, remedy } => Self::bad_request(problem, remedy),
            FarmError::NoPictureYet(_) => Self::new(StatusCode::NOT_FOUND, "no-picture-yet", detail)
                .remedy("ask again, or follow the job's events")
                .retry_after(Duration::from_secs(1)),
            FarmError::CannotDenoise(_) => Self::new(StatusCode::CONFLICT, "cannot-denoise", detail)
                .remedy("ask again after more passes, or for the picture as it is"),
            FarmError::TooLarge { .. } => {
                Self::new(StatusCode::PAYLOAD_TOO_LARGE, "too-large", detail).remedy("send less, or make it smaller")
            }
            FarmError::Busy { problem, retry_after } => Self::new(StatusCode::TOO_MANY_REQUESTS, "busy", problem)
                .remedy("try again later")
                .retry_after(retry_after),
            FarmError::NotYet { problem, retry_after } => {
                Self::new(StatusCode::SERVICE_UNAVAILABLE, "not-yet", problem)
                    .remedy("ask again; a worker has to be there")
                    .retry_after(retry_after)
            }
            FarmError::Conflict { problem, remedy } => {
                Self::new(StatusCode::CONFLICT, "conflict", problem).remedy(remedy)
            }
            FarmError::ChangedSince(job) => {
                Self::new(StatusCode::PRECONDITION_FAILED, "changed-since", format!("job {job} was changed since"))
                    .remedy("get it again, and then change it")
            }
            FarmError::Lost { problem } => Self::new(StatusCode::INTERNAL_SERVER_ERROR, "lost", problem)
                .remedy("restore the store from a backup, or upload and submit again"),
            FarmError::Store { problem } => Self::new(StatusCode::SERVICE_UNAVAILABLE, "store-fails", problem)
                .remedy("make room, or wait until the store works again")
                .retry_after(Duration::from_secs(5)),
            FarmError::ShuttingDown => {
                Self::new(StatusCode::SERVICE_UNAVAILABLE, "shutting-down", detail).retry_after(Duration::from_secs(1))
            }
            FarmError::Internal(_) => {
                tracing::error!(%detail, "a request failed");
                Self::new(StatusCode::INTERNAL_SERVER_ERROR, "internal-fault", detail)
                    .remedy("look at the coordinator's log")
            }
        }
    }
}

impl From<Denied> for Problem {
    fn from(denied: Denied) -> Self {
        let (status, slug) = match denied {
            Denied::NoToken => (StatusCode::UNAUTHORIZED, "no-token"),
            Denied::UnknownToken => (StatusCode::UNAUTHORIZED, "unknown-token"),
            Denied::Scope { .. } => (StatusCode::FORBIDDEN, "not-allowed"),
            Denied::UnknownAccount { .. } => (StatusCode::FORBIDDEN, "unknown-account"),
            Denied::NotYours { .. } => (StatusCode::FORBIDDEN, "not-yours"),
        };
        Self::new(status, slug, denied.to_string()).remedy(denied.remedy())
    }
}

impl From<Stranger> for Problem {
    fn from(stranger: Stranger) -> Self {
        let slug = match stranger {
            Stranger::Host(_) => "foreign-host",
            Stranger::Origin(_) => "foreign-origin",
        };
        Self::new(StatusCode::FORBIDDEN, slug, stranger.to_string()).remedy(stranger.remedy())
    }
}

impl From<SceneError> for Problem {
    fn from(error: SceneError) -> Self {
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, "bad-scene", error.problem)
            .remedy(error.remedy)
            .place(error.location.to_string())
    }
}

impl From<MethodError> for Problem {
    fn from(error: MethodError) -> Self {
        let problem = |detail: String| Self::new(StatusCode::UNPROCESSABLE_ENTITY, "bad-method", detail);
        match error {
            MethodError::Unknown { name, remedy } => problem(format!("there is no method \"{name}\"")).remedy(remedy),
            MethodError::Parameter { method, problem: what, remedy } => {
                problem(format!("method \"{method}\": {what}")).remedy(remedy)
            }
            MethodError::LightGroups { problem: what, remedy } => {
                problem(format!("light groups cannot be kept apart: {what}")).remedy(remedy)
            }
        }
    }
}

impl From<serde_json::Error> for Problem {
    fn from(error: serde_json::Error) -> Self {
        let (line, column, text) = (error.line(), error.column(), error.to_string());
        // The place has a field of its own.
        let detail = text.strip_suffix(&format!(" at line {line} column {column}")).unwrap_or(&text);
        let problem = if error.is_data() {
            Self::bad_request(detail, "see /v1/openapi.json for what may be sent")
        } else {
            Self::new(StatusCode::BAD_REQUEST, "bad-json", detail).remedy("correct the JSON at that place")
        };
        problem.place(format!("line {line}, column {column}"))
    }
}

impl From<BytesRejection> for Problem {
    fn from(rejection: BytesRejection) -> Self {
        let status = rejection.status();
        if status == StatusCode::PAYLOAD_TOO_LARGE {
            return Self::new(status, "too-large", "the body has more bytes than are accepted")
                .remedy("see limits in GET /v1/limits; upload large scenes with POST /v1/scenes");
        }
        Self::of_body(&rejection)
    }
}

impl From<PathRejection> for Problem {
    fn from(rejection: PathRejection) -> Self {
        Self::new(rejection.status(), "bad-path", rejection.body_text()).remedy("correct the address")
    }
}

impl From<QueryRejection> for Problem {
    fn from(rejection: QueryRejection) -> Self {
        let remedy = "see /v1/openapi.json for the parameters there are";
        Self::new(rejection.status(), "bad-query", rejection.body_text()).remedy(remedy)
    }
}

/// The answer to an address that does not exist.
pub(crate) async fn not_found(uri: Uri) -> Problem {
    Problem::new(StatusCode::NOT_FOUND, "unknown-address", format!("there is nothing at {}", uri.path()))
        .remedy("see /v1/openapi.json for the addresses there are")
}

/// The answer to an address that exists but not for this HTTP method.
pub(crate) async fn method_not_allowed(method: Method, uri: Uri) -> Problem {
    let detail = format!("{} does not take {method}", uri.path());
    Problem::new(StatusCode::METHOD_NOT_ALLOWED, "method-not-allowed", detail)
        .remedy("use a method that the header Allow names")
}
