//! Several pictures as one animated PNG, which browsers play.

use image::ImageFormat;
use png::{BitDepth, ColorType, Encoder};

use super::PictureFileError;

/// Makes an animation, which begins anew at its end, of the bytes of PNG files of one size.
///
/// # Errors
/// When there is none, or one has another size.
pub fn encode_animated_png(frames: &[Vec<u8>], frames_per_second: u16) -> Result<Vec<u8>, PictureFileError> {
    let failed = |problem: String| PictureFileError::Encode { problem };
    let decode = |bytes: &Vec<u8>| {
        let decoded = image::load_from_memory_with_format(bytes, ImageFormat::Png);
        decoded.map(|picture| picture.to_rgb8()).map_err(|error| failed(error.to_string()))
    };
    let first = decode(frames.first().ok_or_else(|| failed("an animation without pictures".to_owned()))?)?;
    let mut file = Vec::new();
    let encoded = |error: png::EncodingError| failed(error.to_string());
    let mut encoder = Encoder::new(&mut file, first.width(), first.height());
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_animated(frames.len() as u32, 0).map_err(encoded)?;
    encoder.set_frame_delay(1, frames_per_second).map_err(encoded)?;
    let mut writer = encoder.write_header().map_err(encoded)?;
    for bytes in frames {
        let picture = decode(bytes)?;
        if picture.dimensions() != first.dimensions() {
            return Err(failed("the pictures of an animation have several sizes".to_owned()));
        }
        writer.write_image_data(picture.as_raw()).map_err(encoded)?;
    }
    writer.finish().map_err(encoded)?;
    Ok(file)
}
