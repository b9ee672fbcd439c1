//! OpenEXR: 32-bit or 16-bit float, linear Rec. 709, with the job in the header.

use std::io::Cursor;
use std::path::Path;

use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, Layers, ReadChannels, ReadLayers, Vec2,
    WritableImage, read,
};

use super::exr_attributes::{PASSES, REC_709, SCENE, attributes, sort_attributes};
use super::half_precision::{half_layers, half_samples, layer_of};
use super::{Channels, PictureFileError, PictureLayer, PictureMetadata, PictureOrigin};
use crate::estimate::Picture;

/// Encodes a picture with its origin and any further layers: one part, ZIP-compressed, deterministic.
pub fn encode_exr(
    picture: &Picture,
    layers: &[PictureLayer],
    metadata: &PictureMetadata,
) -> Result<Vec<u8>, PictureFileError> {
    encode_channels(Channels::of(picture, layers)?, metadata)
}

/// The same with 16-bit floats for colors and directions: three decimal digits, up to 65504. A layer with larger numbers stays at 32 bits, and so
/// do layers that [`allows_half`](super::LayerRow::allows_half) excepts.
pub fn encode_half_exr(
    picture: &Picture,
    layers: &[PictureLayer],
    metadata: &PictureMetadata,
) -> Result<Vec<u8>, PictureFileError> {
    let channels = Channels::of(picture, layers)?;
    let half = half_layers(&channels.named);
    encode(channels, &half, metadata)
}

/// Encodes channels of any names with their origin, as [`encode_exr`] does.
pub fn encode_channels(channels: Channels, metadata: &PictureMetadata) -> Result<Vec<u8>, PictureFileError> {
    encode(channels, &[], metadata)
}

/// Encodes channels, those of the layers `half` with 16 bits.
fn encode(channels: Channels, half: &[String], metadata: &PictureMetadata) -> Result<Vec<u8>, PictureFileError> {
    let size = Vec2(channels.width as usize, channels.height as usize);
    let channels = channels.named;
    if let Some((name, values)) = channels.iter().find(|(_, values)| values.len() != size.area() || values.is_empty()) {
        let problem = format!("channel {name} has {} values for {} × {} pixels", values.len(), size.0, size.1);
        return Err(PictureFileError::Encode { problem });
    }
    let channels = channels.into_iter().map(|(name, values)| {
        let is_half = half.iter().any(|layer| layer == layer_of(&name));
        AnyChannel::new(name.as_str(), if is_half { half_samples(&values) } else { FlatSamples::F32(values) })
    });
    let channels = AnyChannels::sort(channels.collect());
    let mut image = Image::from_layer(Layer::new(size, attributes(metadata), Encoding::SMALL_LOSSLESS, channels));
    image.attributes.chromaticities = Some(REC_709);
    let mut file = Cursor::new(Vec::new());
    let written = image.write().non_parallel().to_buffered(&mut file);
    written.map_err(|error| PictureFileError::Encode { problem: error.to_string() })?;
    let mut file = file.into_inner();
    sort_attributes(&mut file)?;
    Ok(file)
}

/// Decodes the colour of any EXR picture with 16- or 32-bit channels R, G, B or one channel Y (then grey); the first
/// part that has them. Other channels are skipped.
pub fn decode_exr(bytes: &[u8]) -> Result<Picture, PictureFileError> {
    let image = decode(bytes)?;
    let found = image.layer_data.iter().find_map(|layer| Some((layer.size, color_channels(&layer.channel_data.list)?)));
    let (size, [red, green, blue]) = found.ok_or_else(|| decode_error("there is no color channel"))?;
    let colors = red.values_as_f32().zip(green.values_as_f32()).zip(blue.values_as_f32());
    Ok(Picture {
        width: dimension(size.width())?,
        height: dimension(size.height())?,
        radiance: colors.map(|((red, green), blue)| [red, green, blue]).collect(),
    })
}

/// Decodes all channels of an EXR picture; of several parts, those that are as large as the first, named `part.channel`.
pub fn decode_channels(bytes: &[u8]) -> Result<Channels, PictureFileError> {
    let parts = decode(bytes)?.layer_data;
    let (size, several) = (parts.first().map_or(Vec2(0, 0), |part| part.size), parts.len() > 1);
    let mut named = Vec::new();
    for part in parts.into_iter().filter(|part| part.size == size) {
        let prefix = part.attributes.layer_name.filter(|_| several).map_or(String::new(), |name| format!("{name}."));
        let channels = part.channel_data.list.into_iter();
        named.extend(
            channels
                .map(|channel| (format!("{prefix}{}", channel.name), channel.sample_data.values_as_f32().collect())),
        );
    }
    Ok(Channels { width: dimension(size.width())?, height: dimension(size.height())?, named })
}

/// Reads and decodes an EXR file.
pub fn read_exr(path: &Path) -> Result<Picture, PictureFileError> {
    read_file(path, decode_exr)
}

/// Reads and decodes all channels of an EXR file.
pub fn read_channels(path: &Path) -> Result<Channels, PictureFileError> {
    read_file(path, decode_channels)
}

/// Which scene an EXR file shows after how many passes, as its header tells; `None` where it does not, or there is no such file.
pub fn read_origin(path: &Path) -> Option<PictureOrigin> {
    let headers = MetaData::read_from_file(path, false).ok()?.headers;
    let attributes = &headers.first()?.own_attributes.other;
    let text = |name: &str| match attributes.get(&Text::from(name))? {
        AttributeValue::Text(text) => Some(text.to_string()),
        _ => None,
    };
    Some(PictureOrigin { scene: text(SCENE)?, passes: text(PASSES)?.parse().ok()? })
}

/// The standard error of each channel, as the layer `error` of an EXR file tells it; `None` when the file has none, or not everywhere.
pub fn read_standard_error(path: &Path) -> Result<Option<Picture>, PictureFileError> {
    let channels = read_channels(path)?;
    let known = channels.layer(super::Layer::Error.row().name).ok();
    let known = known.filter(|layer| layer.values.iter().all(|value| value.is_finite()));
    Ok(known.map(|layer| Picture {
        width: channels.width,
        height: channels.height,
        radiance: layer.values.iter().map(|value| [*value; 3]).collect(),
    }))
}

fn read_file<T>(path: &Path, decoder: fn(&[u8]) -> Result<T, PictureFileError>) -> Result<T, PictureFileError> {
    let bytes = std::fs::read(path).map_err(|source| PictureFileError::Read { path: path.to_owned(), source })?;
    decoder(&bytes).map_err(|error| match error {
        PictureFileError::Decode { problem } => {
            PictureFileError::Decode { problem: format!("cannot read \"{}\": {problem}", path.display()) }
        }
        other => other,
    })
}

/// All parts of a file.
fn decode(bytes: &[u8]) -> Result<Image<Layers<AnyChannels<FlatSamples>>>, PictureFileError> {
    read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| decode_error(&error.to_string()))
}

fn decode_error(problem: &str) -> PictureFileError {
    PictureFileError::Decode { problem: problem.to_owned() }
}

fn dimension(value: usize) -> Result<u32, PictureFileError> {
    u32::try_from(value).map_err(|_| decode_error("the picture is too large"))
}

fn color_channels(list: &[AnyChannel<FlatSamples>]) -> Option<[&FlatSamples; 3]> {
    let named = |name: &str| list.iter().find(|channel| channel.name.eq(name)).map(|channel| &channel.sample_data);
    match (named("R"), named("G"), named("B")) {
        (Some(red), Some(green), Some(blue)) => Some([red, green, blue]),
        _ => named("Y").map(|grey| [grey; 3]),
    }
}
