//! What a user changes of a scene: parameters that it declares, and its view.

use std::path::Path;

use clap::Args;

use super::exit_code::CliError;
use super::job_options::define;
use super::scene_file;
use super::scene_input::SceneInput;
use crate::import::changes::{Changes, Crop, Environment};
use crate::import::{load_changed, load_read};
use crate::scene::description::SceneDescription;

/// Changes of a scene of any format.
#[derive(Clone, Debug, Default, Args)]
pub(super) struct SceneOptions {
    /// Value of a scene parameter, in place of its <default>. May be repeated.
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = define)]
    pub(super) defines: Vec<(String, String)>,
    /// Size of the whole picture, pixels; a width alone keeps its proportions.
    #[arg(long, value_name = "W[xH]", value_parser = size)]
    size: Option<Size>,
    /// Part of the whole picture that is rendered: first column and row, width and height, pixels.
    #[arg(long, value_name = "X,Y,W,H", value_parser = crop)]
    crop: Option<Crop>,
    /// Camera, by its name or by its index, counted from 0 [default: the first].
    #[arg(long, value_name = "NAME|INDEX")]
    camera: Option<String>,
    /// Whether a white environment lights the scene [default: where a model has no light of its own].
    #[arg(long, value_name = "on|off", value_parser = environment)]
    environment: Option<Environment>,
    /// Moment that is shown of a scene in which things move, in the scene's own unit of time [default: where they begin].
    #[arg(long, value_name = "TIME", value_parser = moment, allow_negative_numbers = true)]
    time: Option<f64>,
}

/// The size of a picture, pixels.
#[derive(Clone, Copy, Debug)]
struct Size {
    width: u32,
    height: Option<u32>,
}

impl SceneOptions {
    /// Reads the scene with these changes.
    pub(super) fn load(&self, argument: &Path) -> Result<SceneDescription, CliError> {
        self.check_defines()?;
        let changes = self.changes();
        Ok(match SceneInput::open(argument)? {
            SceneInput::File(file) => load_changed(&file, &self.defines, &changes)?,
            SceneInput::Bytes(bytes) => load_read(SceneInput::read_scene(&bytes), &self.defines, &changes)?,
        })
    }

    /// The scene with everything it refers to and these changes, as bytes to upload.
    pub(super) fn pack(&self, argument: &Path) -> Result<Vec<u8>, CliError> {
        self.check_defines()?;
        scene_file::pack(argument, &self.defines, &self.changes())
    }

    /// Refuses a parameter that is given twice: the last one would win without a word.
    fn check_defines(&self) -> Result<(), CliError> {
        let is_repeated = |index: usize| self.defines[..index].iter().any(|(name, _)| *name == self.defines[index].0);
        match (0..self.defines.len()).find(|index| is_repeated(*index)) {
            Some(index) => {
                let name = &self.defines[index].0;
                Err(CliError::Usage(format!("-D \"{name}\" is given twice; give it once")))
            }
            None => Ok(()),
        }
    }

    /// What of them changes the scene that was read.
    pub(super) fn changes(&self) -> Changes {
        Changes {
            width: self.size.map(|size| size.width),
            height: self.size.and_then(|size| size.height),
            crop: self.crop,
            camera: self.camera.clone(),
            environment: self.environment,
            time: self.time,
            between_cameras: None,
        }
    }
}

fn pixels(text: &str) -> Option<u32> {
    text.trim().parse().ok().filter(|pixels| *pixels > 0)
}

fn size(text: &str) -> Result<Size, String> {
    let (width, height) = match text.split_once(['x', 'X', '×']) {
        Some((width, height)) => (pixels(width), pixels(height).map(Some)),
        None => (pixels(text), Some(None)),
    };
    width
        .zip(height)
        .map(|(width, height)| Size { width, height })
        .ok_or_else(|| "write a width, as 640, or a width and a height, as 640x480".to_owned())
}

fn crop(text: &str) -> Result<Crop, String> {
    let numbers: Vec<u32> = text.split(',').map_while(|number| number.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y, width, height] if width > 0 && height > 0 && text.split(',').count() == 4 => {
            Ok(Crop { x, y, width, height })
        }
        _ => Err("write first column, first row, width and height in pixels, as 100,50,320,240".to_owned()),
    }
}

fn moment(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|moment: &f64| moment.is_finite()).ok_or_else(|| "give a finite number".to_owned())
}

fn environment(text: &str) -> Result<Environment, String> {
    match text {
        "on" => Ok(Environment::On),
        "off" => Ok(Environment::Off),
        _ => Err("write on or off".to_owned()),
    }
}
