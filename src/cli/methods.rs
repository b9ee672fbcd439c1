//! `methods`: what there is to choose from.

use clap::Args;

use super::exit_code::CliError;
use super::terminal;
use crate::api::methods::MethodView;
use crate::method::{MethodEntry, entry, table};

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
        let entries = match &self.name {
            Some(name) => vec![entry(name).map_err(|error| CliError::BadInput(error.to_string()))?],
            None => table().iter().collect(),
        };
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
    if !entry.also_called.is_empty() {
        lines.push(format!("  also called: {}", entry.also_called.join(", ")));
    }
    let width = entry.parameters.iter().map(|parameter| parameter.name.len()).max().unwrap_or(0);
    lines.extend(entry.parameters.iter().map(|parameter| {
        format!(
            "  {:width$}  {} ({}) [default: {}]",
            parameter.name, parameter.meaning, parameter.range, parameter.default
        )
    }));
    lines.join("\n")
}
