//! The picture files that `render` and `fetch` write.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};

use super::client::{Client, Fetched};
use super::exit_code::CliError;
use super::frames::file_of_frame;
use super::progress::passes_of;
use super::scene_input::picture_name;
use super::terminal;
use crate::estimate::picture_files::{
    Exposure, JPEG_QUALITY, LAYERS, Layer, PictureFormat, PictureOrigin, TONES, ToneCurve, check_writable, read_origin,
    write_file,
};
use crate::farm::job::JobStatus;

/// How pictures are written.
#[derive(Clone, Debug, Args)]
pub(super) struct OutputOptions {
    /// File to write: .exr, or to look at .png, .jpg or .webp. May be repeated.
    #[arg(short, long = "output", value_name = "FILE")]
    pub(super) outputs: Vec<PathBuf>,
    /// Stops by which pictures to look at are made brighter, -64 to 64, or auto: so many that the log-average luminance becomes 0.18 [default: 0].
    #[arg(long, allow_negative_numbers = true, value_name = "STOPS")]
    exposure: Option<Exposure>,
    /// Curve by which pictures to look at are made of radiance [default: linear].
    #[arg(long, value_parser = tone_names())]
    tone: Option<String>,
    /// Bits a channel of PNG files [default: 8].
    #[arg(long, value_parser = ["8", "16"])]
    bits: Option<String>,
    /// Quality of JPEG files, 1 (smallest) to 100 (least loss) [default: 90].
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=100))]
    quality: Option<u8>,
    /// Further layers of EXR files, separated by commas.
    #[arg(long, value_delimiter = ',', value_parser = layer_names())]
    pub(super) layers: Vec<String>,
    /// Also filter the noise out: EXR files get the layers denoised and denoised_error beside the picture as it is, and files to look at show the
    /// denoised picture.
    #[arg(long)]
    denoise: bool,
    /// Write colors and directions of EXR files as 16-bit floats; distances, places, counts, errors, ids and what is beyond 65504 stay at 32 bits.
    #[arg(long)]
    half: bool,
    /// Replace files that hold the same scene after more passes, too; else these stay, and the picture goes to a file beside them.
    #[arg(long)]
    overwrite: bool,
}

impl OutputOptions {
    /// Refuses files of unknown format or in places that cannot be written, and impossible options.
    pub(super) fn check(&self) -> Result<(), CliError> {
        let exposure = self.exposure();
        if !exposure.is_possible() {
            let text = format!("exposure is {exposure}; give a number of stops from -64 to 64, or auto");
            return Err(CliError::Usage(text));
        }
        let formats = self.outputs.iter().map(|path| PictureFormat::of_path(path)).collect::<Result<Vec<_>, _>>()?;
        self.check_formats(&formats)?;
        self.outputs.iter().try_for_each(|path| Ok(check_writable(path)?))
    }

    /// Refuses to keep light groups apart for files that cannot hold them.
    pub(super) fn check_light_groups(&self) -> Result<(), CliError> {
        let is_exr = |path: &PathBuf| matches!(PictureFormat::of_path(path), Ok(PictureFormat::Exr));
        if self.outputs.iter().any(is_exr) {
            return Ok(());
        }
        let text = "--light-groups goes into EXR files, and none is written; give an -o that ends in .exr";
        Err(CliError::Usage(text.to_owned()))
    }

    /// Refuses options of formats that are not written.
    fn check_formats(&self, formats: &[PictureFormat]) -> Result<(), CliError> {
        let display = [PictureFormat::Png, PictureFormat::Jpeg, PictureFormat::Webp];
        let [exr, png, jpeg] = [[PictureFormat::Exr], [PictureFormat::Png], [PictureFormat::Jpeg]];
        let rows: [(bool, &str, &[PictureFormat], &str); 6] = [
            (!self.layers.is_empty(), "--layers goes into EXR files", &exr, ".exr"),
            (self.half, "--half changes EXR files", &exr, ".exr"),
            (self.exposure.is_some(), "--exposure changes pictures to look at", &display, ".png, .jpg or .webp"),
            (self.tone.is_some(), "--tone changes pictures to look at", &display, ".png, .jpg or .webp"),
            (self.bits.is_some(), "--bits changes PNG files", &png, ".png"),
            (self.quality.is_some(), "--quality changes JPEG files", &jpeg, ".jpg"),
        ];
        let is_lost = |fitting: &[PictureFormat]| !formats.iter().any(|format| fitting.contains(format));
        match rows.into_iter().find(|(is_given, _, fitting, _)| *is_given && is_lost(fitting)) {
            Some((_, what, _, end)) => {
                Err(CliError::Usage(format!("{what}, and none is written; give an -o that ends in {end}")))
            }
            None => Ok(()),
        }
    }

