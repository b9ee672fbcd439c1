//! The token that a command shows to the coordinator.

use std::path::{Path, PathBuf};

use clap::Args;

use super::exit_code::CliError;
use crate::farm::access::secret::Secret;

/// The variable of the environment that holds a token.
const VARIABLE: &str = "PHOTONFARM_TOKEN";

/// The token that a command shows to the coordinator. It is never an argument: those are seen by everybody on the machine.
#[derive(Clone, Debug, Args)]
pub(super) struct TokenOption {
    /// File with the token that the coordinator asks for [default: the token in PHOTONFARM_TOKEN].
    #[arg(long, env = "PHOTONFARM_TOKEN_FILE", value_name = "FILE")]
    token_file: Option<PathBuf>,
}

impl TokenOption {
    /// The token, if there is one.
    pub(super) fn read(&self) -> Result<Option<Secret>, CliError> {
        match (&self.token_file, std::env::var(VARIABLE)) {
            (Some(file), _) => token_file(file).map(Some),
            (None, Ok(text)) if !text.is_empty() => parse(&text, VARIABLE).map(Some),
            (None, _) => Ok(None),
        }
    }
}

/// The token in a file.
pub(super) fn token_file(file: &Path) -> Result<Secret, CliError> {
    let place = file.display();
    let text = std::fs::read_to_string(file)
        .map_err(|problem| CliError::File(format!("{place}: {problem}; give a readable file with a token")))?;
    parse(&text, &place.to_string())
}

fn parse(text: &str, place: &str) -> Result<Secret, CliError> {
    text.parse().map_err(|problem| CliError::BadInput(format!("{place} holds no token: {problem}")))
}
