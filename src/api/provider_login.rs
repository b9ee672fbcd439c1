//! Logging in to the page with an account at a provider (OpenID Connect).

use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{AppendHeaders, IntoResponse, Response};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::ApiState;
use super::extract::QueryValues;
use super::guard::cookie_named;
use super::json_answer::Json;
use super::problem::Problem;
use super::session;
use crate::farm::login::provider::{LoginError, Provider};

/// The cookie by which a browser shows that it began the login that it brings back.
const COOKIE: &str = "photonfarm_login";

/// Seconds for which it is kept.
const PATIENCE: u32 = 600;

/// How one logs in here.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub(crate) struct WaysToLogIn {
    /// The provider at whose page one may log in; left out where there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub provider: Option<String>,
}

/// What a browser brings back.
#[derive(Clone, Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
pub(crate) struct Return {
    /// What it was sent away with.
    pub state: String,
    /// What the provider gave it.
    pub code: Option<String>,
    /// Why the provider gave it nothing.
    pub error: Option<String>,
}

/// Tells how one logs in.
#[utoipa::path(get, path = "/session", tag = "users", responses((status = 200, description = "Ways to log in", body = WaysToLogIn)))]
pub(crate) async fn ways_to_log_in(State(state): State<ApiState>) -> Json<WaysToLogIn> {
    let provider = state.coordinator.login_provider().map(|provider| provider.options().issuer.clone());
    Json(WaysToLogIn { provider })
}

/// Sends a browser to the provider's page.
#[utoipa::path(
    get, path = "/session/provider", tag = "users",
    responses(
        (status = 303, description = "To the provider", headers(("Location" = String), ("Set-Cookie" = String))),
        (status = 404, description = "There is no provider", body = Problem, content_type = "application/problem+json"),
        (status = 429, description = "Too many log in", body = Problem, content_type = "application/problem+json"),
        (status = 502, description = "The provider does not answer", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn leave_for_provider(State(state): State<ApiState>) -> Result<Response, Problem> {
    let departure = provider(&state)?.begin().await?;
    let cookie = cookie(&state, &departure.state, PATIENCE);
    Ok((StatusCode::SEE_OTHER, [(header::LOCATION, departure.address), (header::SET_COOKIE, cookie)]).into_response())
}

/// Logs a page in that comes back from the provider.
#[utoipa::path(
    get, path = "/session/provider/return", tag = "users", params(Return),
    responses(
        (status = 303, description = "Logged in; to the page", headers(("Location" = String), ("Set-Cookie" = String))),
        (status = 400, description = "Something is missing", body = Problem, content_type = "application/problem+json"),
        (status = 403, description = "Not let in", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "There is no provider", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "The user has too many tokens", body = Problem, content_type = "application/problem+json"),
        (status = 429, description = "Too many log in", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Nobody needs to log in", body = Problem, content_type = "application/problem+json"),
        (status = 502, description = "The provider does not answer", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn return_from_provider(
    State(state): State<ApiState>,
    headers: HeaderMap,
    QueryValues(brought): QueryValues<Return>,
) -> Result<Response, Problem> {
    let provider = provider(&state)?;
    // A link that somebody else began would log this browser in as them.
    if cookie_named(&headers, COOKIE) != Some(brought.state.as_str()) {
        return Err(LoginError::NotBegun.into());
    }
    let code =
        brought.code.ok_or_else(|| LoginError::Refused(brought.error.unwrap_or_else(|| "no code".to_owned())))?;
    let name = provider.finish(&brought.state, code).await?;
    let new = state.coordinator.log_in_as(&name, session::DAYS).await?;
    let cookies = AppendHeaders([
        (header::SET_COOKIE, session::cookie_for(new.secret.reveal(), state.coordinator.is_encrypted())),
        (header::SET_COOKIE, cookie(&state, "", 0)),
    ]);
    Ok((StatusCode::SEE_OTHER, [(header::LOCATION, "/")], cookies).into_response())
}

#[expect(clippy::result_large_err, reason = "made at most once a request")]
fn provider(state: &ApiState) -> Result<&Provider, Problem> {
    let none = || Problem::new(StatusCode::NOT_FOUND, "no-provider", "logins by a provider are not set up");
    state.coordinator.login_provider().ok_or_else(none)
}

/// It has to come along when the provider sends the browser back, so it is not `Strict`.
fn cookie(state: &ApiState, value: &str, seconds: u32) -> String {
    let secure = if state.coordinator.is_encrypted() { "; Secure" } else { "" };
    format!("{COOKIE}={value}; Path=/v1/session; HttpOnly; SameSite=Lax; Max-Age={seconds}{secure}")
}

impl From<LoginError> for Problem {
    fn from(error: LoginError) -> Self {
        let (status, slug, remedy) = match error {
            LoginError::BadAddress { .. } | LoginError::Provider(_) => {
                (StatusCode::BAD_GATEWAY, "provider-fails", "try again, or log in with a token")
            }
            LoginError::Busy => (StatusCode::TOO_MANY_REQUESTS, "busy", "try again in a few seconds"),
            LoginError::NotBegun | LoginError::Refused(_) => {
                (StatusCode::FORBIDDEN, "login-refused", "begin again at the coordinator's page")
            }
            LoginError::NoName(_) => {
                (StatusCode::FORBIDDEN, "login-refused", "ask an admin of the farm which accounts are known here")
            }
        };
        tracing::info!(problem = %error, "a login by the provider is refused");
        Self::new(status, slug, error.to_string()).remedy(remedy)
    }
}
