//! A job's picture to look at, as PNG, JPEG and WebP.

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use serde::{Deserialize, Deserializer};
use utoipa::openapi::schema::{ObjectBuilder, OneOfBuilder, Schema, Type};
use utoipa::{IntoParams, ToSchema};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::{encode, etag, unchanged, with_relmse};
use crate::api::ApiState;
use crate::api::extract::{PathValue, QueryValues, parse_job};
use crate::api::problem::Problem;
use crate::api::ranges::image;
use crate::api::schemas::Bytes;
use crate::estimate::picture_files::{
    Display, DisplayFormat, Exposure, JPEG_QUALITY, MOST_JPEG_QUALITY, ToneCurve, encode_display,
};
use crate::farm::job::JobStatus;

/// How the PNG is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct PngQuery {
    /// The picture as it is, or denoised.
    #[serde(default)]
    #[param(inline)]
    pub layer: ShownLayer,
    /// Stops or `auto`; its schema says more.
    #[serde(default, deserialize_with = "read_exposure")]
    #[param(schema_with = exposure_schema)]
    pub exposure: Exposure,
    /// What makes code values of colors; linear by default.
    #[serde(default)]
    #[param(inline)]
    pub tone: Tone,
    /// Bits a channel, 8 or 16; 8 by default.
    pub bits: Option<u8>,
}

/// How the JPEG is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct JpegQuery {
    /// The picture as it is, or denoised.
    #[serde(default)]
    #[param(inline)]
    pub layer: ShownLayer,
    /// Stops or `auto`; its schema says more.
    #[serde(default, deserialize_with = "read_exposure")]
    #[param(schema_with = exposure_schema)]
    pub exposure: Exposure,
    /// What makes code values of colors; linear by default.
    #[serde(default)]
    #[param(inline)]
    pub tone: Tone,
    /// From 1 (smallest file) to 100 (least loss); 90 by default.
    #[param(minimum = 1, maximum = 100)]
    pub quality: Option<u8>,
}

/// How the WebP is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct WebpQuery {
    /// The picture as it is, or denoised.
    #[serde(default)]
    #[param(inline)]
    pub layer: ShownLayer,
    /// Stops or `auto`; its schema says more.
    #[serde(default, deserialize_with = "read_exposure")]
    #[param(schema_with = exposure_schema)]
    pub exposure: Exposure,
    /// What makes code values of colors; linear by default.
    #[serde(default)]
    #[param(inline)]
    pub tone: Tone,
}

/// What is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ShownLayer {
    /// The picture as it is.
    #[default]
    Color,
    /// The picture with less noise.
    Denoised,
}

/// What makes code values of colors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Tone {
    /// Colors as they are; brighter than 1 is white.
    #[default]
    Linear,
    /// Soft shadows and highlights, each channel alone [Hable 2010].
    Filmic,
    /// Soft highlights that lose their color as they grow brighter [Sobotka 2022].
    Agx,
}

impl From<Tone> for ToneCurve {
    fn from(tone: Tone) -> Self {
        match tone {
            Tone::Linear => Self::Linear,
            Tone::Filmic => Self::Filmic,
            Tone::Agx => Self::Agx,
        }
    }
}

fn read_exposure<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Exposure, D::Error> {
    String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
}

/// The description stands here because one beside a field with a schema of its own is lost.
fn exposure_schema() -> Schema {
    let description = "Stops by which the picture is made brighter (multiplied by 2^exposure); 0 by default. With auto its \
                       log-average luminance becomes 0.18.";
    let stops = ObjectBuilder::new().schema_type(Type::Number).minimum(Some(-64.0)).maximum(Some(64.0));
    let auto = ObjectBuilder::new().schema_type(Type::String).enum_values(Some(["auto"]));
    OneOfBuilder::new().description(Some(description)).item(stops).item(auto).build().into()
}

/// The endpoints of pictures to look at.
pub(crate) fn routes() -> OpenApiRouter<ApiState> {
    OpenApiRouter::new().routes(routes!(image_png)).routes(routes!(image_jpg)).routes(routes!(image_webp))
}