    /// The same for a frame of a sequence: its number goes into the files' names.
    pub(super) fn of_frame(&self, number: u32) -> Self {
        Self { outputs: self.outputs.iter().map(|path| file_of_frame(path, number)).collect(), ..self.clone() }
    }

    /// What is asked of a coordinator for a frame of a preview.
    pub(super) fn preview_image(&self) -> String {
        format!("image.png?{}&bits=8", self.display())
    }

    fn exposure(&self) -> Exposure {
        self.exposure.unwrap_or_default()
    }

    /// Fetches the job's picture, writes all files and says which. Tells whether there was a picture.
    pub(super) async fn write(&self, client: &Client, job: &JobStatus) -> Result<bool, CliError> {
        let mut is_denoised = self.denoise;
        let mut relmse = None;
        for path in &self.outputs {
            let mut fetched = client.image(&job.id, &self.image(path, job, is_denoised)?).await?;
            if let Fetched::CannotDenoise(problem) = fetched {
                terminal::note(&format!("the picture is written as it is: {problem}"));
                is_denoised = false;
                fetched = client.image(&job.id, &self.image(path, job, is_denoised)?).await?;
            }
            let Fetched::Image(image) = fetched else { return Ok(false) };
            relmse = relmse.or(image.denoised_relmse);
            let better = if self.overwrite { None } else { passes_if_better(path, job) };
            let target = better.map_or(path.clone(), |_| beside(path, job.passes_done));
            write_file(&target, &image.bytes)?;
            let kept = better.map_or(String::new(), |passes| {
                format!(
                    "; {} has {} of this scene and stays (--overwrite replaces it)",
                    path.display(),
                    passes_of(passes)
                )
            });
            terminal::note(&format!("wrote {}{kept}", target.display()));
        }
        if let Some(relmse) = relmse {
            terminal::note(&format!("denoised: relMSE {relmse:.2e}, as its two halves tell"));
        }
        Ok(true)
    }

    /// How pictures to look at are made of radiance.
    fn display(&self) -> String {
        let tone = self.tone.as_deref().unwrap_or(ToneCurve::Linear.row().name);
        format!("exposure={}&tone={tone}", self.exposure())
    }

    /// What is asked of a coordinator for a file. EXR files of jobs that keep light groups apart hold them.
    fn image(&self, path: &Path, job: &JobStatus, is_denoised: bool) -> Result<String, CliError> {
        let layer = if is_denoised { "&layer=denoised" } else { "" };
        let display = format!("{}{layer}", self.display());
        let denoised = if is_denoised { [Layer::Denoised, Layer::DenoisedError].as_slice() } else { &[] };
        let groups = if job.light_groups.is_empty() { [].as_slice() } else { &[Layer::LightGroups] };
        let further = denoised.iter().chain(groups).map(|layer| layer.row().name);
        let layers = self.layers.iter().map(String::as_str).chain(further);
        let layers = layers.collect::<Vec<_>>().join(",");
        Ok(match PictureFormat::of_path(path)? {
            PictureFormat::Exr => format!("image.exr?layers={layers}&half={}", self.half),
            PictureFormat::Png => format!("image.png?{display}&bits={}", self.bits.as_deref().unwrap_or("8")),
            PictureFormat::Jpeg => format!("image.jpg?{display}&quality={}", self.quality.unwrap_or(JPEG_QUALITY)),
            PictureFormat::Webp => format!("image.webp?{display}"),
        })
    }
}

/// The passes of the picture at `path` if it shows the job's scene after more of them. Only EXR files say so; the one of its name answers for others.
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

fn tone_names() -> PossibleValuesParser {
    TONES.map(|row| PossibleValue::new(row.name).help(row.meaning)).into()
}

/// `<name>.exr` and `<name>.png` in the current folder.
pub(super) fn default_outputs(scene: &Path) -> Vec<PathBuf> {
    let name = picture_name(scene);
    ["exr", "png"].map(|extension| name.with_added_extension(extension)).to_vec()
}
