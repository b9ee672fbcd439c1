//! `--preview`: the frames of a sequence as one animated picture.

use std::path::{Path, PathBuf};

use clap::Args;

use super::exit_code::CliError;
use super::frames::file_of_frame;
use super::terminal;
use crate::estimate::picture_files::{check_writable, encode_animated_png, write_file};

/// How the frames of a sequence are shown together.
#[derive(Clone, Debug, Args)]
pub(super) struct PreviewOptions {
    /// Of a sequence: also write all frames as one animated PNG, which browsers play.
    #[arg(long, value_name = "FILE.png")]
    preview: Option<PathBuf>,
    /// Frames per second of that.
    #[arg(long, default_value_t = 24, value_parser = clap::value_parser!(u16).range(1..=1000), requires = "preview")]
    frame_rate: u16,
}

impl PreviewOptions {
    /// Refuses a file that is no PNG or cannot be written, and a preview of one picture.
    pub(super) fn check(&self, is_of_sequence: bool) -> Result<(), CliError> {
        let Some(file) = &self.preview else { return Ok(()) };
        if !is_of_sequence {
            return Err(CliError::Usage(
                "--preview is of a sequence, and one picture is meant; leave it out".to_owned(),
            ));
        }
        if file.extension().is_none_or(|extension| extension != "png") {
            return Err(CliError::Usage(format!("--preview \"{}\" is no PNG; end its name in .png", file.display())));
        }
        Ok(check_writable(file)?)
    }

    /// Refuses a preview in the place of a frame.
    pub(super) fn check_apart(
        &self,
        outputs: &[PathBuf],
        mut numbers: impl Iterator<Item = u32>,
    ) -> Result<(), CliError> {
        let Some(file) = &self.preview else { return Ok(()) };
        let is_frame = |number: u32| outputs.iter().any(|output| file_of_frame(output, number) == *file);
        match numbers.find(|number| is_frame(*number)) {
            Some(number) => {
                let text = format!("--preview {} is the file of frame {number}; give another one", file.display());
                Err(CliError::Usage(text))
            }
            None => Ok(()),
        }
    }

    /// Whether there is to be one.
    pub(super) fn is_wanted(&self) -> bool {
        self.preview.is_some()
    }

    /// Writes it, if it is wanted.
    pub(super) fn write(&self, frames: &[Vec<u8>]) -> Result<(), CliError> {
        self.preview.as_deref().map_or(Ok(()), |file: &Path| {
            write_file(file, &encode_animated_png(frames, self.frame_rate)?)?;
            terminal::note(&format!("wrote {}", file.display()));
            Ok(())
        })
    }
}
