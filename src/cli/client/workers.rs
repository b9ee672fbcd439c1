//! Workers, and what happened.

use reqwest::Method;
use serde::Deserialize;

use super::{Client, checked_name};
use crate::api::workers::{Journal, JournalLine, JournalQuery};
use crate::cli::exit_code::CliError;
use crate::farm::job::WorkerStatus;

#[derive(Deserialize)]
struct WorkerList {
    workers: Vec<WorkerStatus>,
}

impl Client {
    pub(in crate::cli) async fn workers(&self) -> Result<Vec<WorkerStatus>, CliError> {
        Ok(self.json::<WorkerList>(self.request(Method::GET, "/v1/workers")).await?.workers)
    }

    pub(in crate::cli) async fn drain_worker(&self, id: &str) -> Result<WorkerStatus, CliError> {
        let path = format!("/v1/workers/{}/drain", checked_name(id, "a worker's number; `photonfarm workers`")?);
        self.json(self.request(Method::POST, &path)).await
    }

    pub(in crate::cli) async fn journal(&self, query: &JournalQuery) -> Result<Vec<JournalLine>, CliError> {
        Ok(self.json::<Journal>(self.request(Method::GET, "/v1/journal").query(query)).await?.lines)
    }
}
