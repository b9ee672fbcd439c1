//! Pictures as files: OpenEXR for numbers, PNG, JPEG and WebP for eyes.
//!
//! A picture is encoded into memory first and written in one go ([`write_file`]), so a full disk never leaves half a
//! picture. The same picture always gives the same bytes.

mod animated_png;
mod atomic_write;
mod channels;
mod cryptomatte;
mod display_file;
mod exposure;
mod exr_attributes;
mod exr_file;
mod half_precision;
mod layers;
mod png_file;
mod tone;

use std::path::{Path, PathBuf};

pub use animated_png::encode_animated_png;
pub use atomic_write::{check_writable, write_file};
pub use channels::{Channels, LUMINANCE, LayerValues};
pub use cryptomatte::{Matte, MatteHeader, Mattes, RANKS, RAYS_PER_PIXEL, murmur3, name_id};
pub use display_file::{Display, DisplayFormat, JPEG_QUALITY, MOST_JPEG_QUALITY, encode_display};
pub use exposure::{BadExposure, Exposure};
pub use exr_file::{
    decode_channels, decode_exr, encode_channels, encode_exr, encode_half_exr, read_channels, read_exr, read_origin,
    read_standard_error,
};
pub use layers::{LAYERS, Layer, LayerRow, NOTHING_SEEN, OF_LIGHT_GROUP, PictureLayer, UnknownLayer};
pub use png_file::{encode_png, encode_png_bytes};
pub(crate) use tone::srgb_byte;
pub use tone::{TONES, ToneCurve, ToneRow};

/// Where a picture comes from; written into the header of EXR files.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PictureMetadata {
    /// The job's id.
    pub job: String,
    /// Name of the method.
    pub method: String,
    /// All parameters of the method.
    pub parameters: serde_json::Map<String, serde_json::Value>,
    /// Passes merged.
    pub passes: u32,
    /// Photons emitted in them.
    pub photons_emitted: u64,
    /// The job's seed.
    pub seed: u64,
    /// Hash of the scene.
    pub scene: String,
    /// What people call the job.
    pub name: Option<String>,
    /// Who submitted it.
    pub owner: Option<String>,
    /// When it was submitted, seconds since 1970.
    pub submitted: Option<u64>,
    /// From the world to the camera's right, up and forward, m: by rows, for row vectors.
    pub world_to_camera: Option<[f32; 16]>,
    /// From the world to the picture, (0, 0, z) top left to (1, 1, z) bottom right: by rows, for row vectors.
    pub world_to_ndc: Option<[f32; 16]>,
    /// What the picture's mattes are called, and what in them.
    pub mattes: Vec<MatteHeader>,
}

/// What a picture file shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PictureOrigin {
    /// Hash of the scene.
    pub scene: String,
    /// Passes merged.
    pub passes: u32,
}

/// A picture file's format, chosen by the file name's extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// OpenEXR, float, linear.
    Exr,
    /// PNG, sRGB.
    Png,
    /// JPEG, 8 bits, sRGB.
    Jpeg,
    /// WebP without loss, 8 bits, sRGB.
    Webp,
}

impl PictureFormat {
    /// The format that `path` asks for by its extension.
    pub fn of_path(path: &Path) -> Result<Self, PictureFileError> {
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or("");
        match extension.to_ascii_lowercase().as_str() {
            "exr" => Ok(Self::Exr),
            "png" => Ok(Self::Png),
            "jpg" | "jpeg" => Ok(Self::Jpeg),
            "webp" => Ok(Self::Webp),
            _ => Err(PictureFileError::UnknownFormat { path: path.to_owned() }),
        }
    }
}

/// A picture file that cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum PictureFileError {
    /// The extension names no format.
    #[error("\"{path}\" does not say which format it has; end the name in .exr, .png, .jpg or .webp", path = .path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The file system refused.
    #[error("cannot write \"{path}\": {source}; {remedy}", path = .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What it said.
        source: std::io::Error,
        /// What the user can do.
        remedy: &'static str,
    },
    /// The file cannot be read.
    #[error("cannot read \"{path}\": {source}; check the name and the permissions", path = .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the file system said.
        source: std::io::Error,
    },
    /// The bytes are not a picture that can be read.
    #[error("{problem}; give an OpenEXR picture with channels R, G, B or Y")]
    Decode {
        /// What is wrong.
        problem: String,
    },
    /// The picture has no layer of this name.
    #[error("there is no layer \"{name}\"; this picture has {known}")]
    UnknownLayer {
        /// The name.
        name: String,
        /// Those that it has.
        known: String,
    },
    /// The picture does not fit the format.
    #[error("cannot encode the picture: {problem}")]
    Encode {
        /// What is wrong.
        problem: String,
    },
}
