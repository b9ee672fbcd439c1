//! A job's picture at any time, for eyes and as EXR, with an ETag so that an unchanged one is not sent twice.

pub(crate) mod display;

use axum::extract::State;
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use utoipa::openapi::path::{Parameter, ParameterBuilder, ParameterIn};
use utoipa::{IntoParams, PartialSchema};

use super::ApiState;
use super::extract::{PathValue, QueryValues, parse_job};
use super::problem::Problem;
use super::ranges::image;
use super::schemas::Bytes;
use crate::estimate::picture_files::{LAYERS, Layer, LayerRow, PictureMetadata, encode_exr, encode_half_exr};
use crate::evaluation::chart::{JobPoint, draw_job, to_svg};
use crate::farm::job::JobStatus;
use crate::farm::rules::terms::ErrorPoint;
use crate::farm::{FarmError, LayeredPicture};

/// The header that tells relMSE of a denoised picture.
pub(crate) const DENOISED_RELMSE: &str = "photonfarm-denoised-relmse";

/// What the EXR holds.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ExrQuery {
    /// Names of further layers, separated by commas.
    #[serde(default)]
    pub layers: String,
    /// Whether colors and directions are 16-bit floats.
    #[serde(default)]
    pub half: bool,
}

impl IntoParams for ExrQuery {
    fn into_params(_place: impl Fn() -> Option<ParameterIn>) -> Vec<Parameter> {
        let known = LAYERS.map(|row| format!("`{}` ({})", row.name, row.description())).join(", ");
        let layers = ParameterBuilder::new()
            .name("layers")
            .parameter_in(ParameterIn::Query)
            .description(Some(format!("Further layers, separated by commas: {known}.")))
            .schema(Some(String::schema()));
        let half = ParameterBuilder::new()
            .name("half")
            .parameter_in(ParameterIn::Query)
            .description(Some(
                "Whether colors and directions are 16-bit floats; a layer with numbers beyond 65504 stays at 32 bits, and so do \
                 those that hold distances, places, counts, errors and ids.",
            ))
            .schema(Some(bool::schema()));
        vec![layers.build(), half.build()]
    }
}

