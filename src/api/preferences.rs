//! What a program says beside its request: by which key to know it again (`Idempotency-Key`), how long to wait for an end (`Prefer: wait`, RFC
//! 7240), and which version it means to change (`If-Match`).

use std::time::Duration;

use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use tokio::time::timeout;

use super::ApiState;
use super::jobs::JobView;
use super::problem::Problem;
use crate::farm::http::bearer::text;
use crate::farm::ids::JobId;
use crate::farm::job::{IdempotencyKey, JobStatus};

/// The longest wait, so that proxies do not cut it.
const LONGEST_WAIT: u64 = 60;

/// What a program says beside its request.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Preferences {
    /// By what to know the request again.
    pub key: Option<IdempotencyKey>,
    /// How long to wait until a job has ended.
    pub wait: Option<Duration>,
}

impl<S: Send + Sync> FromRequestParts<S> for Preferences {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Problem> {
        let headers = &parts.headers;
        let key = headers.get("idempotency-key").map(|value| value.to_str().unwrap_or_default().parse());
        let key = key.transpose().map_err(|bad: crate::farm::job::BadIdempotencyKey| {
            Problem::new(StatusCode::BAD_REQUEST, "bad-header", bad.to_string()).remedy("correct Idempotency-Key")
        })?;
        Ok(Self { key, wait: wait(headers) })
    }
}

/// Preferences that are not understood are passed over, as RFC 7240 has it.
fn wait(headers: &HeaderMap) -> Option<Duration> {
    let values = headers.get_all("prefer").iter().filter_map(|value| value.to_str().ok());
    let preferences = values.flat_map(|value| value.split(',')).filter_map(|preference| preference.split_once('='));
    let mut waits = preferences.filter(|(name, _)| name.trim().eq_ignore_ascii_case("wait"));
    let seconds: u64 = waits.next()?.1.trim().trim_matches('"').parse().ok()?;
    Some(Duration::from_secs(seconds.min(LONGEST_WAIT)))
}

impl Preferences {
    /// A job when it has ended, or when the wait is over.
    pub(crate) async fn wait_for(&self, state: &ApiState, id: JobId) -> Result<JobStatus, Problem> {
        if let Some(wait) = self.wait {
            let mut watched = state.coordinator.watch(id)?;
            let ended = timeout(wait, watched.wait_for(|status| status.state.is_final()));
            // Whether it ended or not, how it is now is answered.
            let _ = state.shutdown.run_until_cancelled(ended).await;
        }
        Ok(state.coordinator.job(id)?)
    }

    /// A job as an answer, which says what of this was done and which version it is.
    pub(crate) fn answer(&self, status: StatusCode, job: JobStatus) -> Response {
        let tag = version(&job);
        let mut response = (status, super::json_answer::Json(JobView::from(job))).into_response();
        let headers = response.headers_mut();
        if let Ok(tag) = HeaderValue::from_str(&tag) {
            headers.insert(header::ETAG, tag);
        }
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
        if let Some(applied) = self.wait.and_then(|wait| HeaderValue::try_from(format!("wait={}", wait.as_secs())).ok())
        {
            headers.insert(HeaderName::from_static("preference-applied"), applied);
        }
        response
    }
}

/// The version of what users may change of a job, as an ETag. Progress does not change it.
fn version(job: &JobStatus) -> String {
    let JobStatus { id, name, tags, priority, stop, .. } = job;
    let text = serde_json::json!([id, name, tags, priority, stop]).to_string();
    format!("\"{}\"", &blake3::hash(text.as_bytes()).to_hex()[..32])
}

/// Whether a request means to change the version that there is.
pub(crate) fn is_version_meant(job: &JobStatus, headers: &HeaderMap) -> bool {
    let Some(wanted) = text(headers, header::IF_MATCH) else { return true };
    let version = version(job);
    wanted.split(',').map(str::trim).any(|tag| tag == "*" || tag == version)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waits_are_read_and_bounded() {
        let read = |value: &'static str| {
            wait(&HeaderMap::from_iter([(HeaderName::from_static("prefer"), HeaderValue::from_static(value))]))
        };
        assert_eq!(read("wait=5"), Some(Duration::from_secs(5)));
        assert_eq!(read("respond-async, Wait = \"7\""), Some(Duration::from_secs(7)));
        assert_eq!(read("wait=100000"), Some(Duration::from_secs(LONGEST_WAIT)));
        assert_eq!([read("wait"), read("wait=x"), read("handling=strict")], [None, None, None]);
    }
}
