//! Users and tokens.

use axum::Extension;
use axum::extract::State;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::ApiState;
use super::extract::{JsonBody, PathValue};
use super::json_answer::Json;
use super::problem::Problem;
use crate::farm::access::caller::Caller;
use crate::farm::access::scope::Role;
use crate::farm::access::token::TokenView;
use crate::farm::access::user::{BadUserName, User, UserName};
use crate::farm::coordinator::tokens::{NewToken, TokenRequest};

/// A user to be added.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct NewUser {
    /// How they are called.
    pub name: UserName,
    /// What they are.
    pub role: Role,
}

/// What of a user may change.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct UserPatch {
    /// What they are from now on.
    pub role: Role,
}

/// A user with a first token.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub(crate) struct AddedUser {
    /// The user.
    pub user: User,
    /// Their first token.
    pub token: IssuedToken,
}

/// A new token. Its secret is shown this once.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub(crate) struct IssuedToken {
    /// What to send as `Authorization: Bearer SECRET`.
    pub secret: String,
    /// What is known of it.
    #[serde(flatten)]
    pub token: TokenView,
}

/// All users.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub(crate) struct UserList {
    /// By name.
    pub users: Vec<User>,
}

/// Tokens without their secrets.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub(crate) struct TokenList {
    /// Oldest first.
    pub tokens: Vec<TokenView>,
}

impl From<NewToken> for IssuedToken {
    fn from(new: NewToken) -> Self {
        Self { secret: new.secret.reveal().to_owned(), token: new.token.view() }
    }
}

/// A user's name in the address; a text that cannot be one is nobody's.
#[expect(clippy::result_large_err, reason = "made at most once a request")]
fn parse_name(text: &str) -> Result<UserName, Problem> {
    text.parse().map_err(|BadUserName| {
        Problem::new(StatusCode::NOT_FOUND, "unknown-member", format!("there is no user \"{text}\""))
    })
}

/// Lists all users. For admins.
#[utoipa::path(
    get, path = "/users", tag = "users",
    responses((status = 200, description = "All users, by name", body = UserList))
)]
pub(crate) async fn list_users(State(state): State<ApiState>) -> Json<UserList> {
    Json(UserList { users: state.coordinator.users() })
}

/// Adds a user with a first token. For admins; for anyone while there are no users, and then an admin has to be added first.
#[utoipa::path(
    post, path = "/users", tag = "users", request_body = NewUser,
    responses(
        (status = 201, description = "Added; the token's secret is shown this once", body = AddedUser),
        (status = 400, description = "Not JSON", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "There is such a user, or it is the first one and no admin", body = Problem,
            content_type = "application/problem+json"),
        (status = 415, description = "Not said to be JSON", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Not a name or role", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn add_user(
    State(state): State<ApiState>,
    Extension(caller): Extension<Caller>,
    JsonBody(new): JsonBody<NewUser>,
) -> Result<(StatusCode, Json<AddedUser>), Problem> {
    let (user, token) = state.coordinator.add_user(&caller, new.name, new.role).await?;
    Ok((StatusCode::CREATED, Json(AddedUser { user, token: token.into() })))
}

/// Gives a user another role. For admins.
#[utoipa::path(
    patch, path = "/users/{name}", tag = "users", request_body = UserPatch,
    params(("name" = String, Path, description = "The user's name")),
    responses(
        (status = 200, description = "The user afterwards", body = User),
        (status = 400, description = "Not JSON", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such user", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "They are the only admin", body = Problem, content_type = "application/problem+json"),
        (status = 415, description = "Not said to be JSON", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Not a role", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn change_user(
    State(state): State<ApiState>,
    Extension(caller): Extension<Caller>,
    PathValue(name): PathValue<String>,
    JsonBody(patch): JsonBody<UserPatch>,
) -> Result<Json<User>, Problem> {
    Ok(Json(state.coordinator.change_role(&caller, &parse_name(&name)?, patch.role).await?))
}

/// Deletes a user with all tokens; their jobs stay. For admins.
#[utoipa::path(
    delete, path = "/users/{name}", tag = "users",
    params(("name" = String, Path, description = "The user's name")),
    responses(
        (status = 204, description = "They are gone"),
        (status = 404, description = "No such user", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "They are the only admin", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn delete_user(
    State(state): State<ApiState>,
    Extension(caller): Extension<Caller>,
    PathValue(name): PathValue<String>,
) -> Result<StatusCode, Problem> {
    state.coordinator.delete_user(&caller, &parse_name(&name)?).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Lists one's own tokens; all of them for admins.
#[utoipa::path(
    get, path = "/tokens", tag = "users",
    responses((status = 200, description = "Tokens without secrets, oldest first", body = TokenList))
)]
pub(crate) async fn list_tokens(
    State(state): State<ApiState>,
    Extension(caller): Extension<Caller>,
) -> Json<TokenList> {
    Json(TokenList { tokens: state.coordinator.tokens(&caller) })
}

/// Makes a token that allows no more than the caller's own. For others, and for workers, admins make them.
#[utoipa::path(
    post, path = "/tokens", tag = "users", request_body = TokenRequest,
    responses(
        (status = 201, description = "Made; its secret is shown this once", body = IssuedToken),
        (status = 400, description = "Not JSON", body = Problem, content_type = "application/problem+json"),
        (status = 403, description = "It would allow more than the caller's", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such user", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "The user has too many", body = Problem, content_type = "application/problem+json"),
        (status = 415, description = "Not said to be JSON", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Cannot be made", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn make_token(
    State(state): State<ApiState>,
    Extension(caller): Extension<Caller>,
    JsonBody(wanted): JsonBody<TokenRequest>,
) -> Result<(StatusCode, Json<IssuedToken>), Problem> {
    Ok((StatusCode::CREATED, Json(state.coordinator.issue_token(&caller, wanted).await?.into())))
}

/// Revokes one of one's own tokens; any of them for admins. Pages that were logged in with it are logged out.
#[utoipa::path(
    delete, path = "/tokens/{id}", tag = "users",
    params(("id" = String, Path, description = "The token's id")),
    responses(
        (status = 204, description = "It is not taken any more"),
        (status = 404, description = "No such token", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn revoke_token(
    State(state): State<ApiState>,
    Extension(caller): Extension<Caller>,
    PathValue(id): PathValue<String>,
) -> Result<StatusCode, Problem> {
    state.coordinator.revoke_token(&caller, &id).await?;
    Ok(StatusCode::NO_CONTENT)
}
