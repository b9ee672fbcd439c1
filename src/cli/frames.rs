//! `--frames`: the pictures of a sequence.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use clap::Args;

use super::exit_code::CliError;
use super::named::named;
use super::scene_options::SceneOptions;
use crate::farm::ids::SequenceId;
use crate::farm::sequence::{BadFrames, Frame, FrameSeeds, Frames, MOST_FRAMES, numbered};
use crate::import::{UNNAMED, load_bytes};

/// Which frames of a sequence are rendered.
#[derive(Clone, Debug, Args)]
pub(super) struct FrameOptions {
    /// Render a sequence from its first frame to its last, as 1-48: what moves in the scene goes from its first key frame to its last one.
    #[arg(long, value_name = "FIRST-LAST", value_parser = frames)]
    frames: Option<RangeInclusive<u32>>,
    /// First and last frame of the whole sequence, where --frames are a part of it [default: --frames].
    #[arg(long, value_name = "FIRST-LAST", value_parser = frames, requires = "frames")]
    sequence: Option<RangeInclusive<u32>>,
    /// Moments that the whole sequence's first and last frame show [default: when things begin and cease to move].
    #[arg(long, value_name = "START,END", value_parser = times, requires = "frames", allow_hyphen_values = true)]
    times: Option<[f64; 2]>,
    /// Cameras by name or index, separated by commas: the camera goes straight from one to the next, each way in the same time.
    #[arg(long, value_name = "CAMERA,CAMERA…", value_delimiter = ',', requires = "frames")]
    camera_path: Vec<String>,
    /// Whether every frame has random numbers of its own, the seed plus its number, or all have the same.
    #[arg(long, value_parser = named(FrameSeeds::ALL, FrameSeeds::name), default_value = FrameSeeds::default().name(), requires = "frames")]
    frame_seeds: FrameSeeds,
}

impl FrameOptions {
    /// Which frames are wanted; `None` where one picture is.
    pub(super) fn frames(&self, options: &SceneOptions) -> Result<Option<Frames>, CliError> {
        let Some(range) = &self.frames else { return Ok(None) };
        let frames = Frames {
            first: *range.start(),
            last: *range.end(),
            whole: self.sequence.as_ref().map(|whole| [*whole.start(), *whole.end()]),
            times: self.times,
            camera_path: self.camera_path.clone(),
            seeds: self.frame_seeds,
        };
        frames.check(&options.changes()).map_err(|problem| CliError::Usage(told(&problem)))?;
        Ok(Some(frames))
    }

    /// The frames of a packed scene, in order; `None` where one picture is wanted.
    pub(super) fn of(&self, scene: &[u8], options: &SceneOptions) -> Result<Option<Vec<Frame>>, CliError> {
        let Some(frames) = self.frames(options)? else { return Ok(None) };
        let moves = load_bytes(UNNAMED, scene, &[])?.moves;
        let moments = frames.moments(moves).map_err(|problem| CliError::BadInput(told(&problem)))?;
        Ok(Some(frames.all(moments).collect()))
    }
}

fn told(problem: &BadFrames) -> String {
    format!("{problem}; {}", problem.remedy())
}

/// `NAME.0001.exr` of `NAME.exr`.
pub(super) fn file_of_frame(path: &Path, number: u32) -> PathBuf {
    let mut name = numbered(&path.file_stem().unwrap_or_default().to_string_lossy(), number);
    if let Some(extension) = path.extension() {
        name += &format!(".{}", extension.to_string_lossy());
    }
    path.with_file_name(name)
}

/// Whether an id is that of a sequence.
pub(super) fn is_sequence(id: &str) -> bool {
    id.parse::<SequenceId>().is_ok()
}

fn frames(text: &str) -> Result<RangeInclusive<u32>, String> {
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    match (first.trim().parse::<u32>(), last.trim().parse::<u32>()) {
        (Ok(first), Ok(last)) if first > last => Err(format!("{first} is after {last}; write the first frame first")),
        (Ok(first), Ok(last)) if last - first >= MOST_FRAMES => Err(format!("write at most {MOST_FRAMES} frames")),
        (Ok(first), Ok(last)) => Ok(first..=last),
        _ => Err("write the first and the last frame, as 1-48".to_owned()),
    }
}

fn times(text: &str) -> Result<[f64; 2], String> {
    let moment = |text: &str| text.trim().parse().ok().filter(|moment: &f64| moment.is_finite());
    let both = text.split_once(',').and_then(|(start, end)| moment(start).zip(moment(end)));
    both.map(|(start, end)| [start, end]).ok_or_else(|| "write two moments, as 0,2.5".to_owned())
}
