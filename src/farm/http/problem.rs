//! Error answers of the workers' protocol: a status and plain text.

use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};

use crate::farm::access::caller::Denied;
use crate::farm::error::FarmError;
use crate::farm::wire::WireError;

/// A problem as the worker reads it.
pub(super) struct Problem {
    status: StatusCode,
    text: String,
}

impl Problem {
    pub(super) fn new(status: StatusCode, text: impl Into<String>) -> Self {
        Self { status, text: text.into() }
    }

    /// The worker must register first.
    pub(super) fn unknown_worker() -> Self {
        Self::new(StatusCode::GONE, "this worker is not registered; register again")
    }

    /// Whoever asks may not join.
    pub(super) fn denied(denied: &Denied) -> Self {
        let status = match denied {
            Denied::NoToken | Denied::UnknownToken => StatusCode::UNAUTHORIZED,
            Denied::Scope { .. } | Denied::UnknownAccount { .. } | Denied::NotYours { .. } => StatusCode::FORBIDDEN,
        };
        Self::new(status, format!("{denied}; give this worker a token that was made for workers with --token-file"))
    }
}

impl From<FarmError> for Problem {
    fn from(error: FarmError) -> Self {
        let status = match error {
            FarmError::Denied(_) => StatusCode::FORBIDDEN,
            FarmError::UnknownScene(_) | FarmError::UnknownJob(_) | FarmError::NoPictureYet(_) => StatusCode::NOT_FOUND,
            FarmError::TooLarge { .. } => StatusCode::PAYLOAD_TOO_LARGE,
            FarmError::ShuttingDown | FarmError::Busy { .. } | FarmError::NotYet { .. } | FarmError::Store { .. } => {
                StatusCode::SERVICE_UNAVAILABLE
            }
            FarmError::Internal(_) => StatusCode::INTERNAL_SERVER_ERROR,
            _ => StatusCode::BAD_REQUEST,
        };
        Self::new(status, error.to_string())
    }
}

impl From<WireError> for Problem {
    fn from(error: WireError) -> Self {
        Self::new(StatusCode::BAD_REQUEST, error.to_string())
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        (self.status, self.text).into_response()
    }
}
