//! Sequences: many pictures of one scene, each a job of its own. What is asked for, what each frame shows, and what users are told.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::access::user::UserName;
use super::job::{JobRequest, JobState, Priority, SceneChanges, StopRule};
use crate::import::camera_path::BetweenCameras;

/// Digits of a frame's number in the names of files and jobs, at least.
const DIGITS: usize = 4;
/// The most frames of a sequence.
pub const MOST_FRAMES: u32 = 100_000;

/// The most cameras on a path.
const MOST_CAMERAS: usize = 1000;
/// The most bytes of a camera's name there.
const LONGEST_NAME: usize = 1000;

/// Random numbers of the frames of a sequence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum FrameSeeds {
    /// Each frame has a seed of its own, the job's plus the frame's number: noise flickers, as film grain does.
    #[default]
    Own,
    /// All frames have the job's seed: noise sticks to the picture, as dirt on the lens does.
    Same,
}

impl FrameSeeds {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Own, Self::Same];

    /// Its name in JSON and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Own => "own",
            Self::Same => "same",
        }
    }
}

/// Which pictures a sequence has, and what each shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Frames {
    /// Number of the first frame.
    pub first: u32,
    /// Number of the last frame; there are at most 100,000.
    pub last: u32,
    /// Numbers of the first and the last frame of the whole sequence, where these frames are a part of it; `first` and `last` by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub whole: Option<[u32; 2]>,
    /// Moments that the first and the last frame of the whole sequence show, in the scene's own unit of time; when things begin and cease to move
    /// by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub times: Option<[f64; 2]>,
    /// Cameras by name or index: the camera goes straight from one to the next, each way in the same time. Two or more, or none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub camera_path: Vec<String>,
    /// Whether each frame has random numbers of its own, `own` by default, or all have the `same`.
    #[serde(default)]
    pub seeds: FrameSeeds,
}

/// One picture of a sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Its number.
    pub number: u32,
    /// What of the scene is changed for it.
    pub changes: SceneChanges,
    /// What is added to the job's seed.
    pub seed: u64,
}

/// Frames that cannot be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadFrames {
    /// There is none.
    #[error("the last frame, {last}, is before the first one, {first}")]
    Order {
        /// The first one.
        first: u32,
        /// The last one.
        last: u32,
    },
    /// There are too many.
    #[error("frames {first} to {last} are more than {MOST_FRAMES}")]
    Count {
        /// The first one.
        first: u32,
        /// The last one.
        last: u32,
    },
    /// They are no part of the sequence.
    #[error("frames {first} to {last} leave the sequence of {} to {}", whole[0], whole[1])]
    Outside {
        /// The first one.
        first: u32,
        /// The last one.
        last: u32,
        /// The first and the last one of the sequence.
        whole: [u32; 2],
    },
    /// A moment that is no number.
    #[error("the moments of the first and the last frame are no numbers, or too far apart")]
    Moments,
    /// The picture of one moment, and a sequence of them.
    #[error("a sequence shows many moments, and one is given")]
    OneMoment,
    /// More cameras, or longer names, than are kept.
    #[error(
        "the camera's path has more than {MOST_CAMERAS} cameras, or one whose name has more than {LONGEST_NAME} bytes"
    )]
    LongPath,
    /// No way has one end.
    #[error("the camera's path has one camera")]
    OneCamera,
    /// A camera that stands and one that goes.
    #[error("a camera and a camera's path exclude each other")]
    TwoCameras,
    /// All pictures would be alike.
    #[error("nothing in the scene moves, so that all frames would be alike")]
    Still,
}

impl BadFrames {
    /// What the user can do.
    pub const fn remedy(&self) -> &'static str {
        match self {
            Self::Order { .. } => "give the first one first",
            Self::Count { .. } => "give fewer",
            Self::Outside { .. } => "give a part of it",
            Self::Moments => "give two that are closer",
            Self::OneMoment => "give those of its first and its last frame",
            Self::LongPath => "give fewer cameras, or their indices",
            Self::OneCamera => "give two or more, or choose a camera",
            Self::TwoCameras => "give one of them",
            Self::Still => "give key frames, or a camera's path",
        }
    }
}

impl Frames {
    /// Checks what needs no scene, beside what else is changed of it.
    ///
    /// # Errors
    /// Whatever is wrong, but [`BadFrames::Still`].
    pub fn check(&self, changes: &SceneChanges) -> Result<(), BadFrames> {
        let (first, last, whole) = (self.first, self.last, self.whole());
        if first > last {
            return Err(BadFrames::Order { first, last });
        }
        if last - first >= MOST_FRAMES {
            return Err(BadFrames::Count { first, last });
        }
        if first < whole[0] || last > whole[1] {
            return Err(BadFrames::Outside { first, last, whole });
        }
        if self.times.is_some_and(|[start, end]| !start.is_finite() || !(end - start).is_finite()) {
            return Err(BadFrames::Moments);
        }
        if changes.time.is_some() {
            return Err(BadFrames::OneMoment);
        }
        if self.camera_path.len() == 1 {
            return Err(BadFrames::OneCamera);
        }
        if self.camera_path.len() > MOST_CAMERAS || self.camera_path.iter().any(|name| name.len() > LONGEST_NAME) {
            return Err(BadFrames::LongPath);
        }
        let has_camera = changes.camera.is_some() || changes.between_cameras.is_some();
        if has_camera && !self.camera_path.is_empty() { Err(BadFrames::TwoCameras) } else { Ok(()) }
    }