/// The picture so far as float EXR, linear, with the job in its header.
#[utoipa::path(
    get, path = "/jobs/{id}/image.exr", tag = "images",
    params(("id" = String, Path, description = "The job's id"), ExrQuery),
    responses(
        (status = 200, description = "The picture so far", body = inline(Bytes), content_type = "image/x-exr",
            headers(("ETag" = String), ("Photonfarm-Denoised-RelMSE" = f64, description = "Where it is denoised: its own estimate"))),
        (status = 206, description = "The part of it that Range names", body = inline(Bytes), content_type = "image/x-exr"),
        (status = 304, description = "The same as If-None-Match names"),
        (status = 404, description = "No such job, or no picture yet", body = Problem,
            content_type = "application/problem+json"),
        (status = 409, description = "It cannot be denoised yet", body = Problem, content_type = "application/problem+json"),
        (status = 400, description = "Unknown parameters", body = Problem, content_type = "application/problem+json"),
        (status = 416, description = "No such part", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Impossible values", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn image_exr(
    State(state): State<ApiState>,
    PathValue(id): PathValue<String>,
    QueryValues(query): QueryValues<ExrQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let wanted = wanted_layers(&query.layers)?;
    let names: Vec<&str> = wanted.iter().map(|layer| layer.row().name).collect();
    // The name may change at any time.
    let variant = |status: &JobStatus| format!("exr,{},{},{:?}", names.join(","), query.half, status.name);
    let id = parse_job(&id)?;
    let status = state.coordinator.job(id)?;
    if let Some(unchanged) = unchanged(&status, &variant(&status), &headers) {
        return Ok(unchanged);
    }
    let LayeredPicture { picture, layers, status, mattes, denoised_relmse } =
        state.coordinator.picture_with_layers(id, &wanted).await?;
    let tag = etag(&status, &variant(&status));
    let camera = state.coordinator.camera(&status.scene)?;
    let metadata = PictureMetadata {
        world_to_camera: camera.map(|camera| camera.world_to_camera),
        world_to_ndc: camera.and_then(|camera| camera.world_to_ndc),
        mattes,
        ..metadata_of(&status)
    };
    let encoder = if query.half { encode_half_exr } else { encode_exr };
    let bytes = encode(move || encoder(&picture, &layers, &metadata)).await?;
    Ok(with_relmse(image("image/x-exr", &tag, bytes, &headers), denoised_relmse))
}

/// The job's own error estimate over time, as a chart.
#[utoipa::path(
    get, path = "/jobs/{id}/chart.svg", tag = "images",
    params(("id" = String, Path, description = "The job's id")),
    responses(
        (status = 200, description = "The chart so far", body = String, content_type = "image/svg+xml",
            headers(("ETag" = String))),
        (status = 304, description = "The same as If-None-Match names"),
        (status = 404, description = "No such job", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn chart_svg(
    State(state): State<ApiState>,
    PathValue(id): PathValue<String>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let id = parse_job(&id)?;
    let status = state.coordinator.job(id)?;
    if let Some(unchanged) = unchanged(&status, "svg", &headers) {
        return Ok(unchanged);
    }
    let point = |ErrorPoint { seconds, measured }| JobPoint { seconds, passes: measured.passes, error: measured.error };
    let history: Vec<JobPoint> = state.coordinator.error_history(id)?.into_iter().map(point).collect();
    let (tag, title) = (etag(&status, "svg"), format!("{id}: {}", status.method));
    let svg = encode(move || to_svg(&draw_job(&title, &history, status.stop.error))).await?;
    Ok(image("image/svg+xml", &tag, svg.into_bytes(), &headers))
}

/// Tells what the denoised picture's own halves say of its relMSE.
fn with_relmse(mut response: Response, relmse: Option<f64>) -> Response {
    let told = relmse.and_then(|relmse| HeaderValue::from_str(&relmse.to_string()).ok());
    if let Some(told) = told {
        response.headers_mut().insert(HeaderName::from_static(DENOISED_RELMSE), told);
    }
    response
}

#[expect(clippy::result_large_err, reason = "made at most once a request")]
fn wanted_layers(list: &str) -> Result<Vec<Layer>, Problem> {
    Layer::parse_list(list)
        .map_err(|unknown| Problem::bad_request(unknown.to_string(), format!("known layers: {}", Layer::known())))
}

/// The problem about a matte where values are looked at or averaged.
pub(crate) fn ids_only_in_exr(row: &LayerRow) -> Problem {
    let detail = format!("layer {} holds ids, which are neither colors nor quantities", row.name);
    Problem::bad_request(detail, "fetch it in image.exr, and select names in a compositor")
}

/// What the header of an EXR says of a job, but for the camera, which the status does not tell.
pub(crate) fn metadata_of(status: &JobStatus) -> PictureMetadata {
    PictureMetadata {
        job: status.id.clone(),
        method: status.method.clone(),
        parameters: status.parameters.clone(),
        passes: status.passes_done,
        photons_emitted: status.photons_emitted,
        seed: status.seed,
        scene: status.scene.clone(),
        name: status.name.clone(),
        owner: status.owner.as_ref().map(ToString::to_string),
        submitted: Some(status.submitted),
        ..PictureMetadata::default()
    }
}

/// Runs an encoder where it does not hold up other requests.
async fn encode<T: Send + 'static, E: std::fmt::Display + Send + 'static>(
    encoder: impl FnOnce() -> Result<T, E> + Send + 'static,
) -> Result<T, Problem> {
    let encoded = tokio::task::spawn_blocking(encoder).await.map_err(|error| FarmError::Internal(error.to_string()))?;
    Ok(encoded.map_err(|error| FarmError::Internal(error.to_string()))?)
}

/// Names the bytes by all that they follow from; ids alone begin anew when a coordinator does.
pub(super) fn etag(status: &JobStatus, variant: &str) -> String {
    let parameters = serde_json::Value::Object(status.parameters.clone()).to_string();
    let JobStatus { id, scene, method, seed, passes_done, photons_emitted, picture_version, .. } = status;
    let counts = [*seed, u64::from(*passes_done), *photons_emitted, *picture_version].map(|count| count.to_string());
    let facts = [id.as_str(), scene, method, &parameters, &counts.join(","), variant];
    let hash = blake3::hash(facts.join("\n").as_bytes()).to_hex();
    format!("\"{}\"", &hash[..32])
}

/// The answer 304, when the request names the picture that there is now.
pub(super) fn unchanged(status: &JobStatus, variant: &str, headers: &HeaderMap) -> Option<Response> {
    let tag = etag(status, variant);
    let named = headers.get_all(header::IF_NONE_MATCH).iter().filter_map(|value| value.to_str().ok());
    let matches =
        named.flat_map(|list| list.split(',')).map(|name| name.trim().trim_start_matches("W/")).any(|name| name == tag);
    matches.then(|| {
        (StatusCode::NOT_MODIFIED, [(header::ETAG, tag)], [(header::CACHE_CONTROL, "no-cache")]).into_response()
    })
}
