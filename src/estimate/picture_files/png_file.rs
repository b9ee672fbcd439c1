//! PNG files of pictures as they are and of drawings.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use super::PictureFileError;
use super::display_file::{Display, DisplayFormat, encode_display};
use super::exposure::Exposure;
use super::tone::ToneCurve;
use crate::estimate::Picture;

/// Encodes a picture after multiplying it by `2^exposure` (`exposure` in stops), as 8-bit sRGB: nothing else is done to it.
pub fn encode_png(picture: &Picture, exposure: f32) -> Result<Vec<u8>, PictureFileError> {
    let display = Display { exposure: Exposure::Stops(exposure), tone: ToneCurve::Linear };
    encode_display(picture, display, DisplayFormat::Png)
}

/// Encodes a drawing: red, green and blue bytes as they are, row by row from the top. Its even areas are smallest without a filter.
pub fn encode_png_bytes(bytes: &[u8], width: u32, height: u32) -> Result<Vec<u8>, PictureFileError> {
    let mut file = Vec::new();
    PngEncoder::new_with_quality(&mut file, CompressionType::Default, FilterType::NoFilter)
        .write_image(bytes, width, height, ExtendedColorType::Rgb8)
        .map_err(|error| PictureFileError::Encode { problem: error.to_string() })?;
    Ok(file)
}
