//! Who may use which endpoint. Everything under `/v1` but logging in is behind one of these.

use axum::Extension;
use axum::extract::{FromRequestParts, Request, State};
use axum::http::request::Parts;
use axum::http::{HeaderMap, Method, header};
use axum::middleware::Next;
use axum::response::Response;

use super::ApiState;
use super::extract::{PathValue, parse_job, parse_sequence};
use super::problem::Problem;
use crate::farm::access::caller::Caller;
use crate::farm::access::scope::Scope;
use crate::farm::http::bearer::{bearer, text};
use crate::farm::ids::{JobId, SequenceId};

/// The cookie by which the page stays logged in. Its value is a token.
pub(crate) const COOKIE: &str = "photonfarm_session";

/// For what everybody may look at, and those who submit may change.
pub(crate) async fn read_or_submit(
    State(state): State<ApiState>,
    request: Request,
    next: Next,
) -> Result<Response, Problem> {
    let is_reading = [Method::GET, Method::HEAD].contains(request.method());
    pass(&state, if is_reading { Scope::Read } else { Scope::Submit }, request, next).await
}

/// For what every user may do.
pub(crate) async fn users(State(state): State<ApiState>, request: Request, next: Next) -> Result<Response, Problem> {
    pass(&state, Scope::Read, request, next).await
}

/// For what only admins may do.
pub(crate) async fn admins(State(state): State<ApiState>, request: Request, next: Next) -> Result<Response, Problem> {
    pass(&state, Scope::Admin, request, next).await
}

/// Lets a request pass with its [`Caller`] as an extension.
async fn pass(state: &ApiState, needed: Scope, mut request: Request, next: Next) -> Result<Response, Problem> {
    let caller = state.coordinator.caller(token(request.headers()))?;
    caller.require(needed)?;
    request.extensions_mut().insert(caller);
    Ok(next.run(request).await)
}

/// The token of a request: its own, or the one in the page's cookie.
pub(crate) fn token(headers: &HeaderMap) -> Option<&str> {
    bearer(headers).or_else(|| session(headers))
}

/// The token in the page's cookie.
pub(crate) fn session(headers: &HeaderMap) -> Option<&str> {
    cookie_named(headers, COOKIE)
}

/// What a cookie holds.
pub(crate) fn cookie_named<'a>(headers: &'a HeaderMap, wanted: &str) -> Option<&'a str> {
    let cookies = text(headers, header::COOKIE)?.split(';').filter_map(|cookie| cookie.trim().split_once('='));
    cookies.into_iter().find(|(name, _)| *name == wanted).map(|(_, value)| value)
}

/// The job in the address, which the caller may change: it is their own, or they are an admin.
pub(crate) struct OwnJob(pub JobId);

/// The sequence in the address, which the caller may change.
pub(crate) struct OwnSequence(pub SequenceId);

/// What a request's address names, and who sends it.
async fn named(parts: &mut Parts, state: &ApiState) -> Result<(String, Caller), Problem> {
    let PathValue(id) = PathValue::<String>::from_request_parts(parts, state).await?;
    let Extension(caller) =
        Extension::<Caller>::from_request_parts(parts, state).await.map_err(Problem::of_extension)?;
    Ok((id, caller))
}

impl FromRequestParts<ApiState> for OwnJob {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &ApiState) -> Result<Self, Problem> {
        let (id, caller) = named(parts, state).await?;
        let id = parse_job(&id)?;
        state.coordinator.check_owner(&caller, id)?;
        Ok(Self(id))
    }
}

impl FromRequestParts<ApiState> for OwnSequence {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &ApiState) -> Result<Self, Problem> {
        let (id, caller) = named(parts, state).await?;
        let id = parse_sequence(&id)?;
        state.coordinator.check_sequence_owner(&caller, id)?;
        Ok(Self(id))
    }
}
