//! The numbers of a job's picture for programs that look at it: a part of one layer, coarse or fine, as plain floats.
//!
//! To watch a running job must cost next to nothing, however many do. So the values of a layer are kept for a while, and made anew at most after
//! [`REST`] times as long as that takes: what is answered may be some passes old, and says how many it has.

mod half;

use std::num::NonZeroU32;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use axum::Extension;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderName, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use utoipa::{IntoParams, ToSchema};

use half::half_bits;

use super::ApiState;
use super::extract::{PathValue, QueryValues, parse_job};
use super::images::{etag, ids_only_in_exr, unchanged};
use super::problem::Problem;
use super::schemas::Bytes;
use crate::estimate::Picture;
use crate::estimate::picture_files::{Layer, OF_LIGHT_GROUP, PictureLayer};
use crate::farm::ids::JobId;
use crate::farm::job::JobStatus;
use crate::farm::{FarmError, LayeredPicture};

/// What the picture itself is called among the layers.
const COLOR: &str = "color";
/// How many times as long as the values of a running job take to be made they are answered at least. With what it takes to send them, a page that
/// watches a picture of 1920 × 1080 pixels costs 2 % of a processor.
const REST: u32 = 75;
/// How long values are kept.
const KEPT_FOR: Duration = Duration::from_secs(20);
/// Bytes of values that are kept; the newest are in any case.
const KEPT_BYTES: usize = 256 << 20;

/// Which numbers are meant.
#[derive(Clone, Debug, PartialEq, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct PixelsQuery {
    /// `color` (the default), a layer of `image.exr`, or `light_group.NAME` for the light of one light group.
    #[serde(default = "color")]
    pub layer: String,
    /// Each answered pixel is the mean of up to 2^level × 2^level; 0, the default, is the picture itself.
    #[serde(default)]
    pub level: u32,
    /// First column of the part that is answered, in pixels of that level; 0 by default.
    #[serde(default)]
    pub x: u32,
    /// First row; 0 by default.
    #[serde(default)]
    pub y: u32,
    /// Its columns; all by default.
    #[param(value_type = Option<u32>, minimum = 1)]
    pub width: Option<NonZeroU32>,
    /// Its rows; all by default.
    #[param(value_type = Option<u32>, minimum = 1)]
    pub height: Option<NonZeroU32>,
    /// How a number is written.
    #[serde(default)]
    #[param(inline)]
    pub format: Format,
}

/// How a number is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Format {
    /// 32 bits.
    #[default]
    Float,
    /// 16 bits; above 65504 infinite.
    Half,
}

fn color() -> String {
    COLOR.to_owned()
}

impl PixelsQuery {
    /// The further layer that is meant; none for the picture itself.
    #[expect(clippy::result_large_err, reason = "made at most once a request")]
    fn further_layer(&self) -> Result<Option<Layer>, Problem> {
        if self.layer == COLOR {
            return Ok(None);
        }
        if self.layer.starts_with(OF_LIGHT_GROUP) {
            return Ok(Some(Layer::LightGroups));
        }
        let known = || format!("known layers: {COLOR}, {}", Layer::known_to_look_at());
        match Layer::parse_list(&self.layer).map_err(|unknown| Problem::bad_request(unknown.to_string(), known()))?[..]
        {
            [layer] if layer.is_matte() => Err(ids_only_in_exr(layer.row())),
            [layer] => Ok(Some(layer)),
            _ => Err(Problem::bad_request(format!("\"{}\" is not one layer", self.layer), known())),
        }
    }

    /// The part that is meant of a picture of this size.
    #[expect(clippy::result_large_err, reason = "made at most once a request")]
    fn part(&self, size: [u32; 2]) -> Result<Part, Problem> {
        let coarsest = size[0].max(size[1]).next_power_of_two().trailing_zeros();
        if self.level > coarsest {
            let detail = format!("level is {}", self.level);
            return Err(Problem::bad_request(detail, format!("give 0 to {coarsest}, where all of it is one pixel")));
        }
        let whole = size.map(|length| length.div_ceil(1 << self.level));
        let axis = |start: u32, length: Option<NonZeroU32>, whole: u32| {
            let length = length.map_or_else(|| whole.saturating_sub(start), NonZeroU32::get);
            start.checked_add(length).filter(|end| *end <= whole && length > 0).map(|_| length)
        };
        let found = axis(self.x, self.width, whole[0]).zip(axis(self.y, self.height, whole[1]));
        let (width, height) = found.ok_or_else(|| {
            let detail = format!("the part does not lie in the picture's {} × {} pixels", whole[0], whole[1]);
            Problem::bad_request(
                detail,
                "these are pixels of the level asked for; leave x, y, width and height out for all",
            )
        })?;
        Ok(Part { level: self.level, first: [self.x, self.y], size: [width, height] })
    }
}

/// A part of a picture, in pixels of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Part {
    level: u32,
    first: [u32; 2],
    size: [u32; 2],
}