/// The picture so far as sRGB PNG.
#[utoipa::path(
    get, path = "/jobs/{id}/image.png", tag = "images",
    params(("id" = String, Path, description = "The job's id"), PngQuery),
    responses(
        (status = 200, description = "The picture so far", body = inline(Bytes), content_type = "image/png",
            headers(("ETag" = String), ("Photonfarm-Denoised-RelMSE" = f64, description = "Where it is denoised: its own estimate"))),
        (status = 206, description = "The part of it that Range names", body = inline(Bytes), content_type = "image/png"),
        (status = 304, description = "The same as If-None-Match names"),
        (status = 404, description = "No such job, or no picture yet", body = Problem,
            content_type = "application/problem+json"),
        (status = 409, description = "It cannot be denoised yet", body = Problem, content_type = "application/problem+json"),
        (status = 400, description = "Unknown parameters", body = Problem, content_type = "application/problem+json"),
        (status = 416, description = "No such part", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Impossible values", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn image_png(
    State(state): State<ApiState>,
    PathValue(id): PathValue<String>,
    QueryValues(query): QueryValues<PngQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let format = match query.bits {
        None | Some(8) => DisplayFormat::Png,
        Some(16) => DisplayFormat::Png16,
        Some(bits) => return Err(Problem::bad_request(format!("bits is {bits}"), "give 8 or 16")),
    };
    let display = Display { exposure: query.exposure, tone: query.tone.into() };
    answer(&state, &id, query.layer, display, format, &headers).await
}

/// The picture so far as sRGB JPEG.
#[utoipa::path(
    get, path = "/jobs/{id}/image.jpg", tag = "images",
    params(("id" = String, Path, description = "The job's id"), JpegQuery),
    responses(
        (status = 200, description = "The picture so far", body = inline(Bytes), content_type = "image/jpeg",
            headers(("ETag" = String), ("Photonfarm-Denoised-RelMSE" = f64, description = "Where it is denoised: its own estimate"))),
        (status = 206, description = "The part of it that Range names", body = inline(Bytes), content_type = "image/jpeg"),
        (status = 304, description = "The same as If-None-Match names"),
        (status = 404, description = "No such job, or no picture yet", body = Problem,
            content_type = "application/problem+json"),
        (status = 409, description = "It cannot be denoised yet", body = Problem, content_type = "application/problem+json"),
        (status = 400, description = "Unknown parameters", body = Problem, content_type = "application/problem+json"),
        (status = 416, description = "No such part", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Impossible values", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn image_jpg(
    State(state): State<ApiState>,
    PathValue(id): PathValue<String>,
    QueryValues(query): QueryValues<JpegQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let quality = query.quality.unwrap_or(JPEG_QUALITY);
    if !(1..=MOST_JPEG_QUALITY).contains(&quality) {
        let remedy = format!("give a number from 1 to {MOST_JPEG_QUALITY}");
        return Err(Problem::bad_request(format!("quality is {quality}"), remedy));
    }
    let display = Display { exposure: query.exposure, tone: query.tone.into() };
    answer(&state, &id, query.layer, display, DisplayFormat::Jpeg { quality }, &headers).await
}

/// The picture so far as sRGB WebP without loss.
#[utoipa::path(
    get, path = "/jobs/{id}/image.webp", tag = "images",
    params(("id" = String, Path, description = "The job's id"), WebpQuery),
    responses(
        (status = 200, description = "The picture so far", body = inline(Bytes), content_type = "image/webp",
            headers(("ETag" = String), ("Photonfarm-Denoised-RelMSE" = f64, description = "Where it is denoised: its own estimate"))),
        (status = 206, description = "The part of it that Range names", body = inline(Bytes), content_type = "image/webp"),
        (status = 304, description = "The same as If-None-Match names"),
        (status = 404, description = "No such job, or no picture yet", body = Problem,
            content_type = "application/problem+json"),
        (status = 409, description = "It cannot be denoised yet", body = Problem, content_type = "application/problem+json"),
        (status = 400, description = "Unknown parameters", body = Problem, content_type = "application/problem+json"),
        (status = 416, description = "No such part", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Impossible values", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn image_webp(
    State(state): State<ApiState>,
    PathValue(id): PathValue<String>,
    QueryValues(query): QueryValues<WebpQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let display = Display { exposure: query.exposure, tone: query.tone.into() };
    answer(&state, &id, query.layer, display, DisplayFormat::Webp, &headers).await
}

async fn answer(
    state: &ApiState,
    id: &str,
    layer: ShownLayer,
    display: Display,
    format: DisplayFormat,
    headers: &HeaderMap,
) -> Result<Response, Problem> {
    if !display.exposure.is_possible() {
        let remedy = "give a number of stops from -64 to 64, or auto";
        return Err(Problem::bad_request(format!("exposure is {}", display.exposure), remedy));
    }
    let variant = format!("{format:?},{display:?},{layer:?}");
    let id = parse_job(id)?;
    let status = state.coordinator.job(id)?;
    check_size(&status, format)?;
    if let Some(unchanged) = unchanged(&status, &variant, headers) {
        return Ok(unchanged);
    }
    let (picture, relmse, status) = match layer {
        ShownLayer::Color => state.coordinator.picture(id).await.map(|(picture, status)| (picture, None, status))?,
        ShownLayer::Denoised => {
            let (picture, relmse, status) = state.coordinator.denoised_picture(id).await?;
            (picture, Some(relmse), status)
        }
    };
    let tag = etag(&status, &variant);
    let bytes = encode(move || encode_display(&picture, display, format)).await?;
    Ok(with_relmse(image(format.media_type(), &tag, bytes, headers), relmse))
}

#[expect(clippy::result_large_err, reason = "made at most once a request")]
fn check_size(status: &JobStatus, format: DisplayFormat) -> Result<(), Problem> {
    let (found, most) = (status.width.max(status.height), format.largest_side());
    if found <= most {
        return Ok(());
    }
    let detail = format!("the picture is {found} pixels long, and {} ends at {most}", format.media_type());
    Err(Problem::bad_request(detail, "ask for image.png or image.exr"))
}
