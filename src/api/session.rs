//! Who one is, and how a page stays logged in: by a cookie that scripts cannot read and other sites cannot use.

use axum::Extension;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::ApiState;
use super::extract::JsonBody;
use super::guard::{COOKIE, session};
use super::json_answer::Json;
use super::problem::Problem;
use crate::farm::access::caller::Caller;
use crate::farm::access::scope::Scope;
use crate::farm::access::user::UserName;

/// Days for which a page stays logged in.
pub(super) const DAYS: u16 = 7;

/// Who sent the request.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(crate) struct Me {
    /// Their name; left out while the coordinator has no users, and anyone may do everything.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub user: Option<UserName>,
    /// What they may do.
    pub scope: Scope,
}

impl From<&Caller> for Me {
    fn from(caller: &Caller) -> Self {
        Self { user: caller.name().cloned(), scope: caller.scope() }
    }
}

/// Somebody who wants to log in.
#[derive(Clone, Debug, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Login {
    /// A token of theirs.
    pub token: String,
}

/// Tells who one is.
#[utoipa::path(get, path = "/me", tag = "users", responses((status = 200, description = "Who sent the request", body = Me)))]
pub(crate) async fn who_am_i(Extension(caller): Extension<Caller>) -> Json<Me> {
    Json(Me::from(&caller))
}

/// Logs a page in for seven days: the answer sets a cookie, which ends with the token.
#[utoipa::path(
    post, path = "/session", tag = "users", request_body = Login,
    responses(
        (status = 200, description = "Logged in", body = Me, headers(("Set-Cookie" = String))),
        (status = 400, description = "Not JSON", body = Problem, content_type = "application/problem+json"),
        (status = 401, description = "The token is unknown", body = Problem, content_type = "application/problem+json"),
        (status = 415, description = "Not said to be JSON", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Nobody needs to log in", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn log_in(
    State(state): State<ApiState>,
    JsonBody(login): JsonBody<Login>,
) -> Result<Response, Problem> {
    let caller = state.coordinator.caller(Some(&login.token))?;
    let new = state.coordinator.log_in(&caller, DAYS).await?;
    let cookie = cookie_for(new.secret.reveal(), state.coordinator.is_encrypted());
    Ok(([(header::SET_COOKIE, cookie)], Json(Me::from(&caller))).into_response())
}

/// Logs a page out.
#[utoipa::path(delete, path = "/session", tag = "users", responses((status = 204, description = "Logged out")))]
pub(crate) async fn log_out(State(state): State<ApiState>, headers: HeaderMap) -> Result<Response, Problem> {
    let caller = state.coordinator.caller(session(&headers))?;
    state.coordinator.log_out(&caller).await?;
    let cookie = cookie("", 0, state.coordinator.is_encrypted());
    Ok((StatusCode::NO_CONTENT, [(header::SET_COOKIE, cookie)]).into_response())
}

/// The cookie of a page that is logged in by the token `secret`.
pub(super) fn cookie_for(secret: &str, is_encrypted: bool) -> String {
    cookie(secret, u64::from(DAYS) * 86_400, is_encrypted)
}

fn cookie(value: &str, seconds: u64, is_encrypted: bool) -> String {
    let secure = if is_encrypted { "; Secure" } else { "" };
    format!("{COOKIE}={value}; Path=/; HttpOnly; SameSite=Strict; Max-Age={seconds}{secure}")
}