/// The values of a layer as they were at some time.
pub(crate) struct Values {
    /// The job then.
    status: JobStatus,
    /// Names of the channels.
    channels: Vec<String>,
    /// All channels of a pixel beside each other, row-major, top row first.
    values: Vec<f32>,
    made: Instant,
    cost: Duration,
}

impl Values {
    fn new(picture: &Picture, layer: Option<PictureLayer>, status: JobStatus, began: Instant) -> Self {
        let (channels, values) = match layer {
            None => (["R", "G", "B"].map(str::to_owned).to_vec(), picture.radiance.as_flattened().to_vec()),
            Some(layer) => {
                let pixels = 0..layer.channels.first().map_or(0, Vec::len);
                let values = pixels.flat_map(|pixel| layer.channels.iter().map(move |channel| channel[pixel]));
                (layer.channel_names(), values.collect())
            }
        };
        Self { status, channels, values, made: Instant::now(), cost: began.elapsed() }
    }

    /// Whether they may be answered for a job that is now as `status` says.
    fn serve(&self, status: &JobStatus) -> bool {
        let is_newest = etag(&self.status, "") == etag(status, "");
        is_newest || (!status.state.is_final() && self.made.elapsed() < self.cost * REST)
    }

    /// The channels that a request means: those of one light group, or all.
    #[expect(clippy::result_large_err, reason = "made at most once a request")]
    fn chosen(&self, query: &PixelsQuery) -> Result<Range<usize>, Problem> {
        if !query.layer.starts_with(OF_LIGHT_GROUP) {
            return Ok(0..self.channels.len());
        }
        let is_of_group = |channel: &String| channel.rsplit_once('.').is_some_and(|(layer, _)| layer == query.layer);
        let first = self.channels.iter().position(is_of_group).ok_or_else(|| {
            let remedy = format!("it has {}", self.status.light_groups.join(", "));
            Problem::bad_request(format!("the job has no layer \"{}\"", query.layer), remedy)
        })?;
        Ok(first..first + self.channels.iter().filter(|channel| is_of_group(channel)).count())
    }

    /// Means over the blocks of a part, the chosen channels beside each other. Blocks at the right and the lower edge may be smaller.
    fn means(&self, part: Part, chosen: &Range<usize>) -> Vec<f32> {
        let ([width, height], channels) =
            ([self.status.width as usize, self.status.height as usize], self.channels.len());
        let range =
            |first: u32, end: usize| ((first as usize) << part.level)..(((first as usize + 1) << part.level).min(end));
        let mut means = Vec::with_capacity(part.size[0] as usize * part.size[1] as usize * chosen.len());
        let mut sums = vec![0.0f64; chosen.len()];
        for row in part.first[1]..part.first[1] + part.size[1] {
            if part.level == 0 {
                let start = row as usize * width + part.first[0] as usize;
                let row = &self.values[start * channels..(start + part.size[0] as usize) * channels];
                match chosen.len() == channels {
                    true => means.extend_from_slice(row),
                    false => {
                        row.chunks_exact(channels).for_each(|pixel| means.extend_from_slice(&pixel[chosen.clone()]))
                    }
                }
                continue;
            }
            for column in part.first[0]..part.first[0] + part.size[0] {
                let (rows, columns) = (range(row, height), range(column, width));
                let count = (rows.len() * columns.len()) as f64;
                sums.fill(0.0);
                for y in rows {
                    let block =
                        &self.values[(y * width + columns.start) * channels..(y * width + columns.end) * channels];
                    for pixel in block.chunks_exact(channels) {
                        let pixel = pixel[chosen.clone()].iter();
                        pixel.zip(&mut sums).for_each(|(value, sum)| *sum += f64::from(*value));
                    }
                }
                means.extend(sums.iter().map(|sum| (sum / count) as f32));
            }
        }
        means
    }
}

/// Values that were asked for not long ago.
#[derive(Clone, Default)]
pub(crate) struct PixelCache {
    kept: Arc<Mutex<Vec<Kept>>>,
    /// Whoever makes values holds it, so that many who ask at once wait for one.
    turn: Arc<tokio::sync::Mutex<()>>,
}

struct Kept {
    job: JobId,
    layer: Option<Layer>,
    values: Arc<Values>,
}

impl PixelCache {
    /// The values of a layer, which are made where there are none or they are too old.
    async fn values(&self, state: &ApiState, id: JobId, layer: Option<Layer>) -> Result<Arc<Values>, Problem> {
        if let Some(found) = self.find(id, layer, &state.coordinator.job(id)?) {
            return Ok(found);
        }
        // What a worker has to look at first takes long and is waited for elsewhere; so does what is denoised.
        let is_merged = !layer.is_some_and(Layer::needs_first_surfaces);
        let _turn = if is_merged { Some(self.turn.lock().await) } else { None };
        if let Some(found) = self.find(id, layer, &state.coordinator.job(id)?) {
            return Ok(found);
        }
        let began = Instant::now();
        let LayeredPicture { picture, mut layers, status, .. } =
            state.coordinator.picture_with_layers(id, layer.as_slice()).await?;
        let made = tokio::task::spawn_blocking(move || Values::new(&picture, layers.pop(), status, began)).await;
        let values = Arc::new(made.map_err(|error| FarmError::Internal(error.to_string()))?);
        self.keep(Kept { job: id, layer, values: values.clone() });
        Ok(values)
    }

