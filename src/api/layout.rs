//! Where the camera and the lights of a job's scene stand, for programs that draw places of the scene over its picture.

use axum::Extension;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;

use super::ApiState;
use super::extract::{PathValue, parse_job};
use super::json_answer::Json;
use super::problem::Problem;
use crate::farm::SceneLayout;
use crate::farm::access::caller::Caller;

/// Lights that are told; a street of windows may have many more.
const MOST_LIGHTS: usize = 500;

/// Where the camera and the lights of a job's scene stand. Matrices go by rows, for row vectors: (x, y, z, 1) is multiplied from the left.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(crate) struct Layout {
    /// Column and row of the whole film at which the job's picture begins: 0, 0 but for crop windows. `scene_changes.crop` counts from the film's first.
    pub first_pixel: [u32; 2],
    /// From the world to the picture's right and up and the direction of view, m; left out where the camera stands nowhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub world_to_camera: Option<[f32; 16]>,
    /// From the world to the picture after division by the fourth number: (0, 0) is its upper left corner, (1, 1) its lower right one. Left out
    /// where straight lines do not stay straight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub world_to_ndc: Option<[f32; 16]>,
    /// Lights that have a place, those of most power first, at most 500. Skies, suns and beams have none.
    pub lights: Vec<LightView>,
    /// How many further lights have a place.
    pub lights_left_out: usize,
}

/// A light that has a place.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub(crate) struct LightView {
    /// What the scene calls it; left out where it has no name.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Its plugin: `area`, `point`, `spot`, `ies` or `projector`.
    pub kind: &'static str,
    /// Where it shines from, m: of an emitting shape up to 8 places spread over it, of others the one that there is.
    pub points: Vec<[f32; 3]>,
}

impl From<SceneLayout> for Layout {
    fn from(layout: SceneLayout) -> Self {
        let SceneLayout { first_pixel, camera, lights } = layout;
        let lights_left_out = lights.len().saturating_sub(MOST_LIGHTS);
        let lights = lights.into_iter().take(MOST_LIGHTS).map(|light| LightView {
            name: light.name,
            kind: light.kind,
            points: light.points.iter().map(|point| point.to_array()).collect(),
        });
        Self {
            first_pixel,
            world_to_camera: camera.map(|camera| camera.world_to_camera),
            world_to_ndc: camera.and_then(|camera| camera.world_to_ndc),
            lights: lights.collect(),
            lights_left_out,
        }
    }
}

/// Tells where the camera and the lights of a job's scene stand.
#[utoipa::path(
    get, path = "/jobs/{id}/layout", tag = "images",
    params(("id" = String, Path, description = "The job's id")),
    responses(
        (status = 200, description = "Camera and lights", body = Layout),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
        (status = 429, description = "Too many scenes are taken in at once", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn layout(
    State(state): State<ApiState>,
    Extension(caller): Extension<Caller>,
    PathValue(id): PathValue<String>,
) -> Result<Json<Layout>, Problem> {
    let scene = state.coordinator.job(parse_job(&id)?)?.scene;
    Ok(Json(state.coordinator.layout(&scene, &caller).await?.into()))
}
