//! PNG: 8-bit sRGB. Exposure is the only thing done to the picture; brighter than 1 is white.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use super::PictureFileError;
use crate::estimate::Picture;

/// Encodes a picture after multiplying it by `2^exposure` (`exposure` in stops).
pub fn encode_png(picture: &Picture, exposure: f32) -> Result<Vec<u8>, PictureFileError> {
    let scale = libm::exp2f(exposure);
    let bytes: Vec<u8> = picture.radiance.iter().flatten().map(|radiance| srgb_byte(radiance * scale)).collect();
    encode(&bytes, picture.width, picture.height, CompressionType::Fast, FilterType::Adaptive)
}

/// Encodes a drawing: red, green and blue bytes as they are, row by row from the top. Its even areas are smallest without a filter.
pub fn encode_png_bytes(bytes: &[u8], width: u32, height: u32) -> Result<Vec<u8>, PictureFileError> {
    encode(bytes, width, height, CompressionType::Default, FilterType::NoFilter)
}

fn encode(
    bytes: &[u8],
    width: u32,
    height: u32,
    compression: CompressionType,
    filter: FilterType,
) -> Result<Vec<u8>, PictureFileError> {
    let mut file = Vec::new();
    PngEncoder::new_with_quality(&mut file, compression, filter)
        .write_image(bytes, width, height, ExtendedColorType::Rgb8)
        .map_err(|error| PictureFileError::Encode { problem: error.to_string() })?;
    Ok(file)
}

/// The sRGB transfer function (IEC 61966-2-1) and rounding. Negative and not-a-number give 0.
pub(crate) fn srgb_byte(linear: f32) -> u8 {
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}