    fn find(&self, job: JobId, layer: Option<Layer>, status: &JobStatus) -> Option<Arc<Values>> {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let found = kept.iter().find(|kept| kept.job == job && kept.layer == layer)?;
        Some(found.values.clone()).filter(|values| values.serve(status))
    }

    fn keep(&self, new: Kept) {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.retain(|old| (old.job, old.layer) != (new.job, new.layer));
        let bytes = |kept: &Kept| size_of_val(kept.values.values.as_slice());
        // The newest are at the end; the oldest go first.
        while !kept.is_empty() && kept.iter().map(bytes).sum::<usize>() + bytes(&new) > KEPT_BYTES {
            kept.remove(0);
        }
        let made = new.values.made;
        kept.push(new);
        let all = self.kept.clone();
        tokio::spawn(async move {
            tokio::time::sleep(KEPT_FOR).await;
            all.lock().unwrap_or_else(PoisonError::into_inner).retain(|kept| kept.values.made > made);
        });
    }
}

/// The numbers of a layer of the picture so far, little-endian, rows from the top, the channels of a pixel beside each other. Of a job that runs they
/// may be some passes old; the answer says how many passes they have.
#[utoipa::path(
    get, path = "/jobs/{id}/pixels", tag = "images",
    params(("id" = String, Path, description = "The job's id"), PixelsQuery),
    responses(
        (status = 200, description = "The numbers", body = inline(Bytes), content_type = "application/octet-stream",
            headers(("ETag" = String), ("Photonfarm-Width" = u32, description = "Pixels of a row of the answer"),
                ("Photonfarm-Height" = u32, description = "Rows of the answer"),
                ("Photonfarm-Level" = u32), ("Photonfarm-Channels" = String, description = "Their names, separated by commas"),
                ("Photonfarm-Passes" = u32, description = "Passes that the numbers have"))),
        (status = 304, description = "The same as If-None-Match names"),
        (status = 400, description = "Unknown parameters", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such job, or no picture yet", body = Problem,
            content_type = "application/problem+json"),
        (status = 409, description = "It cannot be denoised yet", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "No such layer, level or part", body = Problem, content_type = "application/problem+json"),
    )
)]
pub(crate) async fn pixels(
    State(state): State<ApiState>,
    Extension(cache): Extension<PixelCache>,
    PathValue(id): PathValue<String>,
    QueryValues(query): QueryValues<PixelsQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let layer = query.further_layer()?;
    let id = parse_job(&id)?;
    let status = state.coordinator.job(id)?;
    let part = query.part([status.width, status.height])?;
    let variant = format!("{query:?}");
    if let Some(unchanged) = unchanged(&status, &variant, &headers) {
        return Ok(unchanged);
    }
    let values = cache.values(&state, id, layer).await?;
    if let Some(unchanged) = unchanged(&values.status, &variant, &headers) {
        return Ok(unchanged);
    }
    let chosen = values.chosen(&query)?;
    let shown = [
        ("photonfarm-level", part.level.to_string()),
        ("photonfarm-width", part.size[0].to_string()),
        ("photonfarm-height", part.size[1].to_string()),
        ("photonfarm-channels", values.channels[chosen.clone()].join(",")),
        ("photonfarm-passes", values.status.passes_done.to_string()),
    ];
    let fixed = [
        (header::CONTENT_TYPE, "application/octet-stream".to_owned()),
        (header::CACHE_CONTROL, "private, no-cache".to_owned()),
        (header::ETAG, etag(&values.status, &variant)),
    ];
    let written = tokio::task::spawn_blocking(move || write(&values.means(part, &chosen), query.format)).await;
    let bytes = written.map_err(|error| FarmError::Internal(error.to_string()))?;
    Ok((fixed, shown.map(|(name, value)| (HeaderName::from_static(name), value)), bytes).into_response())
}

fn write(values: &[f32], format: Format) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(size_of_val(values));
    for value in values {
        match format {
            Format::Float => bytes.extend_from_slice(&value.to_le_bytes()),
            Format::Half => bytes.extend_from_slice(&half_bits(*value).to_le_bytes()),
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_lie_in_the_picture() {
        let query = |level, x, width| PixelsQuery {
            layer: color(),
            level,
            x,
            y: 0,
            width: NonZeroU32::new(width),
            height: None,
            format: Format::Half,
        };
        let size = |query: PixelsQuery| query.part([100, 50]).map(|part| part.size).ok();
        assert_eq!(size(query(0, 0, 0)), Some([100, 50]));
        assert_eq!(size(query(3, 0, 0)), Some([13, 7]));
        assert_eq!(size(query(7, 0, 0)), Some([1, 1]));
        assert_eq!(size(query(8, 0, 0)), None);
        assert_eq!(size(query(3, 12, 1)), Some([1, 7]));
        assert_eq!([size(query(3, 12, 2)), size(query(3, 13, 0)), size(query(0, u32::MAX, 1))], [None; 3]);
    }
}
