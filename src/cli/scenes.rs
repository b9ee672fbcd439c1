//! `scenes`: a coordinator's scenes.

use clap::Args;

use super::client::CoordinatorOption;
use super::exit_code::CliError;
use super::terminal;
use crate::farm::SceneSummary;

/// List a coordinator's scenes.
///
/// Hash, size in bytes, width, height, integrator, separated by tabs.
#[derive(Clone, Debug, Args)]
pub(super) struct Scenes {
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    coordinator: CoordinatorOption,
}

impl Scenes {
    pub(super) async fn run(self) -> Result<(), CliError> {
        let scenes = self.coordinator.client()?.scenes().await?;
        if self.json {
            return terminal::json(&scenes);
        }
        terminal::heads(&["HASH", "BYTES", "WIDTH", "HEIGHT", "INTEGRATOR"])?;
        for scene in scenes {
            let integrator = scene.integrator.as_deref().unwrap_or("-");
            let SceneSummary { hash, bytes, width, height, .. } = &scene;
            terminal::result(&format!("{hash}\t{bytes}\t{width}\t{height}\t{integrator}"))?;
        }
        Ok(())
    }
}
