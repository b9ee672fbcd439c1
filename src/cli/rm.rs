//! `rm`: deletes a job and its pictures, or a scene.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;
use super::frames::is_sequence;
use super::terminal;

/// Delete a job and its pictures, a sequence and all of its jobs, or a scene that no job refers to.
///
/// What runs is cancelled first.
#[derive(Clone, Debug, Args)]
pub(super) struct Remove {
    /// The id of the job or sequence.
    #[arg(required_unless_present = "scene")]
    id: Option<String>,
    /// The scene's hash.
    #[arg(long, value_name = "HASH", conflicts_with = "id")]
    scene: Option<String>,
    /// Print what was deleted as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Remove {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let client = self.coordinator.client()?;
        if let Some(id) = &self.id {
            if is_sequence(id) {
                client.delete_sequence(id).await?;
            } else {
                client.delete_job(id).await?;
            }
        }
        if let Some(hash) = &self.scene {
            client.delete_scene(hash).await?;
        }
        let deleted = serde_json::json!({ "deleted": self.id.or(self.scene) });
        if self.json { terminal::json(&deleted) } else { Ok(()) }
    }
}
