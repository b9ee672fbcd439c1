//! Layers of a job's picture so far in false colors.

use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;
use serde::Deserialize;
use utoipa::{IntoParams, ToSchema};

use super::ApiState;
use super::extract::{PathValue, QueryValues, parse_job};
use super::images::{etag, ids_only_in_exr, unchanged};
use super::problem::Problem;
use super::ranges::image;
use super::schemas::Bytes;
use crate::estimate::picture_files::{Channels, LUMINANCE, Layer, LayerRow, LayerValues, PictureFileError};
use crate::evaluation::chart::{CanvasError, Drawing, ScaleError, ScaleRequest, Spacing, draw_layer, to_png, to_svg};
use crate::farm::{FarmError, LayeredPicture};

/// What a map shows, and how.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct MapQuery {
    /// A layer of `image.exr` or one of its channels (`radius`, `error`, `normal.X`); the picture's `luminance` by default.
    #[serde(default = "luminance")]
    pub layer: String,
    /// How values are spread over the colors; logarithmic by default where they are positive and differ much.
    #[param(inline)]
    pub scale: Option<Scale>,
    /// Value of the first color; by default nearly all values are covered.
    pub low: Option<f64>,
    /// Value of the last color.
    pub high: Option<f64>,
}

/// How values are spread over the colors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Scale {
    /// Equal differences look alike.
    Linear,
    /// Equal ratios look alike.
    Log,
}

fn luminance() -> String {
    LUMINANCE.to_owned()
}

impl MapQuery {
    fn request(&self) -> ScaleRequest {
        let spacing = self.scale.map(|scale| match scale {
            Scale::Linear => Spacing::Linear,
            Scale::Log => Spacing::Logarithmic,
        });
        ScaleRequest { spacing, low: self.low, high: self.high }
    }

    /// The further layer that is needed; none for the picture itself.
    #[expect(clippy::result_large_err, reason = "made at most once a request")]
    fn further_layer(&self) -> Result<Option<Layer>, Problem> {
        match LayerRow::named(&self.layer) {
            Some(row) if row.layer.is_matte() => Err(ids_only_in_exr(row)),
            Some(row) => Ok(Some(row.layer)),
            None if [LUMINANCE, "R", "G", "B"].contains(&self.layer.as_str()) => Ok(None),
            None => {
                let detail = format!("there is no layer \"{}\"", self.layer);
                Err(Problem::bad_request(detail, format!("known layers: {LUMINANCE}, {}", Layer::known_to_look_at())))
            }
        }
    }
}

/// A layer of the picture so far in false colors, with its scale, as PNG.
#[utoipa::path(
    get, path = "/jobs/{id}/map.png", tag = "images",
    params(("id" = String, Path, description = "The job's id"), MapQuery),
    responses(
        (status = 200, description = "The map so far", body = inline(Bytes), content_type = "image/png",
            headers(("ETag" = String))),
        (status = 206, description = "The part of it that Range names", body = inline(Bytes), content_type = "image/png"),
        (status = 304, description = "The same as If-None-Match names"),
        (status = 400, description = "Unknown parameters", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such job, no picture yet, or no value in the layer yet", body = Problem,
            content_type = "application/problem+json"),
        (status = 409, description = "It cannot be denoised yet", body = Problem, content_type = "application/problem+json"),
        (status = 416, description = "No such part", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "No such layer, or an impossible scale", body = Problem,
            content_type = "application/problem+json"),
    )
)]
pub(crate) async fn map_png(
    State(state): State<ApiState>,
    PathValue(id): PathValue<String>,
    QueryValues(query): QueryValues<MapQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    map(state, id, query, headers, ("image/png", to_png)).await
}

/// A layer of the picture so far in false colors, with its scale, as SVG.
#[utoipa::path(
    get, path = "/jobs/{id}/map.svg", tag = "images",
    params(("id" = String, Path, description = "The job's id"), MapQuery),
    responses(
        (status = 200, description = "The map so far", body = String, content_type = "image/svg+xml",
            headers(("ETag" = String))),
        (status = 206, description = "The part of it that Range names", body = inline(Bytes), content_type = "image/svg+xml"),
        (status = 304, description = "The same as If-None-Match names"),
        (status = 400, description = "Unknown parameters", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such job, no picture yet, or no value in the layer yet", body = Problem,
            content_type = "application/problem+json"),
        (status = 409, description = "It cannot be denoised yet", body = Problem, content_type = "application/problem+json"),
        (status = 416, description = "No such part", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "No such layer, or an impossible scale", body = Problem,
            content_type = "application/problem+json"),
    )
)]
pub(crate) async fn map_svg(
    State(state): State<ApiState>,
    PathValue(id): PathValue<String>,
    QueryValues(query): QueryValues<MapQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    map(state, id, query, headers, ("image/svg+xml", |drawing| to_svg(drawing).map(String::into_bytes))).await
}

/// A media type and what makes it.
type Form = (&'static str, fn(&Drawing) -> Result<Vec<u8>, CanvasError>);

async fn map(
    state: ApiState,
    id: String,
    query: MapQuery,
    headers: HeaderMap,
    (media_type, encode): Form,
) -> Result<Response, Problem> {
    let wanted: Vec<Layer> = query.further_layer()?.into_iter().collect();
    let variant = format!("{media_type},{query:?}");
    let id = parse_job(&id)?;
    if let Some(unchanged) = unchanged(&state.coordinator.job(id)?, &variant, &headers) {
        return Ok(unchanged);
    }
    let LayeredPicture { picture, layers, status, .. } = state.coordinator.picture_with_layers(id, &wanted).await?;
    let tag = etag(&status, &variant);
    let note = format!("{id}: {}, {} passes", status.method, status.passes_done);
    let drawn = tokio::task::spawn_blocking(move || {
        let values = Channels::of(&picture, &layers).and_then(|channels| channels.layer(&query.layer));
        draw(values, [picture.width, picture.height], &note, &query, encode)
    });
    let drawn = drawn.await.map_err(|error| FarmError::Internal(error.to_string()))?;
    let bytes = drawn.map_err(|problem| *problem)?;
    Ok(image(media_type, &tag, bytes, &headers))
}

fn draw(
    layer: Result<LayerValues, PictureFileError>,
    size: [u32; 2],
    note: &str,
    query: &MapQuery,
    encode: fn(&Drawing) -> Result<Vec<u8>, CanvasError>,
) -> Result<Vec<u8>, Box<Problem>> {
    let layer = layer.map_err(|error| Problem::bad_request(error.to_string(), "name one of these"))?;
    let drawing = draw_layer(layer, size, note, query.request()).map_err(|error| match error {
        ScaleError::NoValue { .. } => {
            Problem::new(StatusCode::NOT_FOUND, "no-value-yet", format!("layer {}: {error}", query.layer))
                .remedy("ask again after more passes, for another layer, or for a linear scale")
        }
        _ => Problem::bad_request(error.to_string(), "leave low, high and scale out to cover all values"),
    })?;
    encode(&drawing).map_err(|error| Box::new(FarmError::Internal(error.to_string()).into()))
}
