//! Pictures of jobs.

use reqwest::Method;

use super::{Client, accepted, job_path};
use crate::api::images::DENOISED_RELMSE;
use crate::cli::exit_code::CliError;
use crate::cli::terminal;

/// How often a picture is asked for whose layers are not there yet; each request waits for some seconds.
const WAITS: u32 = 30;

/// A picture as a file.
pub(in crate::cli) struct Image {
    pub(in crate::cli) bytes: Vec<u8>,
    /// What its own halves tell of the denoised picture's relMSE, where one was asked for.
    pub(in crate::cli) denoised_relmse: Option<f64>,
}

/// What came of asking for a picture.
pub(in crate::cli) enum Fetched {
    /// It is there.
    Image(Image),
    /// There is none yet.
    Nothing,
    /// There is one, and it cannot be denoised, for this reason.
    CannotDenoise(String),
}

impl Fetched {
    /// The file, where there is one.
    pub(in crate::cli) fn bytes(self) -> Option<Vec<u8>> {
        match self {
            Self::Image(image) => Some(image.bytes),
            Self::Nothing | Self::CannotDenoise(_) => None,
        }
    }
}

impl Client {
    /// The job's picture; `image` is the last part of its address. Waits for layers that a worker has to make.
    pub(in crate::cli) async fn image(&self, id: &str, image: &str) -> Result<Fetched, CliError> {
        let mut waits = WAITS;
        loop {
            let response = self.send(self.request(Method::GET, &job_path(id, &format!("/{image}"))?)).await?;
            match accepted(response).await {
                Ok(response) => {
                    let told = response.headers().get(DENOISED_RELMSE).and_then(|value| value.to_str().ok());
                    let denoised_relmse = told.and_then(|value| value.parse().ok());
                    let bytes = response.bytes().await.map_err(|error| self.unreachable(&error))?.to_vec();
                    return Ok(Fetched::Image(Image { bytes, denoised_relmse }));
                }
                Err(problem) if problem.slug() == "no-picture-yet" => return Ok(Fetched::Nothing),
                Err(problem) if problem.slug() == "cannot-denoise" => {
                    return Ok(Fetched::CannotDenoise(problem.detail));
                }
                // A worker has to look at the first surfaces; large scenes take a while.
                Err(problem) if problem.slug() == "not-yet" && waits > 0 => {
                    if waits == WAITS {
                        terminal::note(&format!("{}; waiting", problem.detail));
                    }
                    waits -= 1;
                }
                Err(problem) => return Err(problem.into()),
            }
        }
    }
}
