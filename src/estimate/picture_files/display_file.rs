//! Pictures to look at: exposed, through a tone curve, rounded to the code values of an sRGB screen, as PNG, JPEG or WebP.

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::codecs::webp::WebPEncoder;
use image::{ExtendedColorType, ImageEncoder};

use super::PictureFileError;
use super::exposure::Exposure;
use super::tone::{ToneCurve, byte};
use crate::estimate::Picture;

/// How radiance becomes what a screen shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Display {
    /// By how much the picture is multiplied first.
    pub exposure: Exposure,
    /// What then makes code values of it.
    pub tone: ToneCurve,
}

/// The quality of a JPEG file where none is asked for.
pub const JPEG_QUALITY: u8 = 90;
/// The most, the least loss; the least is 1.
pub const MOST_JPEG_QUALITY: u8 = 100;

/// A format of pictures to look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DisplayFormat {
    /// PNG of 8 bits a channel.
    Png,
    /// PNG of 16 bits a channel.
    Png16,
    /// JPEG.
    Jpeg {
        /// From 1 to [`MOST_JPEG_QUALITY`].
        quality: u8,
    },
    /// WebP without loss, 8 bits a channel.
    Webp,
}

impl DisplayFormat {
    /// What HTTP calls it.
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Png | Self::Png16 => "image/png",
            Self::Jpeg { .. } => "image/jpeg",
            Self::Webp => "image/webp",
        }
    }

    /// The most pixels along either side that the format has numbers for.
    pub fn largest_side(self) -> u32 {
        match self {
            Self::Png | Self::Png16 => (1 << 31) - 1,
            Self::Jpeg { .. } => (1 << 16) - 1,
            Self::Webp => 1 << 14,
        }
    }
}

/// Encodes a picture to look at.
pub fn encode_display(picture: &Picture, display: Display, format: DisplayFormat) -> Result<Vec<u8>, PictureFileError> {
    let Picture { width, height, .. } = *picture;
    let factor = display.exposure.factor(picture);
    let exposed = picture.radiance.iter().map(|pixel| pixel.map(|channel| channel * factor));
    let code_values = exposed.flat_map(|color| display.tone.code_values(color));
    let (mut file, color) = (Vec::new(), ExtendedColorType::Rgb8);
    let written = match format {
        DisplayFormat::Png16 => {
            // The encoder takes the bytes of numbers as this machine has them.
            let bytes: Vec<u8> = code_values.flat_map(|value| two_bytes(value).to_ne_bytes()).collect();
            png(&mut file).write_image(&bytes, width, height, ExtendedColorType::Rgb16)
        }
        DisplayFormat::Png => png(&mut file).write_image(&bytes(code_values), width, height, color),
        DisplayFormat::Jpeg { quality } if !(1..=MOST_JPEG_QUALITY).contains(&quality) => {
            let problem = format!("the JPEG quality is {quality} where 1 to {MOST_JPEG_QUALITY} is possible");
            return Err(PictureFileError::Encode { problem });
        }
        DisplayFormat::Jpeg { quality } => {
            JpegEncoder::new_with_quality(&mut file, quality).write_image(&bytes(code_values), width, height, color)
        }
        DisplayFormat::Webp => {
            WebPEncoder::new_lossless(&mut file).write_image(&bytes(code_values), width, height, color)
        }
    };
    written.map_err(|error| PictureFileError::Encode { problem: error.to_string() })?;
    Ok(file)
}

fn png(file: &mut Vec<u8>) -> PngEncoder<&mut Vec<u8>> {
    PngEncoder::new_with_quality(file, CompressionType::Fast, FilterType::Adaptive)
}

fn bytes(code_values: impl Iterator<Item = f32>) -> Vec<u8> {
    code_values.map(byte).collect()
}

/// A code value in 16 bits. Negative and not-a-number give 0.
fn two_bytes(code_value: f32) -> u16 {
    (code_value * 65535.0).round() as u16
}
