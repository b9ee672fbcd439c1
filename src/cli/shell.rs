//! `completions` and `manual`: what shells and `man` are to know of the command line.

use std::path::PathBuf;

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::exit_code::CliError;
use super::{CommandLine, terminal};

/// Print what a shell needs to complete commands and options.
///
/// For bash: `photonfarm completions bash > /etc/bash_completion.d/photonfarm`.
#[derive(Clone, Debug, Args)]
pub(super) struct Completions {
    /// The shell.
    shell: Shell,
}

impl Completions {
    pub(super) fn run(self) -> Result<(), CliError> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut CommandLine::command(), "photonfarm", &mut script);
        terminal::result(String::from_utf8_lossy(&script).trim_end())
    }
}

/// Write a manual page for each command into a folder.
#[derive(Clone, Debug, Args)]
pub(super) struct Manual {
    /// The folder, which exists.
    folder: PathBuf,
}

impl Manual {
    pub(super) fn run(self) -> Result<(), CliError> {
        clap_mangen::generate_to(CommandLine::command(), &self.folder).map_err(|error| {
            let folder = self.folder.display();
            CliError::File(format!(
                "cannot write manual pages into {folder}: {error}; name a folder that you may write to"
            ))
        })
    }
}
