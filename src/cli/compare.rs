//! `compare`: how far a picture is from a reference.

use std::path::PathBuf;

use clap::Args;

use super::exit_code::CliError;
use super::terminal;
use crate::estimate::picture_files::{encode_png, read_exr, write_file};
use crate::evaluation::{Metrics, compare, signed_difference, standard_error_of};

/// Measure how far a picture is from a reference.
///
/// Both are OpenEXR files of the same size.
#[derive(Clone, Debug, Args)]
pub(super) struct Compare {
    /// The picture.
    image: PathBuf,
    /// What it should be.
    reference: PathBuf,
    /// The reference's standard error per pixel, as an EXR, in place of its own layer `error`; tells its own part in the error.
    #[arg(long, value_name = "FILE")]
    stderr: Option<PathBuf>,
    /// Also write where the picture is too bright (red) and too dark (blue), as a PNG.
    #[arg(long, value_name = "FILE.png")]
    difference: Option<PathBuf>,
    /// The difference, relative to the reference, that gets the full color.
    #[arg(long, value_name = "SHARE", default_value_t = 0.2, requires = "difference")]
    full: f64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

impl Compare {
    pub(super) fn run(self) -> Result<(), CliError> {
        let image = read_exr(&self.image)?;
        let reference = read_exr(&self.reference)?;
        let standard_error = standard_error_of(&self.reference, self.stderr.as_deref())?;
        let metrics = compare(&image, &reference, standard_error.as_ref());
        let metrics = metrics.map_err(|error| CliError::BadInput(error.to_string()))?;
        if !(self.full > 0.0 && self.full.is_finite()) {
            return Err(CliError::Usage(format!("--full is {}; give a number above 0", self.full)));
        }
        if let Some(path) = &self.difference {
            write_file(path, &encode_png(&signed_difference(&image, &reference, self.full), 0.0)?)?;
        }
        let text =
            if self.json { serde_json::to_string_pretty(&metrics).map_err(CliError::failed)? } else { table(&metrics) };
        terminal::result(&text)
    }
}

fn table(metrics: &Metrics) -> String {
    let percent = |value: f64| format!("{:+.3} %", 100.0 * value);
    let [red, green, blue] = metrics.bias_rgb.map(percent);
    let mut lines = vec![
        format!("RMSE              {:.6e}", metrics.rmse),
        format!("relative RMSE     {:.6e}", metrics.rel_rmse),
        format!("relMSE            {:.6e}", metrics.relmse),
        format!("  without worst 0.1 %  {:.6e}", metrics.relmse_trimmed),
        format!("mean bias         {}", percent(metrics.bias)),
        format!("  red, green, blue  {red}, {green}, {blue}"),
        format!("worst 8×8 block   {:.3} %", 100.0 * metrics.block_bias_max),
    ];
    if let Some(ssim) = metrics.ssim {
        lines.push(format!("SSIM              {ssim:.5}"));
    }
    lines.push(format!("FLIP              {:.5}", metrics.flip));
    if let Some(noise) = &metrics.reference_noise {
        lines.push(format!("reference's own noise: RMSE {:.6e}, relMSE {:.6e}", noise.rmse, noise.relmse));
    }
    lines.join("\n")
}
