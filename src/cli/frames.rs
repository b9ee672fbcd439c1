//! `--frames`: the pictures of a sequence, and what each shows of the scene.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::exit_code::CliError;
use super::scene_options::SceneOptions;
use crate::import::camera_path::BetweenCameras;
use crate::import::changes::Changes;
use crate::import::{UNNAMED, load_bytes};

/// Digits of a frame's number in the names of files and jobs.
const DIGITS: usize = 4;
/// The most frames at once.
const MOST_FRAMES: u32 = 100_000;

/// Random numbers of the frames of a sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FrameSeeds {
    /// Each has a seed of its own, `--seed` plus its number: noise flickers, as film grain does.
    Own,
    /// All have `--seed`: noise sticks to the picture, as dirt on the lens does.
    Same,
}

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
    /// Whether every frame has random numbers of its own.
    #[arg(long, value_enum, default_value = "own", requires = "frames")]
    frame_seeds: FrameSeeds,
}

/// One picture of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) number: u32,
    /// What of the scene is changed for it.
    pub(super) changes: Changes,
    /// What is added to the job's seed.
    pub(super) seed: u64,
}

impl Frame {
    /// `NAME.0001`.
    pub(super) fn name(&self, name: &str) -> String {
        format!("{name}.{:0DIGITS$}", self.number)
    }

    /// `NAME.0001.exr` of `NAME.exr`.
    pub(super) fn file(&self, path: &Path) -> PathBuf {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let mut name = self.name(&stem);
        if let Some(extension) = path.extension() {
            name += &format!(".{}", extension.to_string_lossy());
        }
        path.with_file_name(name)
    }
}

impl FrameOptions {
    /// The frames of a packed scene, in order; `None` where one picture is wanted.
    pub(super) fn of(&self, scene: &[u8], options: &SceneOptions) -> Result<Option<Vec<Frame>>, CliError> {
        let Some(frames) = self.frames.clone() else { return Ok(None) };
        let sequence = self.sequence.clone().unwrap_or_else(|| frames.clone());
        self.check(&frames, &sequence, options)?;
        let moves = load_bytes(UNNAMED, scene, &[])?.moves;
        if moves.is_none() && self.camera_path.is_empty() {
            let text =
                "nothing in the scene moves, so that all frames would be alike; give key frames, or --camera-path";
            return Err(CliError::BadInput(text.to_owned()));
        }
        // Key frames outside of --times are no reason to move a scene that has none.
        let times = moves.map(|moves| self.times.unwrap_or(moves));
        let length = f64::from(sequence.end() - sequence.start()).max(1.0);
        let frame = |number: u32| {
            let share = f64::from(number - sequence.start()) / length;
            let changes = Changes {
                time: times.map(|[start, end]| start + (end - start) * share),
                between_cameras: self.between_cameras(share),
                ..Changes::default()
            };
            let seed = if self.frame_seeds == FrameSeeds::Own { u64::from(number) } else { 0 };
            Frame { number, changes, seed }
        };
        Ok(Some(frames.map(frame).collect()))
    }

    fn check(
        &self,
        frames: &RangeInclusive<u32>,
        sequence: &RangeInclusive<u32>,
        options: &SceneOptions,
    ) -> Result<(), CliError> {
        let shown = |range: &RangeInclusive<u32>| format!("{}-{}", range.start(), range.end());
        let refused = |text: String| Err(CliError::Usage(text));
        if frames.start() < sequence.start() || frames.end() > sequence.end() {
            return refused(format!(
                "--frames {} leaves --sequence {}; give a part of it",
                shown(frames),
                shown(sequence)
            ));
        }
        if options.has_time() {
            return refused("--time is of one picture; give --times with --frames".to_owned());
        }
        if self.camera_path.len() == 1 {
            return refused("--camera-path has one camera; give two or more, or --camera".to_owned());
        }
        if !self.camera_path.is_empty() && options.has_camera() {
            return refused("--camera and --camera-path exclude each other; give one of them".to_owned());
        }
        Ok(())
    }

    /// The place on the camera's path, at a share of it.
    fn between_cameras(&self, share: f64) -> Option<BetweenCameras> {
        let ways = self.camera_path.len().checked_sub(1).filter(|ways| *ways > 0)?;
        let position = share * ways as f64;
        let way = (position as usize).min(ways - 1);
        let [from, to] = [way, way + 1].map(|index| self.camera_path[index].clone());
        Some(BetweenCameras { from, to, share: position - way as f64 })
    }
}

fn frames(text: &str) -> Result<RangeInclusive<u32>, String> {
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    match (first.trim().parse::<u32>(), last.trim().parse::<u32>()) {
        (Ok(first), Ok(last)) if first <= last && last - first < MOST_FRAMES => Ok(first..=last),
        _ => Err(format!("write the first and the last frame, as 1-48, at most {MOST_FRAMES} frames")),
    }
}

fn times(text: &str) -> Result<[f64; 2], String> {
    let moment = |text: &str| text.trim().parse().ok().filter(|moment: &f64| moment.is_finite());
    let both = text.split_once(',').and_then(|(start, end)| moment(start).zip(moment(end)));
    both.map(|(start, end)| [start, end]).ok_or_else(|| "write two moments, as 0,2.5".to_owned())
}
