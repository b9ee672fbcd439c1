//! OpenEXR: 32-bit float, linear Rec. 709, with the job in the header.

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, ReadChannels, ReadLayers, Vec2,
    WritableImage, read,
};

use super::exr_attributes::{attributes, sort_attributes};
use super::{PictureFileError, PictureLayer, PictureMetadata};
use crate::estimate::Picture;

/// Encodes a picture with its origin and any further layers: one part, ZIP-compressed, deterministic.
pub fn encode_exr(
    picture: &Picture,
    layers: &[PictureLayer],
    metadata: &PictureMetadata,
) -> Result<Vec<u8>, PictureFileError> {
    let size = Vec2(picture.width as usize, picture.height as usize);
    let color = |index: usize| picture.radiance.iter().map(|pixel| pixel[index]).collect();
    let mut channels = vec![("R", color(0)), ("G", color(1)), ("B", color(2))];
    for PictureLayer { layer, channels: values } in layers {
        let row = layer.row();
        if values.len() != row.channels.len() {
            let problem =
                format!("layer {} has {} channels where {} belong", row.name, values.len(), row.channels.len());
            return Err(PictureFileError::Encode { problem });
        }
        channels.extend(row.channels.iter().copied().zip(values.iter().cloned()));
    }
    if let Some((name, values)) = channels.iter().find(|(_, values)| values.len() != size.area() || values.is_empty()) {
        let problem = format!("channel {name} has {} values for {} × {} pixels", values.len(), size.0, size.1);
        return Err(PictureFileError::Encode { problem });
    }
    let channels = channels.into_iter().map(|(name, values)| AnyChannel::new(name, FlatSamples::F32(values)));
    let layer_attributes = LayerAttributes {
        software_name: Some(concat!("photonfarm ", env!("CARGO_PKG_VERSION")).into()),
        other: attributes(metadata).into_iter().collect(),
        ..LayerAttributes::default()
    };
    let channels = AnyChannels::sort(channels.collect());
    let image = Image::from_layer(Layer::new(size, layer_attributes, Encoding::SMALL_LOSSLESS, channels));
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
    let decode_error = |problem: String| PictureFileError::Decode { problem };
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| decode_error(error.to_string()))?;
    let found = image.layer_data.iter().find_map(|layer| Some((layer.size, color_channels(&layer.channel_data.list)?)));
    let (size, [red, green, blue]) = found.ok_or_else(|| decode_error("there is no color channel".to_owned()))?;
    let dimension =
        |value: usize| u32::try_from(value).map_err(|_| decode_error("the picture is too large".to_owned()));
    let colors = red.values_as_f32().zip(green.values_as_f32()).zip(blue.values_as_f32());
    Ok(Picture {
        width: dimension(size.width())?,
        height: dimension(size.height())?,
        radiance: colors.map(|((red, green), blue)| [red, green, blue]).collect(),
    })
}

/// Reads and decodes an EXR file.
pub fn read_exr(path: &Path) -> Result<Picture, PictureFileError> {
    let bytes = std::fs::read(path).map_err(|source| PictureFileError::Read { path: path.to_owned(), source })?;
    decode_exr(&bytes).map_err(|error| match error {
        PictureFileError::Decode { problem } => {
            PictureFileError::Decode { problem: format!("cannot read \"{}\": {problem}", path.display()) }
        }
        other => other,
    })
}

fn color_channels(list: &[AnyChannel<FlatSamples>]) -> Option<[&FlatSamples; 3]> {
    let named = |name: &str| list.iter().find(|channel| channel.name.eq(name)).map(|channel| &channel.sample_data);
    match (named("R"), named("G"), named("B")) {
        (Some(red), Some(green), Some(blue)) => Some([red, green, blue]),
        _ => named("Y").map(|grey| [grey; 3]),
    }
}
