//! Image files to rasters. Sizes are checked before anything is decoded.

use std::io::Cursor;

use exr::meta::MetaData;
use exr::prelude::{AnyChannel, FlatSamples, ReadChannels, ReadLayers, read};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::raster::{Raster, Texels, decoded_bytes, linear};
use super::reader::ImageChoice;

/// The most memory that a decoded image may take, bytes.
const MOST_BYTES: u64 = 1 << 30;

/// Samples as files hold them: 1 to 4 channels, grey or color, perhaps with alpha.
struct Samples {
    size: [usize; 2],
    channels: usize,
    values: Values,
}

enum Values {
    Bytes(Vec<u8>),
    /// Shares of the largest integer.
    Integers(Vec<f32>),
    Floats(Vec<f32>),
}

/// Decodes an image file. `name` tells a TGA, which nothing else marks.
///
/// # Errors
/// A lowercase fragment that says what is wrong, and the remedy.
pub(super) fn decode(bytes: &[u8], name: &str, choice: ImageChoice) -> Result<Raster, (String, &'static str)> {
    let samples = match format(bytes, name)? {
        ImageFormat::OpenExr => decode_exr(bytes),
        format => decode_other(bytes, format),
    };
    let samples = samples.map_err(|problem| (problem, "save it again, or check that it is complete"))?;
    if samples.size.contains(&0) {
        return Err(("the image has no pixels".to_owned(), "give an image of at least 1 × 1"));
    }
    let [width, height] = samples.size;
    let texels = texels(samples, choice);
    let finite = match &texels {
        Texels::GreyFloats(numbers) => numbers.iter().all(|number| number.is_finite()),
        Texels::ColorFloats(numbers) => numbers.iter().flatten().all(|number| number.is_finite()),
        Texels::GreyBytes(..) | Texels::ColorBytes(..) => true,
    };
    if !finite {
        return Err(("the image has values that are not finite".to_owned(), "replace NaN and infinity in it"));
    }
    Ok(Raster::new(width, height, texels))
}

fn format(bytes: &[u8], name: &str) -> Result<ImageFormat, (String, &'static str)> {
    let tga = name.rsplit('.').next().is_some_and(|extension| extension.eq_ignore_ascii_case("tga"));
    match image::guess_format(bytes) {
        Ok(
            format
            @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::Hdr | ImageFormat::OpenExr | ImageFormat::Bmp),
        ) => Ok(format),
        _ if tga => Ok(ImageFormat::Tga),
        _ => Err((
            "the file is no image that can be read".to_owned(),
            "use PNG, JPEG, OpenEXR, Radiance HDR, TGA or BMP",
        )),
    }
}

fn too_large(width: impl Into<u64>, height: impl Into<u64>) -> String {
    let limit = MOST_BYTES >> 30;
    format!("an image of {} × {} would take more than {limit} GiB of memory", width.into(), height.into())
}

fn decode_other(bytes: &[u8], format: ImageFormat) -> Result<Samples, String> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(|error| error.to_string())?;
    let (width, height) = decoder.dimensions();
    if decoder.total_bytes() > MOST_BYTES {
        return Err(too_large(width, height));
    }
    let image = DynamicImage::from_decoder(decoder).map_err(|error| error.to_string())?;
    let shares = |integers: Vec<u16>| Values::Integers(integers.into_iter().map(|n| f32::from(n) / 65535.0).collect());
    let (channels, values) = match image {
        DynamicImage::ImageLuma8(image) => (1, Values::Bytes(image.into_raw())),
        DynamicImage::ImageLumaA8(image) => (2, Values::Bytes(image.into_raw())),
        DynamicImage::ImageRgb8(image) => (3, Values::Bytes(image.into_raw())),
        DynamicImage::ImageRgba8(image) => (4, Values::Bytes(image.into_raw())),
        DynamicImage::ImageLuma16(image) => (1, shares(image.into_raw())),
        DynamicImage::ImageLumaA16(image) => (2, shares(image.into_raw())),
        DynamicImage::ImageRgb16(image) => (3, shares(image.into_raw())),
        DynamicImage::ImageRgba16(image) => (4, shares(image.into_raw())),
        other => (3, Values::Floats(other.into_rgb32f().into_raw())),
    };
    Ok(Samples { size: [width as usize, height as usize], channels, values })
}