    /// The moments that the whole sequence's first and last frame show of a scene that moves from one moment to another, or does not.
    ///
    /// # Errors
    /// [`BadFrames::Still`].
    pub fn moments(&self, moves: Option<[f64; 2]>) -> Result<Option<[f64; 2]>, BadFrames> {
        if moves.is_none() && self.camera_path.is_empty() {
            return Err(BadFrames::Still);
        }
        // Moments are no reason to move a scene that has no key frames.
        Ok(moves.map(|moves| self.times.unwrap_or(moves)))
    }

    /// How many there are.
    pub fn count(&self) -> u32 {
        self.last - self.first + 1
    }

    /// All frames, in order, between these [moments](Self::moments).
    pub fn all(&self, moments: Option<[f64; 2]>) -> impl Iterator<Item = Frame> {
        (self.first..=self.last).map(move |number| self.frame(number, moments))
    }

    /// One frame.
    pub fn frame(&self, number: u32, moments: Option<[f64; 2]>) -> Frame {
        let [start, end] = self.whole();
        let share = f64::from(number - start) / f64::from(end - start).max(1.0);
        let changes = SceneChanges {
            time: moments.map(|[start, end]| start + (end - start) * share),
            between_cameras: self.between_cameras(share),
            ..SceneChanges::default()
        };
        let seed = if self.seeds == FrameSeeds::Own { u64::from(number) } else { 0 };
        Frame { number, changes, seed }
    }

    fn whole(&self) -> [u32; 2] {
        self.whole.unwrap_or([self.first, self.last])
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

/// `NAME.0001`.
pub fn numbered(name: &str, number: u32) -> String {
    format!("{name}.{number:0DIGITS$}")
}

/// How many frames of a sequence are jobs that have not ended, 1 to 100 and 2 by default.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(try_from = "u8", into = "u8")]
#[schema(value_type = u8, minimum = 1, maximum = 100)]
pub struct AtOnce(u8);

/// A number of frames that is none of those.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0} frames at once; give 1 to {most}", most = AtOnce::MOST)]
pub struct BadAtOnce(u8);

impl AtOnce {
    /// The most.
    pub const MOST: u8 = 100;

    /// The number.
    pub fn get(self) -> usize {
        usize::from(self.0)
    }
}

impl Default for AtOnce {
    fn default() -> Self {
        Self(2)
    }
}

impl TryFrom<u8> for AtOnce {
    type Error = BadAtOnce;

    fn try_from(number: u8) -> Result<Self, BadAtOnce> {
        if (1..=Self::MOST).contains(&number) { Ok(Self(number)) } else { Err(BadAtOnce(number)) }
    }
}

impl From<AtOnce> for u8 {
    fn from(at_once: AtOnce) -> Self {
        at_once.0
    }
}

/// A sequence to be rendered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SequenceRequest {
    /// What all frames have in common; the scene is the one that each of them changes.
    pub job: JobRequest,
    /// What is changed of the scene in all frames.
    pub changes: SceneChanges,
    /// Which frames.
    pub frames: Frames,
    /// How many at once.
    pub at_once: AtOnce,
}

/// What a sequence is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SequenceState {
    /// Its frames are rendered.
    Running,
    /// Nothing is rendered until it is resumed.
    Paused,
    /// All frames have ended, none by a failure.
    Done,
    /// A frame failed; `error` says why.
    Failed,
    /// Stopped by a user, or all of its frames were; the pictures so far are kept.
    Cancelled,
}

impl SequenceState {
    /// Its name in JSON and tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Running => "running",
            Self::Paused => "paused",
            Self::Done => "done",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }

    /// Whether it goes on by itself, now or when it is resumed.
    pub const fn is_live(self) -> bool {
        matches!(self, Self::Running | Self::Paused)
    }
}

/// A frame that is a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FrameJob {
    /// The frame's number.
    pub frame: u32,
    /// The job's id.
    pub job: String,
    /// What it is doing.
    pub state: JobState,
    /// Passes merged into its picture.
    pub passes_done: u32,
    /// Passes at which it stops; empty when these do not count.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub passes_total: Option<u32>,
}

/// How a sequence is doing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SequenceStatus {
    /// The sequence's id.
    pub id: String,
    /// What it is doing.
    pub state: SequenceState,
    /// Why it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Why no further frame becomes a job for now, for example because its owner has as many jobs as allowed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub waiting: Option<String>,
    /// Who submitted it, where there are users.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub owner: Option<UserName>,
    /// What people call it. Its jobs are called so with the frame's number behind it, as `lamp.0001`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Words to find it by; its jobs have them, too.
    pub tags: Vec<String>,
    /// The share of the farm that each frame has which is rendered.
    pub priority: Priority,
    /// When it was submitted, seconds since 1970.
    pub submitted: u64,
    /// Hash of the scene that each frame changes.
    pub scene: String,
    /// When each frame is done; empty for the method's own passes.
    pub stop: StopRule,
    /// Which frames.
    pub frames: Frames,
    /// How many are rendered at once.
    pub at_once: AtOnce,
    /// How many frames there are.
    pub frames_total: u32,
    /// Frames that are done.
    pub frames_done: u32,
    /// Frames that failed.
    pub frames_failed: u32,
    /// How much of all is done, 0 to 1, parts of frames included.
    pub progress: f64,
    /// Estimated seconds left; empty while no frame is done, and when none is left.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds_left: Option<f64>,
    /// The frames that are jobs by now, in order, where one sequence is asked for. Those of deleted jobs are missing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub jobs: Vec<FrameJob>,
}
