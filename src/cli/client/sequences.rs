//! Sequences of a coordinator.

use reqwest::Method;
use serde::Deserialize;

use super::{Client, accepted, checked_name};
use crate::api::sequences::SequenceSubmission;
use crate::cli::exit_code::CliError;
use crate::farm::sequence::SequenceStatus;

#[derive(Deserialize)]
struct SequenceList {
    sequences: Vec<SequenceStatus>,
}

impl Client {
    pub(in crate::cli) async fn submit_sequence(
        &self,
        submission: &SequenceSubmission,
    ) -> Result<SequenceStatus, CliError> {
        self.send_json(Method::POST, "/v1/sequences", submission).await
    }

    pub(in crate::cli) async fn sequence(&self, id: &str) -> Result<SequenceStatus, CliError> {
        self.json(self.request(Method::GET, &sequence_path(id, "")?)).await
    }

    pub(in crate::cli) async fn sequences(&self) -> Result<Vec<SequenceStatus>, CliError> {
        Ok(self.json::<SequenceList>(self.request(Method::GET, "/v1/sequences")).await?.sequences)
    }

    /// Does something to a sequence that needs no more than its name (`/cancel`, `/pause`, `/resume`).
    pub(in crate::cli) async fn control_sequence(&self, id: &str, what: &str) -> Result<SequenceStatus, CliError> {
        self.json(self.request(Method::POST, &sequence_path(id, what)?)).await
    }

    pub(in crate::cli) async fn delete_sequence(&self, id: &str) -> Result<(), CliError> {
        accepted(self.send(self.request(Method::DELETE, &sequence_path(id, "")?)).await?).await?;
        Ok(())
    }
}

/// The address of a sequence.
fn sequence_path(id: &str, rest: &str) -> Result<String, CliError> {
    Ok(format!("/v1/sequences/{}{rest}", checked_name(id, "a sequence's id; `photonfarm sequences`")?))
}
