//! Scenes: upload once, refer to by hash.

use axum::Extension;
use axum::body::Body;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use futures_util::StreamExt;
use serde::Serialize;
use utoipa::ToSchema;

use super::ApiState;
use super::extract::PathValue;
use super::json_answer::Json;
use super::problem::Problem;
use super::schemas::Bytes;
use crate::farm::SceneSummary;
use crate::farm::access::caller::Caller;

/// An uploaded scene.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(crate) struct SceneView {
    /// What is known of it.
    #[serde(flatten)]
    pub summary: SceneSummary,
    /// Where to go from here.
    pub links: SceneLinks,
}

/// Addresses that belong to a scene.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(crate) struct SceneLinks {
    /// The scene itself.
    #[serde(rename = "self")]
    pub this: String,
    /// Where jobs are submitted.
    pub jobs: String,
}

impl From<SceneSummary> for SceneView {
    fn from(summary: SceneSummary) -> Self {
        let links = SceneLinks { this: format!("/v1/scenes/{}", summary.hash), jobs: "/v1/jobs".to_owned() };
        Self { summary, links }
    }
}

/// Uploads a scene of any format that is read, alone or in a zip archive with everything it refers to.
#[utoipa::path(
    post, path = "/scenes", tag = "scenes",
    request_body(content = inline(Bytes), content_type = "application/octet-stream"),
    responses(
        (status = 201, description = "Checked and kept", body = SceneView, headers(("Location" = String))),
        (status = 408, description = "No byte for too long", body = Problem, content_type = "application/problem+json"),
        (status = 413, description = "More than /v1/limits allows", body = Problem, content_type = "application/problem+json"),
        (status = 429, description = "Too many uploads at once", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Cannot be rendered", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn upload_scene(
    State(state): State<ApiState>,
    Extension(caller): Extension<Caller>,
    body: Body,
) -> Result<Response, Problem> {
    let mut upload = state.coordinator.begin_upload(&caller).await?;
    let mut chunks = body.into_data_stream();
    loop {
        let taken = match chunks.next().await {
            None => break,
            Some(Ok(bytes)) => upload.write(&bytes).await.map_err(Problem::from),
            Some(Err(problem)) => Err(Problem::of_body(&problem)),
        };
        if let Err(problem) = taken {
            upload.abort().await?;
            return Err(problem);
        }
    }
    let view = SceneView::from(upload.finish().await?);
    let location = view.links.this.clone();
    Ok((StatusCode::CREATED, [(header::LOCATION, location)], Json(view)).into_response())
}

/// What is known of an uploaded scene.
#[utoipa::path(
    get, path = "/scenes/{hash}", tag = "scenes",
    params(("hash" = String, Path, description = "Hash of the scene, 64 hexadecimal digits")),
    responses(
        (status = 200, description = "The scene", body = SceneView),
        (status = 404, description = "Never uploaded", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn show_scene(
    State(state): State<ApiState>,
    PathValue(hash): PathValue<String>,
) -> Result<Json<SceneView>, Problem> {
    Ok(Json(state.coordinator.scene(&hash)?.into()))
}

/// All uploaded scenes.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(crate) struct SceneList {
    /// By hash.
    pub scenes: Vec<SceneView>,
}

/// Lists all scenes.
#[utoipa::path(
    get, path = "/scenes", tag = "scenes",
    responses((status = 200, description = "All scenes, by hash", body = SceneList))
)]
pub(crate) async fn list_scenes(State(state): State<ApiState>) -> Json<SceneList> {
    Json(SceneList { scenes: state.coordinator.scenes().into_iter().map(SceneView::from).collect() })
}

/// Deletes a scene that no job refers to.
#[utoipa::path(
    delete, path = "/scenes/{hash}", tag = "scenes",
    params(("hash" = String, Path, description = "Hash of the scene, 64 hexadecimal digits")),
    responses(
        (status = 204, description = "It is gone"),
        (status = 404, description = "Never uploaded", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "A job refers to it", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn delete_scene(
    State(state): State<ApiState>,
    Extension(caller): Extension<Caller>,
    PathValue(hash): PathValue<String>,
) -> Result<StatusCode, Problem> {
    state.coordinator.check_scene_owner(&caller, &hash)?;
    state.coordinator.delete_scene(&hash).await?;
    Ok(StatusCode::NO_CONTENT)
}