/// The first part of an OpenEXR file that has channels R, G and B, or one channel Y.
fn decode_exr(bytes: &[u8]) -> Result<Samples, String> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|error| error.to_string())?;
    let mut total = 0_u64;
    for header in &meta.headers {
        let [width, height] = [header.layer_size.width() as u64, header.layer_size.height() as u64];
        let channels = header.channels.list.len() as u64;
        total = total.saturating_add(width.saturating_mul(height).saturating_mul(4 * channels));
        if total > MOST_BYTES {
            return Err(too_large(width, height));
        }
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| error.to_string())?;
    let found = image.layer_data.iter().find_map(|layer| Some((layer.size, channels(&layer.channel_data.list)?)));
    let (size, channels) = found.ok_or_else(|| "the image has no channels R, G, B, and no channel Y".to_owned())?;
    let mut values = vec![0.0; size.area() * channels.len()];
    for (index, channel) in channels.iter().enumerate() {
        for (texel, value) in values.chunks_exact_mut(channels.len()).zip(channel.values_as_f32()) {
            texel[index] = value;
        }
    }
    Ok(Samples { size: [size.width(), size.height()], channels: channels.len(), values: Values::Floats(values) })
}

fn channels(list: &[AnyChannel<FlatSamples>]) -> Option<Vec<&FlatSamples>> {
    let named = |name: &str| list.iter().find(|channel| channel.name.eq(name)).map(|channel| &channel.sample_data);
    let mut found = match (named("R"), named("G"), named("B")) {
        (Some(red), Some(green), Some(blue)) => vec![red, green, blue],
        _ => vec![named("Y")?],
    };
    found.extend(named("A"));
    // Channels of fewer samples than pixels (luminance-chroma files) have no place in a raster.
    found.iter().all(|channel| channel.len() == found[0].len()).then_some(found)
}

/// The chosen channels. Alpha is always linear, and 1 where there is none.
fn texels(samples: Samples, choice: ImageChoice) -> Texels {
    let count = samples.channels;
    let colors = if count < 3 { 1 } else { 3 };
    let picked = match choice.channel {
        None if colors == 3 => return color_texels(samples, choice),
        None => 0,
        Some(3) if count == colors => {
            let texels = samples.size[0] * samples.size[1];
            return Texels::GreyBytes(vec![255; texels], decoded_bytes(false));
        }
        Some(3) => colors,
        Some(channel) => channel.min(colors - 1),
    };
    let srgb = !choice.raw && picked < colors;
    match samples.values {
        Values::Bytes(bytes) => {
            Texels::GreyBytes(bytes.into_iter().skip(picked).step_by(count).collect(), decoded_bytes(srgb))
        }
        Values::Integers(shares) => {
            let decode = |share: f32| if srgb { linear(share) } else { share };
            Texels::GreyFloats(shares.into_iter().skip(picked).step_by(count).map(decode).collect())
        }
        Values::Floats(numbers) => Texels::GreyFloats(numbers.into_iter().skip(picked).step_by(count).collect()),
    }
}

fn color_texels(samples: Samples, choice: ImageChoice) -> Texels {
    let count = samples.channels;
    match samples.values {
        Values::Bytes(bytes) => {
            let texels = bytes.chunks_exact(count).map(|texel| [texel[0], texel[1], texel[2]]);
            Texels::ColorBytes(texels.collect(), decoded_bytes(!choice.raw))
        }
        Values::Integers(shares) => {
            let decode = |share: f32| if choice.raw { share } else { linear(share) };
            let texels = shares.chunks_exact(count).map(|texel| [texel[0], texel[1], texel[2]].map(decode));
            Texels::ColorFloats(texels.collect())
        }
        Values::Floats(numbers) => {
            Texels::ColorFloats(numbers.chunks_exact(count).map(|texel| [texel[0], texel[1], texel[2]]).collect())
        }
    }
}
