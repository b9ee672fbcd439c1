//! `map`: a layer of a picture in false colors.

use std::path::PathBuf;

use clap::Args;

use super::chart::drawing_encoder;
use super::exit_code::CliError;
use crate::estimate::picture_files::{LUMINANCE, check_writable, read_channels, write_file};
use crate::evaluation::chart::{ScaleRequest, Spacing, draw_layer};

/// Draw a layer of a picture in false colors, with its scale.
///
/// Without further options the scale covers nearly all values, and is logarithmic where they are positive and differ much. Grey
/// is what has no value: not a number, infinite, nothing seen, or not above 0 on a logarithmic scale.
#[derive(Clone, Debug, Args)]
pub(super) struct Map {
    /// The picture, an OpenEXR file.
    image: PathBuf,
    /// Layer or channel, for example radius, error or normal.X.
    #[arg(long, default_value = LUMINANCE)]
    layer: String,
    /// File to write, .svg or .png. May be repeated.
    #[arg(short, long = "output", value_name = "FILE", required = true)]
    outputs: Vec<PathBuf>,
    /// Linear scale.
    #[arg(long, conflicts_with = "log")]
    linear: bool,
    /// Logarithmic scale.
    #[arg(long)]
    log: bool,
    /// Value of the first color.
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    low: Option<f64>,
    /// Value of the last color.
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    high: Option<f64>,
}

impl Map {
    pub(super) fn run(self) -> Result<(), CliError> {
        let encoder = |path: &PathBuf| {
            drawing_encoder(path).ok_or_else(|| {
                let text = format!("\"{}\" does not say what it is; end the name in .svg or .png", path.display());
                CliError::Usage(text)
            })
        };
        let encoders = self.outputs.iter().map(encoder).collect::<Result<Vec<_>, _>>()?;
        self.check_scale()?;
        for path in &self.outputs {
            check_writable(path)?;
        }
        let channels = read_channels(&self.image)?;
        let layer = channels.layer(&self.layer)?;
        let spacing = match (self.linear, self.log) {
            (true, _) => Some(Spacing::Linear),
            (_, true) => Some(Spacing::Logarithmic),
            _ => None,
        };
        let request = ScaleRequest { spacing, low: self.low, high: self.high };
        let note = self.image.file_name().unwrap_or_default().to_string_lossy();
        let drawing = draw_layer(layer, [channels.width, channels.height], &note, request)
            .map_err(|error| CliError::BadInput(format!("cannot draw layer {}: {error}", self.layer)))?;
        for (path, encode) in self.outputs.iter().zip(encoders) {
            write_file(path, &encode(&drawing).map_err(CliError::failed)?)?;
        }
        Ok(())
    }

    /// Refuses a scale that no picture can have.
    fn check_scale(&self) -> Result<(), CliError> {
        let text = match (self.low, self.high) {
            (Some(low), Some(high)) if low >= high => {
                format!("the scale would go from {low} to {high}; give --low below --high")
            }
            (Some(low), _) if self.log && low <= 0.0 => {
                format!("a logarithmic scale cannot begin at {low}; give --low above 0, or --linear")
            }
            _ => return Ok(()),
        };
        Err(CliError::Usage(text))
    }
}
