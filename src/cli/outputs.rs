//! The picture files that `render` and `fetch` write.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};

use super::client::Client;
use super::exit_code::CliError;
use super::progress::passes_of;
use super::terminal;
use crate::estimate::picture_files::{LAYERS, PictureFormat, PictureOrigin, check_writable, read_origin, write_file};
use crate::farm::job::JobStatus;

/// How pictures are written.
#[derive(Clone, Debug, Args)]
pub(super) struct OutputOptions {
    /// File to write, .exr or .png. May be repeated.
    #[arg(short, long = "output", value_name = "FILE")]
    pub(super) outputs: Vec<PathBuf>,
    /// Stops by which PNG files are made brighter, -64 to 64 [default: 0].
    #[arg(long, allow_negative_numbers = true)]
    exposure: Option<f32>,
    /// Further layers of EXR files, separated by commas.
    #[arg(long, value_delimiter = ',', value_parser = layer_names())]
    layers: Vec<String>,
    /// Replace files that hold the same scene after more passes, too; else these stay, and the picture goes to a file beside them.
    #[arg(long)]
    overwrite: bool,
}

impl OutputOptions {
    /// Refuses files of unknown format or in places that cannot be written, and impossible options.
    pub(super) fn check(&self) -> Result<(), CliError> {
        let exposure = self.exposure();
        if !(-64.0..=64.0).contains(&exposure) {
            let text = format!("exposure is {exposure}; give a number of stops from -64 to 64");
            return Err(CliError::BadInput(text));
        }
        let formats = self.outputs.iter().map(|path| PictureFormat::of_path(path)).collect::<Result<Vec<_>, _>>()?;
        self.check_formats(&formats)?;
        self.outputs.iter().try_for_each(|path| Ok(check_writable(path)?))
    }

    /// Refuses options of formats that are not written.
    fn check_formats(&self, formats: &[PictureFormat]) -> Result<(), CliError> {
        if !self.layers.is_empty() && !formats.contains(&PictureFormat::Exr) {
            let text = "--layers goes into EXR files, and none is written; give an -o that ends in .exr";
            return Err(CliError::Usage(text.to_owned()));
        }
        if self.exposure.is_some() && !formats.contains(&PictureFormat::Png) {
            let text = "--exposure changes PNG files, and none is written; give an -o that ends in .png";
            return Err(CliError::Usage(text.to_owned()));
        }
        Ok(())
    }

    fn exposure(&self) -> f32 {
        self.exposure.unwrap_or(0.0)
    }

    /// Fetches the job's picture, writes all files and says which. Tells whether there was a picture.
    pub(super) async fn write(&self, client: &Client, job: &JobStatus) -> Result<bool, CliError> {
        for path in &self.outputs {
            let Some(bytes) = client.image(&job.id, &self.image(path)?).await? else { return Ok(false) };
            let better = if self.overwrite { None } else { passes_if_better(path, job) };
            let target = better.map_or(path.clone(), |_| beside(path, job.passes_done));
            write_file(&target, &bytes)?;
            let kept = better.map_or(String::new(), |passes| {
                format!(
                    "; {} has {} of this scene and stays (--overwrite replaces it)",
                    path.display(),
                    passes_of(passes)
                )
            });
            terminal::note(&format!("wrote {}{kept}", target.display()));
        }
        Ok(true)
    }

    fn image(&self, path: &Path) -> Result<String, CliError> {
        Ok(match PictureFormat::of_path(path)? {
            PictureFormat::Exr => format!("image.exr?layers={}", self.layers.join(",")),
            PictureFormat::Png => format!("image.png?exposure={}", self.exposure()),
        })
    }
}

/// The passes of the picture at `path` if it shows the job's scene after more of them. A PNG file does not say so: the EXR file of its name does.
fn passes_if_better(path: &Path, job: &JobStatus) -> Option<u32> {
    let there = path.try_exists().unwrap_or(false);
    let PictureOrigin { scene, passes } = read_origin(&path.with_extension("exr")).filter(|_| there)?;
    (scene == job.scene && passes > job.passes_done).then_some(passes)
}

/// `name.16-passes.exr` beside `name.exr`.
fn beside(path: &Path, passes: u32) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!(".{}", passes_of(passes).replace(' ', "-")));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

fn layer_names() -> PossibleValuesParser {
    LAYERS.map(|row| PossibleValue::new(row.name).help(row.description())).into()
}

/// `<name>.exr` and `<name>.png` in the current folder. A scene file that is called `scene` has its folder's name.
pub(super) fn default_outputs(scene: &Path) -> Vec<PathBuf> {
    let full = std::path::absolute(scene).unwrap_or_else(|_| scene.to_owned());
    let folder = full.parent().and_then(Path::file_name);
    let name = match full.file_stem() {
        Some(stem) if stem == "scene" => folder.unwrap_or(stem),
        Some(stem) => stem,
        None => "picture".as_ref(),
    };
    ["exr", "png"]
        .map(|extension| {
            let mut file = name.to_owned();
            file.push(format!(".{extension}"));
            PathBuf::from(file)
        })
        .to_vec()
}
