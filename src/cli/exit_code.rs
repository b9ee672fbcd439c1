//! Exit codes, and the errors that lead to them.

use std::fmt::Display;
use std::path::Path;
use std::process::ExitCode;

use super::scene_file::in_users_file;
use crate::api::problem::Problem;
use crate::estimate::picture_files::PictureFileError;
use crate::scene::error::SceneError;

/// The exit codes as `--help` tells them.
pub(super) const EXIT_CODES: &str = "\
Exit codes:
  0    done
  1    the job failed or was cancelled, or another error
  2    wrong usage: options that cannot be or do not fit together
  3    bad scene, method or parameters, or a file with other contents than it should have
  4    the coordinator cannot be reached, or refuses this worker
  5    a file cannot be read or written
  6    evaluate --compare found something worse
  130  interrupted";

/// Why a command did not do what was asked. The text says what, where and what to do about it.
#[derive(Debug, thiserror::Error)]
pub(super) enum CliError {
    /// The job failed, or anything that has no code of its own.
    #[error("{0}")]
    Failed(String),
    /// The command line by itself is wrong, whatever scenes and files hold: a value that cannot be, or options that do not fit together.
    #[error("{0}")]
    Usage(String),
    /// The scene, the method or a parameter is wrong, or what a file holds.
    #[error("{0}")]
    BadInput(String),
    /// No coordinator answers.
    #[error("{0}")]
    Unreachable(String),
    /// A file cannot be read or written.
    #[error("{0}")]
    File(String),
    /// A comparison of results found something worse.
    #[error("{0}")]
    Worse(String),
    /// The user asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl CliError {
    /// The process's exit code.
    pub(super) fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Failed(_) => 1,
            Self::Usage(_) => 2,
            Self::BadInput(_) => 3,
            Self::Unreachable(_) => 4,
            Self::File(_) => 5,
            Self::Worse(_) => 6,
            Self::Interrupted => 130,
        })
    }

    /// The same about a scene that was packed from the file at `path`.
    pub(super) fn about(self, path: &Path) -> Self {
        match self {
            Self::BadInput(text) => Self::BadInput(in_users_file(&text, path)),
            Self::Failed(text) => Self::Failed(in_users_file(&text, path)),
            other => other,
        }
    }

    /// An error without a code of its own.
    pub(super) fn failed(error: impl Display) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<SceneError> for CliError {
    fn from(error: SceneError) -> Self {
        Self::BadInput(error.to_string())
    }
}

impl From<PictureFileError> for CliError {
    fn from(error: PictureFileError) -> Self {
        match error {
            PictureFileError::Encode { .. } => Self::failed(error),
            PictureFileError::UnknownFormat { .. } => Self::Usage(error.to_string()),
            PictureFileError::UnknownLayer { .. } => Self::BadInput(error.to_string()),
            _ => Self::File(error.to_string()),
        }
    }
}

impl From<Problem> for CliError {
    fn from(problem: Problem) -> Self {
        let place = problem.place.as_ref().map(|place| format!("{place}: ")).unwrap_or_default();
        let remedy = problem.remedy.as_ref().map(|remedy| format!("; {remedy}")).unwrap_or_default();
        let text = format!("{place}{}{remedy}", problem.detail);
        match problem.status {
            400 | 413 | 415 | 422 => Self::BadInput(text),
            _ => Self::Failed(text),
        }
    }
}
