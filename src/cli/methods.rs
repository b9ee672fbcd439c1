//! `methods`: what there is to choose from.

use clap::Args;

use super::exit_code::CliError;
use super::terminal;
use crate::api::methods::MethodView;
use crate::method::{MethodEntry, table};

/// List the methods with their parameters.
///
/// The first one is the default.
#[derive(Clone, Debug, Args)]
pub(super) struct Methods {
    /// Only this method.
    name: Option<String>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

impl Methods {
    pub(super) fn run(self) -> Result<(), CliError> {
        let wanted = |entry: &&MethodEntry| self.name.as_ref().is_none_or(|name| entry.name == name);
        let entries: Vec<&MethodEntry> = table().iter().filter(wanted).collect();
        if entries.is_empty() {
            let known: Vec<&str> = table().iter().map(|entry| entry.name).collect();
            let name = self.name.unwrap_or_default();
            return Err(CliError::BadInput(format!(
                "there is no method \"{name}\"; known names: {}",
                known.join(", ")
            )));
        }
        if self.json {
            return terminal::json(&entries.into_iter().map(MethodView::from).collect::<Vec<_>>());
        }
        terminal::result(&entries.into_iter().map(description).collect::<Vec<_>>().join("\n\n"))
    }
}

fn description(entry: &MethodEntry) -> String {
    let mut lines = vec![
        format!("{}: {}", entry.name, entry.summary),
        format!("  cannot sample: {}", entry.cannot_sample),
        format!("  reference: {}", entry.reference),
    ];
    let width = entry.parameters.iter().map(|parameter| parameter.name.len()).max().unwrap_or(0);
    lines.extend(entry.parameters.iter().map(|parameter| {
        format!(
            "  {:width$}  {} ({}) [default: {}]",
            parameter.name, parameter.meaning, parameter.range, parameter.default
        )
    }));
    lines.join("\n")
}
